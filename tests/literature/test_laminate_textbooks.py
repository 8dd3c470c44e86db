"""Plies and laminates against worked examples of textbooks and the composite crank-rocker.

Kaw, *Mechanics of Composite Materials*, 2nd ed. 2006; Jones, *Mechanics of Composite
Materials*, 2nd ed. 1999, secs. 4.3.2-4.3.3 (closed forms of regular laminates); Reddy,
*Mechanics of Laminated Composite Plates and Shells*, 2nd ed. 2004; Elamy et al. 2023 with the
corrections of its Table 2.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexmech.materials import (
    Fibre,
    Laminate,
    Layer,
    Matrix,
    Ply,
    ply_from_constituents,
    propagated_uncertainty,
    published_constituents,
)

# Half a unit of the fourth digit that Kaw prints, of the smallest such number.
FOUR_DIGITS = 5e-4

GLASS = Fibre("glass", 85e9, 35.42e9, 2500.0, 0.2, thermal_expansion=5e-6)
EPOXY = Matrix(
    "epoxy", 3.4e9, 1.308e9, 1200.0, 0.3, thermal_expansion=63e-6, moisture_expansion=0.33
)
GRAPHITE_EPOXY = Ply(181e9, 10.3e9, 7.17e9, 7.17e9, 3.8e9, 0.28, 1600.0)


def stiffness(ply: Ply, degrees: float) -> NDArray[np.float64]:
    return Layer(ply, 1.0, np.radians(degrees)).transformed_stiffness


# ---- Kaw -----------------------------------------------------------------------------------


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


def test_moisture_expansion_in_kaws_units() -> None:
    """By moisture over the dry mass of the ply, not of its resin (Kaw, ch. 3)."""
    ply = ply_from_constituents(GLASS, EPOXY, 0.7)
    by_ply = np.array(ply.moisture_expansion) * ply.density / (0.3 * EPOXY.density)
    along = 3.4e9 / 60.52e9 * 2110 / 1200 * 0.33
    np.testing.assert_allclose(by_ply, [along, 1.3 * 2110 / 1200 * 0.33 - along * 0.23])


def test_kaw_2_6_and_2_7_stiffness_of_a_graphite_epoxy_ply() -> None:
    np.testing.assert_allclose(
        stiffness(GRAPHITE_EPOXY, 0.0) / 1e9,
        [[181.8, 2.897, 0], [2.897, 10.35, 0], [0, 0, 7.17]],
        rtol=FOUR_DIGITS,
    )
    np.testing.assert_allclose(
        stiffness(GRAPHITE_EPOXY, 60.0) / 1e9,
        [[23.65, 32.46, 20.05], [32.46, 109.4, 54.19], [20.05, 54.19, 36.74]],
        rtol=FOUR_DIGITS,
    )


def test_kaw_4_4_in_plane_moduli_of_0_90_0() -> None:
    laminate = Laminate.stacked([GRAPHITE_EPOXY] * 3, 5e-3, np.radians([0, 90, 0]))
    flexibility = np.linalg.inv(laminate.stiffness_moment(0)) * laminate.thickness
    moduli = 1 / np.diag(flexibility) / 1e9
    np.testing.assert_allclose(moduli, [124.5, 67.43, 7.17], rtol=FOUR_DIGITS)
    assert -flexibility[0, 1] / flexibility[0, 0] == pytest.approx(0.04292, rel=FOUR_DIGITS)


# ---- Jones: regular cross-ply and angle-ply laminates ----------------------------------------


def cross_ply(count: int, ratio: float, thickness: float) -> Laminate:
    """Layers at 0 and 90 degrees in turn; 0 over 90 degrees is ``ratio`` in thickness."""
    number_of = {0: (count + 1) // 2, 1: count // 2}
    share = {0: ratio / (1 + ratio), 1: 1 / (1 + ratio)}
    return Laminate(
        tuple(
            Layer(
                GRAPHITE_EPOXY,
                thickness * share[k % 2] / number_of[k % 2],
                k % 2 * np.pi / 2,
            )
            for k in range(count)
        )
    )


@pytest.mark.parametrize("count", [3, 5, 9])
@pytest.mark.parametrize("ratio", [0.4, 1.0, 3.0])
def test_jones_symmetric_cross_ply(count: int, ratio: float) -> None:
    m, n, t = ratio, count, 2e-3
    laminate = cross_ply(n, m, t)
    q = GRAPHITE_EPOXY.reduced_stiffness[0, 0]
    f = GRAPHITE_EPOXY.transverse_modulus / GRAPHITE_EPOXY.longitudinal_modulus
    p = (1 + m * (n - 3) * (m * (n - 1) + 2 * (n + 1)) / (n**2 - 1)) / (1 + m) ** 3
    membrane, bending = laminate.stiffness_moment(0), laminate.stiffness_moment(2)
    assert membrane[0, 0] == pytest.approx((m + f) / (1 + m) * q * t)
    assert membrane[1, 1] == pytest.approx((1 + m * f) / (1 + m) * q * t)
    assert bending[0, 0] == pytest.approx(((f - 1) * p + 1) * q * t**3 / 12)
    assert bending[1, 1] == pytest.approx(((1 - f) * p + f) * q * t**3 / 12)
    np.testing.assert_allclose(laminate.stiffness_moment(1), 0, atol=1e-12 * q * t**2)


@pytest.mark.parametrize("count", [2, 4, 10])
@pytest.mark.parametrize("ratio", [0.4, 1.0, 3.0])
def test_jones_unsymmetric_cross_ply(count: int, ratio: float) -> None:
    m, n, t = ratio, count, 2e-3
    laminate = cross_ply(n, m, t)
    q = GRAPHITE_EPOXY.reduced_stiffness[0, 0]
    f = GRAPHITE_EPOXY.transverse_modulus / GRAPHITE_EPOXY.longitudinal_modulus
    r = 1 / (1 + m) + 8 * m * (m - 1) / (n**2 * (1 + m) ** 3)
    coupling, bending = laminate.stiffness_moment(1), laminate.stiffness_moment(2)
    assert coupling[0, 0] == pytest.approx(m * (f - 1) / (n * (1 + m) ** 2) * q * t**2)
    assert coupling[1, 1] == pytest.approx(-coupling[0, 0])
    assert bending[0, 0] == pytest.approx(((f - 1) * r + 1) * q * t**3 / 12)
    assert bending[1, 1] == pytest.approx(((1 - f) * r + f) * q * t**3 / 12)


@pytest.mark.parametrize("count", [2, 4, 10])
def test_jones_unsymmetric_angle_ply(count: int) -> None:
    """The classical [+45/-45]: shear couples to bending only, and fades with more layers."""
    angles = np.radians(45 * (-1.0) ** np.arange(count))
    laminate = Laminate.stacked([GRAPHITE_EPOXY] * count, 2e-3 / count, angles)
    membrane, coupling, bending = (laminate.stiffness_moment(order) for order in (0, 1, 2))
    once = stiffness(GRAPHITE_EPOXY, 45.0)
    expected = np.zeros((3, 3))
    expected[[0, 1, 2, 2], [2, 2, 0, 1]] = -once[0, 2] * 2e-3**2 / (2 * count)
    np.testing.assert_allclose(coupling, expected, atol=1e-12 * once[0, 0] * 2e-3**2)
    np.testing.assert_allclose(membrane[:2, :2], once[:2, :2] * 2e-3)
    np.testing.assert_allclose(bending[:2, :2], once[:2, :2] * 2e-3**3 / 12)
    np.testing.assert_allclose(membrane[:2, 2], 0, atol=1e-12 * once[0, 0] * 2e-3)
    np.testing.assert_allclose(bending[:2, 2], 0, atol=1e-12 * once[0, 0] * 2e-3**3)


def test_jones_quasi_isotropic_0_60_minus_60() -> None:
    laminate = Laminate.stacked([GRAPHITE_EPOXY] * 3, 1e-3, np.radians([0, 60, -60]))
    a = laminate.stiffness_moment(0)
    assert a[0, 0] == pytest.approx(a[1, 1])
    assert a[2, 2] == pytest.approx((a[0, 0] - a[0, 1]) / 2)
    np.testing.assert_allclose(a[:2, 2], 0, atol=1e-12 * a[0, 0])


# ---- Reddy: the third-order integrals --------------------------------------------------------


def test_reddy_third_order_integrals_of_0_90() -> None:
    """Closed forms of eq. 11.2.11 for two layers; the signs are of 0 degrees below."""
    laminate = Laminate.stacked([GRAPHITE_EPOXY] * 2, 1e-3, [0.0, np.pi / 2])
    q, h = GRAPHITE_EPOXY.reduced_stiffness, 2e-3
    total, gap = q[0, 0] + q[1, 1], q[0, 0] - q[1, 1]
    assert laminate.stiffness_moment(3)[0, 0] == pytest.approx(-gap * h**4 / 64)
    assert laminate.stiffness_moment(3)[1, 1] == pytest.approx(gap * h**4 / 64)
    assert laminate.stiffness_moment(4)[0, 0] == pytest.approx(total * h**5 / 160)
    assert laminate.stiffness_moment(6)[0, 0] == pytest.approx(total * h**7 / 896)
    assert laminate.stiffness_moment(4)[0, 1] == pytest.approx(q[0, 1] * h**5 / 80)
    shear = 7.17e9 + 3.8e9
    for order, factor in ((0, 2), (2, 24), (4, 160)):
        expected = np.diag([shear, shear]) * h ** (order + 1) / factor
        np.testing.assert_allclose(
            laminate.shear_moment(order), expected, atol=1e-12 * expected[0, 0]
        )


# ---- Elamy et al. 2023 -----------------------------------------------------------------------

STACKINGS = ("CCCCC", "CCGCC", "CGCGC", "GCGCG", "GGCGG", "GGGGG")
PRINTED_DENSITY = (1538, 1640, 1742, 1844, 1946, 2048)


def elamy(fibre: str, rule: str = "rule-of-mixtures") -> Ply:
    table = published_constituents()
    return ply_from_constituents(table[fibre], table["polyester"], 0.6, rule)  # type: ignore[arg-type]


def elamy_laminates() -> list[Laminate]:
    plies = {"C": elamy("carbon"), "G": elamy("E-glass")}
    return [
        Laminate.stacked([plies[letter] for letter in stacking], 1e-3, [0.0] * 5)
        for stacking in STACKINGS
    ]


def flexibility(laminate: Laminate) -> NDArray[np.float64]:
    a, b, d = (laminate.stiffness_moment(order) for order in (0, 1, 2))
    return np.linalg.inv(np.block([[a, b], [b, d]]))


@pytest.mark.parametrize("rule", ["rule-of-mixtures", "halpin-tsai", "chamis"])
def test_elamy_plies(rule: str) -> None:
    carbon, glass = elamy("carbon", rule), elamy("E-glass", rule)
    assert carbon.longitudinal_modulus == pytest.approx(121.872e9)
    assert glass.longitudinal_modulus == pytest.approx(42.972e9)
    assert carbon.density == pytest.approx(1542.4)
    assert glass.density == pytest.approx(2046.4)


def test_elamy_membrane_moduli_fall_in_equal_steps() -> None:
    moduli = [
        1 / (laminate.thickness * flexibility(laminate)[0, 0]) / 1e9
        for laminate in elamy_laminates()
    ]
    np.testing.assert_allclose(moduli, np.linspace(121.872, 42.972, 6), rtol=1e-5)


def test_elamy_densities() -> None:
    density = [laminate.mass_moment(0) / laminate.thickness for laminate in elamy_laminates()]
    np.testing.assert_allclose(density, np.linspace(1542.4, 2046.4, 6))
    np.testing.assert_allclose(density, PRINTED_DENSITY, rtol=3e-3)


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
