"""Stiffness of laminates against textbooks, another library, and what cannot be a laminate.

Jones, *Mechanics of Composite Materials*, 2nd ed. 1999, secs. 4.3.2-4.3.3 (regular laminates); Kaw,
*Mechanics of Composite Materials*, 2nd ed. 2006; Nettles, *Basic Mechanics of Laminated Composite
Plates*, NASA RP-1351, 1994; Reddy, *Mechanics of Laminated Composite Plates and Shells*, 2nd ed.
2004.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from composites import laminated_plate
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech import InputError, Laminate, Material, Ply
from flexmech.materials import Layer, PlyDamping
from tests.support.strategies import angles, numbers

GRAPHITE_EPOXY = Ply(181e9, 10.3e9, 7.17e9, 7.17e9, 3.8e9, 0.28, 1600.0)
# Half a unit of the fourth digit that Kaw prints, of the smallest such number.
FOUR_DIGITS = 5e-4


@st.composite
def plies(draw: st.DrawFn) -> Ply:
    along, across = draw(numbers(1e9, 400e9)), draw(numbers(1e9, 50e9))
    shear = [draw(numbers(0.1e9, 30e9)) for _ in range(3)]
    ratio = draw(numbers(-0.9, 0.9)) * np.sqrt(along / across)
    return Ply(along, across, *shear, ratio, draw(numbers(500.0, 8000.0)))


@st.composite
def laminates(draw: st.DrawFn) -> Laminate:
    count = draw(st.integers(1, 8))
    return Laminate(
        tuple(Layer(draw(plies()), draw(numbers(5e-5, 5e-3)), draw(angles())) for _ in range(count))
    )


@settings(max_examples=20)
@given(laminates())
def test_integrals_through_the_thickness_are_those_of_another_library(laminate: Laminate) -> None:
    """Stiffness, shear and mass by powers of y up to the sixth, of the library `composites`."""
    layers, half = laminate.layers, laminate.thickness / 2
    other = laminated_plate(
        [np.degrees(layer.angle) for layer in layers],
        plyts=[layer.thickness for layer in layers],
        laminaprops=[
            (
                ply.longitudinal_modulus,
                ply.transverse_modulus,
                ply.poisson_ratio,
                ply.in_plane_shear_modulus,
                ply.longitudinal_shear_modulus,
                ply.transverse_shear_modulus,
            )
            for ply in (layer.ply for layer in layers)
        ],
        rhos=[layer.ply.density for layer in layers],
    )
    softest = np.abs(laminate.transformed_stiffness).max(axis=(1, 2)).min()
    softest_in_shear = np.abs(laminate.transformed_shear_stiffness).max(axis=(1, 2)).min()
    lightest = min(layer.ply.density for layer in layers)
    stiffness = {"A": 0, "B": 1, "D": 2, "E": 3, "F": 4, "H": 6}
    shear = {"Abar_ts": 0, "Dts": 2, "Fts": 4}
    mass = {f"intrho{power}": order for order, power in enumerate(["", "z", "z2", "z3", "z4"])}
    for integral, least, names in (
        (laminate.stiffness_moment, softest, stiffness),
        (laminate.shear_moment, softest_in_shear, shear),
        (laminate.mass_moment, lightest, mass),
    ):
        for name, order in names.items():
            # To 1e-10 of what the integral of its size could be, whatever cancels in it.
            size = 2 * least * half ** (order + 1) / (order + 1)
            expected = np.asarray(getattr(other, name))
            np.testing.assert_allclose(integral(order), expected, rtol=0, atol=1e-10 * size)


def stiffness(ply: Ply, degrees: float) -> np.ndarray:
    return Layer(ply, 1.0, np.radians(degrees)).transformed_stiffness


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


def test_stiffness_of_nettles_examples_1_2_and_9() -> None:
    """In lb and in; the report rounds the smaller Poisson's ratio to 0.02, as done here.

    Plies are counted from the top there, here from below.
    """
    rounded = (1 - 0.3**2 * 1.301 / 20.01) / (1 - 0.3 * 0.02)
    moduli = rounded * 20_010_000.0, rounded * 1_301_000.0
    ply = Ply(*moduli, 1_001_000.0, 1_001_000.0, 1_001_000.0, 0.3, 1.0)
    printed = [
        [6_557_237, 4_555_238, 4_705_483],
        [4_555_238, 6_557_237, 4_705_483],
        [4_705_483, 4_705_483, 5_163_582],
    ]
    np.testing.assert_allclose(stiffness(ply, 45.0), printed, atol=1)
    two = Laminate.stacked([ply] * 2, 0.005, np.radians([45.0, 0.0]))
    printed = [[170, -52, -59], [-52, -66, -59], [-59, -59, -52]]
    np.testing.assert_allclose(two.stiffness_moment(1), printed, atol=0.51)
    three = Laminate.stacked([ply] * 3, 0.005, np.radians([90.0, 0.0, 45.0]))
    printed = [[139_984, 26_703, 23_527], [26_703, 139_984, 23_527], [23_527, 23_527, 35_828]]
    np.testing.assert_allclose(three.stiffness_moment(0), printed, atol=1)
    printed_b = [[131.2, 104, 117.6], [104, -339.4, 117.6], [117.6, 117.6, 104]]
    np.testing.assert_allclose(three.stiffness_moment(1), printed_b, atol=0.5)


def cross_ply(count: int, ratio: float, thickness: float) -> Laminate:
    """Layers at 0 and 90 degrees in turn; 0 over 90 degrees is ``ratio`` in thickness."""
    number_of = {0: (count + 1) // 2, 1: count // 2}
    share = {0: ratio / (1 + ratio), 1: 1 / (1 + ratio)}
    return Laminate(
        tuple(
            Layer(GRAPHITE_EPOXY, thickness * share[k % 2] / number_of[k % 2], k % 2 * np.pi / 2)
            for k in range(count)
        )
    )


@pytest.mark.parametrize(("n", "m"), [(3, 0.4), (9, 3.0)])
def test_jones_symmetric_cross_ply(n: int, m: float) -> None:
    t, laminate = 2e-3, cross_ply(n, m, 2e-3)
    q = GRAPHITE_EPOXY.reduced_stiffness[0, 0]
    f = GRAPHITE_EPOXY.transverse_modulus / GRAPHITE_EPOXY.longitudinal_modulus
    p = (1 + m * (n - 3) * (m * (n - 1) + 2 * (n + 1)) / (n**2 - 1)) / (1 + m) ** 3
    membrane, bending = laminate.stiffness_moment(0), laminate.stiffness_moment(2)
    assert membrane[0, 0] == pytest.approx((m + f) / (1 + m) * q * t)
    assert membrane[1, 1] == pytest.approx((1 + m * f) / (1 + m) * q * t)
    assert bending[0, 0] == pytest.approx(((f - 1) * p + 1) * q * t**3 / 12)
    assert bending[1, 1] == pytest.approx(((1 - f) * p + f) * q * t**3 / 12)
    np.testing.assert_allclose(laminate.stiffness_moment(1), 0, atol=1e-12 * q * t**2)


@pytest.mark.parametrize(("n", "m"), [(2, 0.4), (10, 3.0)])
def test_jones_unsymmetric_cross_ply(n: int, m: float) -> None:
    t, laminate = 2e-3, cross_ply(n, m, 2e-3)
    q = GRAPHITE_EPOXY.reduced_stiffness[0, 0]
    f = GRAPHITE_EPOXY.transverse_modulus / GRAPHITE_EPOXY.longitudinal_modulus
    r = 1 / (1 + m) + 8 * m * (m - 1) / (n**2 * (1 + m) ** 3)
    coupling, bending = laminate.stiffness_moment(1), laminate.stiffness_moment(2)
    assert coupling[0, 0] == pytest.approx(m * (f - 1) / (n * (1 + m) ** 2) * q * t**2)
    assert coupling[1, 1] == pytest.approx(-coupling[0, 0])
    assert bending[0, 0] == pytest.approx(((f - 1) * r + 1) * q * t**3 / 12)
    assert bending[1, 1] == pytest.approx(((1 - f) * r + f) * q * t**3 / 12)


@pytest.mark.parametrize("count", [2, 10])
def test_jones_unsymmetric_angle_ply(count: int) -> None:
    """[+45/-45]: shear couples to bending only, and fades with more layers."""
    turned = np.radians(45 * (-1.0) ** np.arange(count))
    laminate = Laminate.stacked([GRAPHITE_EPOXY] * count, 2e-3 / count, turned)
    membrane, coupling, bending = (laminate.stiffness_moment(order) for order in (0, 1, 2))
    once = stiffness(GRAPHITE_EPOXY, 45.0)
    expected = np.zeros((3, 3))
    expected[[0, 1, 2, 2], [2, 2, 0, 1]] = -once[0, 2] * 2e-3**2 / (2 * count)
    np.testing.assert_allclose(coupling, expected, atol=1e-12 * once[0, 0] * 2e-3**2)
    np.testing.assert_allclose(membrane[:2, :2], once[:2, :2] * 2e-3)
    np.testing.assert_allclose(membrane[:2, 2], 0, atol=1e-12 * once[0, 0] * 2e-3)
    np.testing.assert_allclose(bending[:2, :2], once[:2, :2] * 2e-3**3 / 12)


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
    for order, factor in ((0, 2), (2, 24), (4, 160)):
        expected = (7.17e9 + 3.8e9) * h ** (order + 1) / factor * np.eye(2)
        np.testing.assert_allclose(
            laminate.shear_moment(order), expected, atol=1e-12 * expected[0, 0]
        )


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(GRAPHITE_EPOXY, transverse_modulus=0.0), "transverse_modulus of a ply"),
        (lambda: replace(GRAPHITE_EPOXY, density=np.nan), "density of a ply"),
        (lambda: replace(GRAPHITE_EPOXY, poisson_ratio=4.2), "poisson_ratio.*E1 / E2"),
        (lambda: replace(GRAPHITE_EPOXY, thermal_expansion=(0.0,)), "thermal_expansion of a ply"),
        (lambda: PlyDamping(shear=-0.01), "shear specific damping"),
        (lambda: Layer(GRAPHITE_EPOXY, -1e-3), "thickness of a layer"),
        (lambda: Layer(GRAPHITE_EPOXY, 1e-3, np.nan), "angle of a layer"),
        (lambda: Laminate(()), "one layer or more"),
        (
            lambda: Laminate((Layer(GRAPHITE_EPOXY, 1e-3), Layer(GRAPHITE_EPOXY, 1e-16))),
            "too little to compute with",
        ),
        (lambda: Material(0.0, 7800.0, 0.3), "youngs_modulus"),
        (lambda: Material(200e9, -1.0, 0.3), "density"),
        (lambda: Material(200e9, 7800.0, 0.5), "poisson_ratio"),
        (lambda: Material(70e9, 2700.0, fatigue=97e6), "FatigueStrength"),  # type: ignore[arg-type]
    ],
)
def test_what_cannot_be_a_material_or_a_laminate_is_refused(
    make: Callable[[], object], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        make()
