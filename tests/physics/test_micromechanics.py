"""From fibre and resin to a ply: worked examples, closed forms, bounds, expansion, uncertainty.

Kaw, *Mechanics of Composite Materials*, 2nd ed. 2006, ch. 3; Chamis, *SAMPE Quarterly* 1984; Hashin
& Rosen 1964 and Hashin 1965; Adams & Bacon 1973; Elamy et al. 2023, Tables 1 and 2.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.materials import (
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

# Half a unit of the fourth digit that Kaw prints, of the smallest such number.
FOUR_DIGITS = 5e-4
GLASS = Fibre("glass", 85e9, 35.42e9, 2500.0, 0.2, thermal_expansion=5e-6)
EPOXY = Matrix(
    "epoxy", 3.4e9, 1.308e9, 1200.0, 0.3, thermal_expansion=63e-6, moisture_expansion=0.33
)


def test_kaw_3_1_and_3_3_to_3_6_rule_of_mixtures() -> None:
    ply = ply_from_constituents(GLASS, EPOXY, 0.7, "rule-of-mixtures")
    assert ply.density == pytest.approx(2110)
    assert ply.longitudinal_modulus == pytest.approx(60.52e9, rel=FOUR_DIGITS)
    assert ply.transverse_modulus == pytest.approx(10.37e9, rel=FOUR_DIGITS)
    assert ply.poisson_ratio == pytest.approx(0.230)
    assert ply.in_plane_shear_modulus == pytest.approx(4.014e9, rel=FOUR_DIGITS)


def test_kaw_3_7_and_3_8_halpin_tsai() -> None:
    ply = ply_from_constituents(GLASS, EPOXY, 0.7, "halpin-tsai")
    assert ply.transverse_modulus == pytest.approx(20.20e9, rel=FOUR_DIGITS)
    assert ply.in_plane_shear_modulus == pytest.approx(6.169e9, rel=FOUR_DIGITS)


def test_kaw_3_17_thermal_expansion() -> None:
    along, across = ply_from_constituents(GLASS, EPOXY, 0.7).thermal_expansion
    assert along == pytest.approx(5.978e-6, rel=FOUR_DIGITS)
    assert across == pytest.approx(27.40e-6, rel=FOUR_DIGITS)


@pytest.mark.parametrize(
    ("fibre", "modulus", "spread"), [("carbon", 121.9, 12.0), ("E-glass", 43.0, 8.4)]
)
def test_elamy_uncertainty_of_the_plies(fibre: str, modulus: float, spread: float) -> None:
    """The fibre's printed uncertainty is all that counts: 0.6 of 20 and of 14 GPa."""
    table = published_constituents()

    def along(*parts: Fibre | Matrix) -> float:
        return ply_from_constituents(*parts, 0.6).longitudinal_modulus / 1e9  # type: ignore[arg-type]

    parts = (table[fibre], table["polyester"])
    assert along(*parts) == pytest.approx(modulus, abs=0.05)
    assert propagated_uncertainty(along, parts) == pytest.approx(spread, abs=0.005)


few = settings(max_examples=20)
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
RESIN = Matrix("epoxy", 4e9, 4e9 / 2.6, 1260.0, 0.3, specific_damping=0.09)


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


def test_chamis_by_hand() -> None:
    """Root of the fibre share: 0.64 gives 0.8."""
    ply = ply_from_constituents(CARBON, RESIN, 0.64, "chamis")
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


def test_expansion_along_balances_the_forces_of_fibre_and_resin() -> None:
    fibre = replace(CARBON, thermal_expansion=-0.5e-6)
    resin = replace(RESIN, thermal_expansion=6e-5, moisture_expansion=0.3)
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


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"youngs_modulus": -1.0}, "youngs_modulus of 'carbon'"),
        ({"poisson_ratio": 0.5}, "poisson_ratio of 'carbon'.*less than 0.5"),
        ({"specific_damping": -0.1}, "specific_damping of 'carbon'"),
        ({"moisture_expansion": -0.1}, "moisture_expansion of 'carbon'"),
        ({"thermal_expansion": np.inf}, "thermal_expansion of 'carbon'"),
        ({"transverse_modulus": 0.0}, "transverse_modulus of 'carbon'"),
        ({"uncertainty": {"stiffness": 1.0}}, "'stiffness', which is no property .* density"),
    ],
)
def test_a_constituent_that_cannot_be_is_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        replace(published_constituents()["carbon"], **change)


def test_fibres_above_the_packing_limit_and_unknown_rules_are_refused() -> None:
    """Round fibres touch at pi / sqrt(12) of the volume."""
    assert ply_from_constituents(CARBON, RESIN, np.pi / np.sqrt(12)).density > 0
    for share in (0.0, 0.91, 60.0):
        with pytest.raises(InputError, match=r"fibre_volume_fraction .* 0\.9069"):
            ply_from_constituents(CARBON, RESIN, share)
    with pytest.raises(InputError, match="chamis, halpin-tsai, rule-of-mixtures"):
        ply_from_constituents(CARBON, RESIN, 0.6, "voigt")  # type: ignore[arg-type]
