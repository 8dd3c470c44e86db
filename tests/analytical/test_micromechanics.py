"""From fibre and resin to a ply: closed forms, bounds and limits that hold for any of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.materials import (
    PACKING_LIMIT,
    RULES,
    Fibre,
    Laminate,
    Matrix,
    Ply,
    PlyDamping,
    Rule,
    ply_from_constituents,
    propagated_uncertainty,
    published_constituents,
    woven_ply,
)
from tests.support.strategies import numbers

few = settings(max_examples=20)
every_rule = pytest.mark.parametrize("rule", RULES)

CARBON = Fibre(
    "carbon",
    230e9,
    30e9,
    1760.0,
    0.2,
    specific_damping=0.004,
    transverse_modulus=20e9,
    transverse_shear_modulus=7e9,
)
EPOXY = Matrix("epoxy", 4e9, 4e9 / 2.6, 1260.0, 0.3, specific_damping=0.09)


def shares() -> st.SearchStrategy[float]:
    return numbers(0.01, 0.9)


@st.composite
def fibres(draw: st.DrawFn) -> Fibre:
    return Fibre(
        "fibre",
        draw(numbers(50e9, 400e9)),
        draw(numbers(5e9, 100e9)),
        draw(numbers(1200.0, 2600.0)),
        draw(numbers(0.1, 0.4)),
        thermal_expansion=draw(numbers(-1e-6, 1e-5)),
        specific_damping=draw(numbers(0.0, 0.02)),
        transverse_modulus=draw(numbers(8e9, 50e9)),
        transverse_shear_modulus=draw(numbers(4e9, 20e9)),
    )


@st.composite
def resins(draw: st.DrawFn) -> Matrix:
    modulus, poisson_ratio = draw(numbers(1e9, 6e9)), draw(numbers(0.2, 0.45))
    return Matrix(
        "resin",
        modulus,
        modulus / (2 * (1 + poisson_ratio)),
        1200.0,
        poisson_ratio,
        thermal_expansion=draw(numbers(2e-5, 1e-4)),
        moisture_expansion=draw(numbers(0.1, 0.5)),
        specific_damping=draw(numbers(0.0, 0.3)),
    )


def moduli(ply: Ply) -> np.ndarray:
    return np.array(
        [
            ply.longitudinal_modulus,
            ply.transverse_modulus,
            ply.in_plane_shear_modulus,
            ply.longitudinal_shear_modulus,
            ply.transverse_shear_modulus,
        ]
    )


def losses(ply: Ply) -> np.ndarray:
    loss = ply.specific_damping
    return np.array([loss.longitudinal, loss.transverse, loss.shear])


# ---- moduli ----------------------------------------------------------------------------------


def test_chamis_by_hand() -> None:
    """Root of the fibre share: 0.64 gives 0.8."""
    ply = ply_from_constituents(CARBON, EPOXY, 0.64, "chamis")
    assert ply.longitudinal_modulus == pytest.approx(0.64 * 230e9 + 0.36 * 4e9)
    assert ply.transverse_modulus == pytest.approx(4e9 / (1 - 0.8 * (1 - 4 / 20)))
    resin = 4e9 / 2.6
    assert ply.in_plane_shear_modulus == pytest.approx(resin / (1 - 0.8 * (1 - resin / 30e9)))
    assert ply.longitudinal_shear_modulus == ply.in_plane_shear_modulus
    assert ply.transverse_shear_modulus == pytest.approx(resin / (1 - 0.8 * (1 - resin / 7e9)))
    assert ply.poisson_ratio == pytest.approx(0.64 * 0.2 + 0.36 * 0.3)
    assert ply.density == pytest.approx(0.64 * 1760 + 0.36 * 1260)


@few
@given(fibres(), resins(), shares())
def test_halpin_tsai_in_shear_is_hashins_cylinders_and_lower_bound(
    fibre: Fibre, resin: Matrix, share: float
) -> None:
    """Hashin & Rosen 1964 along the fibres; Hashin 1965 and Hill 1964 across them."""
    ply = ply_from_constituents(fibre, resin, share, "halpin-tsai")
    gf, gm, rest = fibre.shear_modulus, resin.shear_modulus, 1 - share
    cylinders = gm * (gf * (1 + share) + gm * rest) / (gf * rest + gm * (1 + share))
    assert ply.in_plane_shear_modulus == pytest.approx(cylinders)
    bulk = gm / (1 - 2 * resin.poisson_ratio)  # in plane strain
    over = 1 / (fibre.shear_modulus_across - gm)
    bound = gm + share / (over + rest * (bulk + 2 * gm) / (2 * gm * (bulk + gm)))
    assert ply.transverse_shear_modulus == pytest.approx(bound)


@few
@given(fibres(), resins(), shares(), st.sampled_from(RULES))
def test_moduli_lie_between_layers_in_series_and_in_parallel(
    fibre: Fibre, resin: Matrix, share: float, rule: Rule
) -> None:
    own = np.array([fibre.youngs_modulus, fibre.modulus_across, *[fibre.shear_modulus] * 2])
    own = np.append(own, fibre.shear_modulus_across)
    around = np.array([resin.youngs_modulus] * 2 + [resin.shear_modulus] * 3)
    found = moduli(ply_from_constituents(fibre, resin, share, rule))
    slack = 1e-12 * found
    parallel = share * own + (1 - share) * around
    if rule == "chamis":  # too stiff with few fibres
        above = np.sqrt(share) * (own / around - 1) < 1
        above[0] = False
        assert np.all(found[above] >= parallel[above] - slack[above])
        parallel[above] = np.inf
    assert np.all(found >= 1 / (share / own + (1 - share) / around) - slack)
    assert np.all(found <= parallel + slack)


@every_rule
def test_moduli_grow_with_the_fibres(rule: Rule) -> None:
    found = [
        moduli(ply_from_constituents(CARBON, EPOXY, share, rule))
        for share in np.linspace(0.01, PACKING_LIMIT, 12)
    ]
    assert np.all(np.diff(found, axis=0) > 0)


@few
@given(resins(), shares(), st.sampled_from(RULES))
def test_fibres_of_resin_change_nothing(resin: Matrix, share: float, rule: Rule) -> None:
    same = {
        name: getattr(resin, name)
        for name in (
            "youngs_modulus",
            "shear_modulus",
            "density",
            "poisson_ratio",
            "thermal_expansion",
            "moisture_expansion",
            "specific_damping",
        )
    }
    ply = ply_from_constituents(Fibre("same", **same), resin, share, rule)
    young, shear = resin.youngs_modulus, resin.shear_modulus
    np.testing.assert_allclose(moduli(ply), [young, young, shear, shear, shear])
    np.testing.assert_allclose(losses(ply), resin.specific_damping, atol=1e-15)
    assert ply.density == pytest.approx(resin.density)
    assert ply.thermal_expansion == pytest.approx((resin.thermal_expansion,) * 2)
    assert ply.moisture_expansion == pytest.approx((resin.moisture_expansion,) * 2)


# ---- damping ---------------------------------------------------------------------------------


@few
@given(fibres(), resins(), shares(), st.sampled_from(RULES))
def test_along_the_fibres_resin_and_fibre_lose_by_their_stiffness(
    fibre: Fibre, resin: Matrix, share: float, rule: Rule
) -> None:
    """Adams & Bacon 1973: psi_m (1 - V) E_m / E_1, and the fibre's share."""
    ply = ply_from_constituents(fibre, resin, share, rule)
    expected = (
        resin.specific_damping * (1 - share) * resin.youngs_modulus
        + fibre.specific_damping * share * fibre.youngs_modulus
    ) / ply.longitudinal_modulus
    assert ply.specific_damping.longitudinal == pytest.approx(expected, abs=1e-15)


@few
@given(fibres(), resins(), shares())
def test_in_shear_hashins_cylinders_with_fibres_that_lose_nothing(
    fibre: Fibre, resin: Matrix, share: float
) -> None:
    """Closed form in Adams & Bacon 1973 and Adams 1987, from Hashin 1970."""
    ply = ply_from_constituents(replace(fibre, specific_damping=0.0), resin, share, "halpin-tsai")
    ratio = fibre.shear_modulus / resin.shear_modulus
    above = (ratio + 1) ** 2 + share * (ratio - 1) ** 2
    below = (ratio * (1 + share) + 1 - share) * (ratio * (1 - share) + 1 + share)
    expected = resin.specific_damping * (1 - share) * above / below
    assert ply.specific_damping.shear == pytest.approx(expected, abs=1e-15)


@few
@given(fibres(), resins(), shares())
def test_chamis_strips_lose_across_the_fibres(fibre: Fibre, resin: Matrix, share: float) -> None:
    """Saravanos & Chamis 1990: series of a strip with fibres and one of resin."""
    ply = ply_from_constituents(fibre, resin, share, "chamis")
    width = np.sqrt(share)
    across = ply.transverse_modulus * (
        fibre.specific_damping * width / fibre.modulus_across
        + resin.specific_damping * (1 - width) / resin.youngs_modulus
    )
    shear = ply.in_plane_shear_modulus * (
        fibre.specific_damping * width / fibre.shear_modulus
        + resin.specific_damping * (1 - width) / resin.shear_modulus
    )
    assert ply.specific_damping.transverse == pytest.approx(across, abs=1e-15)
    assert ply.specific_damping.shear == pytest.approx(shear, abs=1e-15)


@few
@given(fibres(), resins(), shares(), st.sampled_from(RULES))
def test_the_losses_lie_between_those_of_fibre_and_resin(
    fibre: Fibre, resin: Matrix, share: float, rule: Rule
) -> None:
    found = losses(ply_from_constituents(fibre, resin, share, rule))
    least, most = sorted((fibre.specific_damping, resin.specific_damping))
    assert np.all(found >= least - 1e-15)
    assert np.all(found <= most + 1e-15)


# ---- expansion -------------------------------------------------------------------------------


def test_expansion_along_balances_the_forces_of_fibre_and_resin() -> None:
    fibre = replace(CARBON, thermal_expansion=-0.5e-6)
    resin = replace(EPOXY, thermal_expansion=6e-5, moisture_expansion=0.3)
    ply = ply_from_constituents(fibre, resin, 0.6)
    along, across = ply.thermal_expansion
    force = 0.6 * 230e9 * (along + 0.5e-6) + 0.4 * 4e9 * (along - 6e-5)
    assert force == pytest.approx(0, abs=1e-9 * 230e9 * 6e-5)
    # Singh & Sanyal 2022, eq. 8, corrected: with 1 + nu_m.
    assert across == pytest.approx(
        0.6 * 1.2 * -0.5e-6 + 0.4 * 1.3 * 6e-5 - along * ply.poisson_ratio
    )
    along, across = ply.moisture_expansion
    assert along == pytest.approx(0.4 * 4e9 * 0.3 / ply.longitudinal_modulus)
    assert across == pytest.approx(0.4 * 1.3 * 0.3 - along * ply.poisson_ratio)


# ---- woven plies -----------------------------------------------------------------------------


@few
@given(fibres(), resins(), shares(), st.sampled_from(RULES))
def test_a_woven_ply_is_the_membrane_of_crossed_layers(
    fibre: Fibre, resin: Matrix, share: float, rule: Rule
) -> None:
    single = ply_from_constituents(fibre, resin, share, rule)
    woven = woven_ply(single)
    crossed = Laminate.stacked([single] * 2, 0.5, [0.0, np.pi / 2])
    membrane = crossed.stiffness_moment(0)
    np.testing.assert_allclose(
        woven.reduced_stiffness, membrane, rtol=1e-11, atol=1e-12 * membrane[0, 0]
    )
    np.testing.assert_allclose(
        woven.transverse_shear_stiffness, crossed.shear_moment(0), rtol=1e-11, atol=1e-3
    )
    assert woven.longitudinal_modulus == woven.transverse_modulus
    assert woven.density == single.density
    # Free expansion: that of a pair of layers without force.
    free = np.array([*single.thermal_expansion, 0.0])
    own = single.reduced_stiffness @ free
    expansion = np.linalg.solve(membrane, (own + own[[1, 0, 2]]) / 2)
    np.testing.assert_allclose(woven.thermal_expansion, expansion[:2], rtol=1e-9)


def test_a_woven_ply_loses_by_the_energy_of_its_halves() -> None:
    """By hand, without Poisson's ratio: along and across share as their moduli."""
    loss = PlyDamping(0.01, 0.07, 0.1)
    single = Ply(100e9, 10e9, 5e9, 5e9, 3e9, 0.0, 1600.0, specific_damping=loss)
    woven = woven_ply(single)
    assert woven.longitudinal_modulus == pytest.approx(55e9)
    stretched = (100 * 0.01 + 10 * 0.07) / 110
    assert losses(woven) == pytest.approx([stretched, stretched, 0.1])
    assert woven.longitudinal_shear_modulus == woven.transverse_shear_modulus == 4e9


def test_a_fabric_of_fabric_is_the_same_fabric() -> None:
    once = woven_ply(ply_from_constituents(CARBON, EPOXY, 0.5))
    np.testing.assert_allclose(moduli(woven_ply(once)), moduli(once))
    np.testing.assert_allclose(losses(woven_ply(once)), losses(once))


# ---- uncertainties ---------------------------------------------------------------------------


def test_uncertainty_of_a_sum_is_exact() -> None:
    """Both plies share the resin, whose density varies in both together."""
    table = published_constituents()
    parts = (table["carbon"], table["E-glass"], table["polyester"])

    def mass(carbon: Fibre, glass: Fibre, resin: Matrix) -> float:
        plies = [ply_from_constituents(fibre, resin, 0.6) for fibre in (carbon, glass, glass)]
        return Laminate.stacked(plies, 1e-3, [0.0] * 3).mass_moment(0)

    # Only carbon and resin have a printed uncertainty of density, 10 kg/m^3 each.
    expected = np.hypot(0.6 * 10 * 1e-3, 0.4 * 10 * 3e-3)
    assert propagated_uncertainty(mass, parts) == pytest.approx(expected)


def test_uncertainty_of_layers_in_series_is_the_derivative() -> None:
    table = published_constituents()
    carbon, polyester = table["carbon"], table["polyester"]

    def shear(fibre: Fibre, resin: Matrix) -> float:
        return ply_from_constituents(fibre, resin, 0.6, "rule-of-mixtures").in_plane_shear_modulus

    whole = shear(carbon, polyester)  # type: ignore[arg-type]
    fibre = 0.6 * (whole / carbon.shear_modulus) ** 2 * 642e6
    resin = 0.4 * (whole / polyester.shear_modulus) ** 2 * 0.2e6
    found = propagated_uncertainty(shear, (carbon, polyester))
    assert found == pytest.approx(np.hypot(fibre, resin), rel=1e-5)


def test_what_has_no_uncertainty_has_none() -> None:
    def modulus(fibre: Fibre, resin: Matrix) -> float:
        return ply_from_constituents(fibre, resin, 0.6).transverse_modulus

    assert propagated_uncertainty(modulus, (CARBON, EPOXY)) == 0
