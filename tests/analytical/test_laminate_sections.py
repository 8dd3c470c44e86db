"""Sections of laminates against closed forms, hand-worked stacks and another library.

Stacks are named from the lowest layer up; a bar along the link is 0 degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from composites import laminated_plate
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from flexmech.materials import Laminate, Layer, Material, Ply, PlyDamping
from flexmech.sections import BeamSection, LaminateSection, Reduction
from tests.support.strategies import numbers

FloatArray = NDArray[np.float64]
STEEL = Material(200e9, 7800.0, 0.3)
B, H = 0.02, 0.005
AREA = B * H
# Graphite-epoxy with E1 / E2 = 25, G13 / E2 = 0.5, G23 / E2 = 0.2 (Pagano 1970).
PAGANO = Ply(25.0, 1.0, 0.5, 0.5, 0.2, 0.25, 1.0)
LOSSY = Ply(138e9, 9e9, 6e9, 5e9, 3e9, 0.3, 1600.0, specific_damping=PlyDamping(0.005, 0.06, 0.08))


def plain(modulus: float, density: float = 1000.0, poisson: float = 0.0) -> Ply:
    return Ply.isotropic(Material(modulus, density, poisson))


def one_layer(ply: Ply, angle: float = 0.0, reduction: Reduction = "narrow") -> LaminateSection:
    return LaminateSection(Laminate((Layer(ply, H, angle),)), B, reduction)


def stack(
    ply: Ply, degrees: Sequence[float], thickness: float, reduction: Reduction = "narrow"
) -> LaminateSection:
    """Section 1 m wide."""
    laminate = Laminate.stacked(
        [ply] * len(degrees), thickness / len(degrees), np.radians(degrees).tolist()
    )
    return LaminateSection(laminate, 1.0, reduction)


# ---- one material --------------------------------------------------------------------------


def test_isotropic_rectangle() -> None:
    section = one_layer(Ply.isotropic(STEEL))
    assert section.axial_stiffness == pytest.approx(200e9 * AREA, rel=1e-13)
    assert section.bending_stiffness == pytest.approx(200e9 * B * H**3 / 12, rel=1e-13)
    assert section.shear_stiffness == pytest.approx(5 / 6 * STEEL.shear_modulus * AREA, rel=1e-13)
    assert section.shear_correction == pytest.approx(5 / 6, rel=1e-13)
    assert section.mass_per_length == pytest.approx(7800 * AREA)
    assert section.rotary_inertia == pytest.approx(7800 * B * H**3 / 12)
    assert (section.coupling_stiffness, section.neutral_axis, section.mass_axis) == (0, 0, 0)


def test_isotropic_rectangle_in_third_order_theory() -> None:
    third = one_layer(Ply.isotropic(STEEL)).third_order
    d, f, h = B * H**3 / 12, B * H**5 / 80, B * H**7 / 448
    exact = 200e9 * np.array([[AREA, 0, 0], [0, d, f], [0, f, h]])
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    np.testing.assert_allclose(third.stiffness / scale, exact / scale, atol=1e-13)
    np.testing.assert_allclose(
        third.shear_stiffness, STEEL.shear_modulus * np.array([AREA, d, f]), rtol=1e-13
    )
    np.testing.assert_allclose(third.inertia[::2], 7800 * np.array([AREA, d, f, h]), rtol=1e-13)
    # As - 6 c Ds + 9 c^2 Fs with c = 4 / (3 h^2).
    assert third.shear_force_stiffness == pytest.approx(
        8 / 15 * STEEL.shear_modulus * AREA, rel=1e-13
    )


def test_plane_strain_stiffens_a_wide_link() -> None:
    section = one_layer(Ply.isotropic(STEEL), reduction="wide")
    plane_strain = 200e9 / (1 - 0.3**2)
    assert section.axial_stiffness == pytest.approx(plane_strain * AREA, rel=1e-13)
    assert section.bending_stiffness == pytest.approx(plane_strain * B * H**3 / 12, rel=1e-13)
    assert section.third_order.stiffness[2, 2] == pytest.approx(plane_strain * B * H**7 / 448)
    assert section.shear_stiffness == pytest.approx(5 / 6 * STEEL.shear_modulus * AREA, rel=1e-13)


def test_shear_stress_of_a_rectangle_peaks_at_one_and_a_half_of_the_mean() -> None:
    section = one_layer(Ply.isotropic(STEEL))
    for theory in ("equilibrium", "third-order"):
        stress = section.stresses(section.places(3), shear_force=7.0, theory=theory)
        np.testing.assert_allclose(
            stress.shear_stress, [[0, 1.5 * 7.0 / AREA, 0]], atol=1e-9, rtol=1e-13
        )


# ---- an off-axis ply -----------------------------------------------------------------------


def off_axis(ply: Ply, angle: float) -> tuple[float, float]:
    """Moduli E_x (Jones, *Mechanics of Composite Materials*, 2nd ed., eq. 2.97) and G."""
    c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
    e1, nu = ply.longitudinal_modulus, ply.poisson_ratio
    across = 1 / ply.in_plane_shear_modulus - 2 * nu / e1
    modulus = 1 / (c**2 / e1 + s * c * across + s**2 / ply.transverse_modulus)
    shear = 1 / (c / ply.longitudinal_shear_modulus + s / ply.transverse_shear_modulus)
    return float(modulus), float(shear)


@given(numbers(-1.6, 1.6))
@settings(max_examples=20)
def test_a_narrow_off_axis_ply_has_its_apparent_moduli(angle: float) -> None:
    section = one_layer(LOSSY, angle)
    modulus, shear = off_axis(LOSSY, angle)
    assert section.axial_stiffness == pytest.approx(modulus * AREA, rel=1e-11)
    assert section.bending_stiffness == pytest.approx(modulus * B * H**3 / 12, rel=1e-11)
    assert section.third_order.stiffness[1, 2] == pytest.approx(modulus * B * H**5 / 80, rel=1e-11)
    assert section.third_order.stiffness[2, 2] == pytest.approx(modulus * B * H**7 / 448, rel=1e-11)
    assert section.shear_stiffness == pytest.approx(5 / 6 * shear * AREA, rel=1e-11)
    assert section.shear_correction == pytest.approx(5 / 6, rel=1e-11)
    assert section.third_order.shear_force_stiffness == pytest.approx(
        8 / 15 * shear * AREA, rel=1e-11
    )


@given(numbers(-1.6, 1.6))
@settings(max_examples=20)
def test_loss_of_an_off_axis_ply(angle: float) -> None:
    """Stress s along the link is c^2 s, s^2 s and -c s s in the ply's axes."""
    loss, e1, nu = LOSSY.specific_damping, LOSSY.longitudinal_modulus, LOSSY.poisson_ratio
    c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
    modulus, _ = off_axis(LOSSY, angle)
    exact = modulus * (
        loss.longitudinal * (c**2 - nu * s * c) / e1
        + loss.transverse * (s**2 / LOSSY.transverse_modulus - nu * s * c / e1)
        + loss.shear * s * c / LOSSY.in_plane_shear_modulus
    )
    found = one_layer(LOSSY, angle).specific_damping
    assert (found.axial, found.bending, found.shear) == pytest.approx(
        (exact, exact, loss.shear), rel=1e-10
    )


def test_a_ply_along_or_across_the_link_loses_as_it_does_alone() -> None:
    along, across = (one_layer(LOSSY, angle).specific_damping for angle in (0.0, np.pi / 2))
    assert (along.axial, along.bending, along.shear) == pytest.approx((0.005, 0.005, 0.08))
    assert (across.axial, across.bending, across.shear) == pytest.approx((0.06, 0.06, 0.08))


# ---- cross-plies by hand -------------------------------------------------------------------


def test_loss_of_a_symmetric_cross_ply() -> None:
    """[0/90/0] without Poisson's ratio: the middle third has 1/27 of the second moment."""
    ply = Ply(100.0, 10.0, 5.0, 5.0, 2.0, 0.0, 1.0, specific_damping=PlyDamping(0.01, 0.07, 0.09))
    loss = stack(ply, [0, 90, 0], 3.0).specific_damping
    assert loss.axial == pytest.approx((0.01 * 200 + 0.07 * 10) / 210)
    assert loss.bending == pytest.approx((0.01 * 2600 + 0.07 * 10) / 2610)
    assert loss.shear == pytest.approx(0.09)


def test_shear_loss_weighs_the_layers_by_their_shear_energy() -> None:
    """Sandwich with a soft core whose faces carry the bending: the core shears alone."""
    face = Ply(1e3, 1e3, 1e3, 1e3, 1e3, 0.0, 1.0, specific_damping=PlyDamping(0, 0, 0.01))
    core = Ply(1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 0.0, 1.0, specific_damping=PlyDamping(0, 0, 0.2))
    laminate = Laminate((Layer(face, 0.1), Layer(core, 1.0), Layer(face, 0.1)))
    assert LaminateSection(laminate, 1.0).specific_damping.shear == pytest.approx(0.2, rel=1e-6)


def test_unsymmetric_cross_ply_in_cylindrical_bending() -> None:
    """[0/90]: A = (Q11 + Q22) h / 2, B = -(Q11 - Q22) h^2 / 8, and every odd power alike."""
    h = 2.0
    section = stack(PAGANO, [0, 90], h, "wide")
    q1, q2 = 25 / (1 - 0.25**2 / 25), 1 / (1 - 0.25**2 / 25)
    plus, minus = (q1 + q2) / 2, (q2 - q1) / 2
    even = {p: plus * 2 * (h / 2) ** (p + 1) / (p + 1) for p in (0, 2, 4, 6)}
    odd = {p: minus * 2 * (h / 2) ** (p + 1) / (p + 1) for p in (1, 3)}
    moments = even | odd
    exact = np.array([[moments[p + q] for q in (0, 1, 3)] for p in (0, 1, 3)])
    np.testing.assert_allclose(section.third_order.stiffness, exact, rtol=1e-13)
    assert section.coupling_stiffness == pytest.approx(-(q1 - q2) * h**2 / 8)
    assert section.neutral_axis == pytest.approx(minus * h / 4 / plus)
    about = plus * h**3 / 12 - minus**2 * h**3 / 16 / plus
    assert section.bending_stiffness == pytest.approx(about, rel=1e-13)


# ---- layers of isotropic material ----------------------------------------------------------


@given(numbers(0.2, 5.0), numbers(0.2, 5.0), numbers(0.0, 0.45))
@settings(max_examples=20)
def test_bimetal_strip(stiffness_ratio: float, thickness_ratio: float, poisson: float) -> None:
    """Timoshenko, *J. Opt. Soc. Am.* 11 (1925) 233: curvature (4) of a heated strip."""
    low, high = 100e9, 100e9 / stiffness_ratio  # n = E1 / E2, m = a1 / a2
    a2 = 1e-3
    a1 = thickness_ratio * a2
    layers = (Layer(plain(low, poisson=poisson), a1), Layer(plain(high, poisson=poisson), a2))
    section = LaminateSection(Laminate(layers), B)
    interface = a1 - (a1 + a2) / 2
    from_interface = (high * a2**2 - low * a1**2) / (2 * (low * a1 + high * a2))
    assert section.neutral_axis == pytest.approx(interface + from_interface, abs=1e-15)
    squares = (low * a1**2) ** 2 + (high * a2**2) ** 2
    products = low * high * a1 * a2 * (4 * a1**2 + 6 * a1 * a2 + 4 * a2**2)
    exact = B * (squares + products) / (12 * (low * a1 + high * a2))
    assert section.bending_stiffness == pytest.approx(exact, rel=1e-11)
    # Heated, the upper layer would stretch by 1 alone: its free force bends the strip.
    m, n = thickness_ratio, stiffness_ratio
    curvature = (
        6 * (1 + m) ** 2 / ((a1 + a2) * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    )
    arm = interface + a2 / 2 - section.neutral_axis
    assert high * a2 * B * arm / section.bending_stiffness == pytest.approx(curvature, rel=1e-10)


@pytest.mark.parametrize(
    ("code", "layers", "flexural"),
    [
        ("C1", "CCCCC", 121.9),
        ("C2", "CCGCC", 121.2),
        ("C3", "CGCGC", 105.5),
        ("C4", "GCGCG", 59.4),
        ("C5", "GGCGG", 43.6),
        ("C6", "GGGGG", 43.0),
    ],
)
def test_flexural_moduli_of_carbon_and_glass_stacks(
    code: str, layers: str, flexural: float
) -> None:
    """Stacks of Elamy et al. 2023, Table 2, with plies by the rule of mixtures at 60 %."""
    plies = {"C": plain(121.872e9, 1542.4), "G": plain(42.972e9, 2046.4)}
    laminate = Laminate(tuple(Layer(plies[letter], 1e-3) for letter in layers))
    section = LaminateSection(laminate, B)
    assert round(12 * section.bending_stiffness / (B * H**3) / 1e9, 1) == flexural
    glass = layers.count("G") / 5
    assert section.axial_stiffness / AREA == pytest.approx(121.872e9 - glass * 78.9e9)
    assert section.mass_per_length / AREA == pytest.approx(1542.4 + glass * 504.0)
    assert section.neutral_axis == section.mass_axis == 0.0


def test_mass_axis_of_two_densities() -> None:
    t1, t2, rho1, rho2 = 1e-3, 3e-3, 2700.0, 7800.0
    layers = (Layer(plain(70e9, rho1), t1), Layer(plain(200e9, rho2), t2))
    section = LaminateSection(Laminate(layers), B)
    h, mass = t1 + t2, B * (rho1 * t1 + rho2 * t2)
    y1, y2 = (t1 - h) / 2, (h - t2) / 2
    axis = B * (rho1 * t1 * y1 + rho2 * t2 * y2) / mass
    own = B * (rho1 * t1**3 + rho2 * t2**3) / 12
    steiner = B * (rho1 * t1 * (y1 - axis) ** 2 + rho2 * t2 * (y2 - axis) ** 2)
    assert section.mass_per_length == pytest.approx(mass)
    assert section.mass_axis == pytest.approx(axis)
    assert section.rotary_inertia == pytest.approx(own + steiner)
    beam = BeamSection.of_laminate(section)
    assert beam.first_moment_of_mass == pytest.approx(B * (rho1 * t1 * y1 + rho2 * t2 * y2))
    assert beam.first_moment_of_mass == pytest.approx(section.third_order.inertia[1])


# ---- shear stiffness -----------------------------------------------------------------------


def sandwich(face: float, core: float, modulus: float) -> tuple[LaminateSection, float]:
    """Faces of E 1 and G 0.4 on a core of E ``modulus`` and G 0.3 E; and its exact kGA.

    The shear stress of a unit force is a parabola in the core and in each face; the energy
    is the integral of its square over twice the shear modulus.
    """
    faced, cored = (
        Ply(e, e, 1.0, g, g, 0.0, 1.0) for e, g in ((1.0, 0.4), (modulus, 0.3 * modulus))
    )
    layers = (Layer(faced, face), Layer(cored, core), Layer(faced, face))
    h = core + 2 * face
    bending = ((h**3 - core**3) + modulus * core**3) / 12
    in_face = Polynomial([h**2 / 8, 0, -1 / 2]) / bending
    at_core = ((h**2 - core**2) / 8 + modulus * core**2 / 8) / bending
    in_core = Polynomial([at_core, 0, -modulus / 2 / bending])
    energy = 2 * ((in_face**2).integ()(h / 2) - (in_face**2).integ()(core / 2)) / 0.4
    energy += 2 * (in_core**2).integ()(core / 2) / (0.3 * modulus)
    return LaminateSection(Laminate(layers), 1.0), 1 / energy


@given(numbers(0.05, 1.0), numbers(0.05, 2.0), numbers(1e-3, 10.0))
@settings(max_examples=20)
def test_shear_stiffness_of_a_symmetric_sandwich(face: float, core: float, modulus: float) -> None:
    section, exact = sandwich(face, core, modulus)
    assert section.shear_stiffness == pytest.approx(exact, rel=1e-12)


def test_thin_faces_on_a_soft_core_have_the_shear_stiffness_of_sandwich_theory() -> None:
    """Allen, *Analysis and Design of Structural Sandwich Panels*, 1969: G b d^2 / c."""
    errors = []
    for face in (0.02, 0.01, 0.005):
        section, _ = sandwich(face, 1.0, 1e-7)
        errors.append(section.shear_stiffness / (0.3e-7 * (1 + face) ** 2) - 1)
    assert 0 < errors[-1] < 2e-5
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(orders, 2.0, atol=0.05)


@pytest.mark.parametrize(
    ("degrees", "factor"), [([0, 90], 0.8212), ([0, 90, 90, 0], 0.5952), ([90, 0, 0, 90], 0.7205)]
)
def test_shear_correction_factors_of_cross_plies(degrees: list[float], factor: float) -> None:
    """Values quoted for this graphite-epoxy by the method of Whitney 1973."""
    assert round(stack(PAGANO, degrees, 1.0, "wide").shear_correction, 4) == factor


def test_shear_stiffness_of_an_angle_ply_by_hand() -> None:
    """[45/-45] bent without other forces: strains k y and k_z y, and a shear strain g alone.

    Shear of the plies is even in y; its growth along the link shears across the link.
    """
    h, ply = 2.0, LOSSY
    q = Layer(ply, 1.0, -np.pi / 4).transformed_stiffness  # of the upper half
    # k = 1: N_xz and M_z vanish.
    upper = np.array(
        [
            [q[0, 2] * h**2 / 4, q[2, 2] * h],
            [q[1, 1] * h**3 / 12, q[1, 2] * h**2 / 4],
        ]
    )
    across, shear = np.linalg.solve(upper, -np.array([q[0, 2] * h**2 / 4, q[0, 1] * h**3 / 12]))
    along = Polynomial([q[0, 2] * shear, q[0, 0] + q[0, 1] * across])
    sheared = Polynomial([q[2, 2] * shear, q[0, 2] * (1 + across)])
    y = Polynomial([0, 1])
    moment = 2 * (along * y).integ()(h / 2)
    # Integrals from the free upper surface; both vanish there, and sheared's at y = 0 too.
    xy, zy = (p.integ() - p.integ()(h / 2) for p in (along, sheared))
    assert zy(0.0) == pytest.approx(0.0, abs=1e-3)
    stiffness = Layer(ply, 1.0, -np.pi / 4).transformed_shear_stiffness
    (s44, s45), (_, s55) = np.linalg.inv(stiffness)
    density = s44 * zy**2 + 2 * s45 * zy * xy + s55 * xy**2
    energy = 2 * density.integ()(h / 2) / moment**2
    assert stack(ply, [45, -45], h).shear_stiffness == pytest.approx(1 / energy, rel=1e-12)


ANGLES = st.lists(
    st.sampled_from([0.0, 90.0, 45.0, -45.0, 30.0, -60.0, 10.0]), min_size=1, max_size=5
)


@given(ANGLES)
@settings(max_examples=20)
def test_shear_against_another_library(degrees: list[float]) -> None:
    """`composites`: Whitney's factor for cylindrical bending, and recovered shear stresses."""
    other = laminated_plate(stack=degrees, plyt=1e-3, laminaprop=(138e9, 9e9, 0.3, 6e9, 5e9, 3e9))
    other.shear_correction = "whitney"
    other.calc_transverse_shear_stiffness()
    wide = stack(LOSSY, degrees, 1e-3 * len(degrees), "wide")
    narrow = stack(LOSSY, degrees, 1e-3 * len(degrees))
    assert wide.shear_stiffness == pytest.approx(other.A55, rel=1e-10)
    # Strains of a unit moment and no other force, which grows by itself in each metre.
    state = np.linalg.solve(other.ABD, [0, 0, 0, 1, 0, 0])
    places = narrow.places(4)[:, 1:-1]  # off the interfaces
    _, _, shear = other.calc_equilibrium_transverse_shear(state, np.zeros(6), places.ravel())
    # So wide that its edges, which a plate has not, are nothing.
    plate = replace(narrow, width=1e9)
    found = plate.stresses(places, shear_force=plate.width).shear_stress
    np.testing.assert_allclose(found.ravel(), shear[0], rtol=1e-9, atol=1e-9 * np.abs(shear).max())


# ---- third-order theory --------------------------------------------------------------------


@given(ANGLES, st.sampled_from(["narrow", "wide"]))
@settings(max_examples=20)
def test_third_order_shear_energy_is_that_of_its_stress(
    degrees: list[float], reduction: Reduction
) -> None:
    """Stress times strain through the thickness, against the stiffness of the shear angle."""
    t = 1e-3
    section = stack(LOSSY, degrees, t * len(degrees), reduction)
    third, laminate = section.third_order, section.laminate
    points, weights = np.polynomial.legendre.leggauss(3)
    places = (laminate.boundaries[:-1] + t / 2)[:, None] + t / 2 * points
    parabola = 1 - 4 * places**2 / laminate.thickness**2
    stress = section.stresses(places, shear_force=1.0, theory="third-order").shear_stress
    # Stiffness of unit angles across and along; in a narrow link the first adjusts itself.
    stiffness = np.einsum(
        "nm,m,nij->ij", t / 2 * parabola**2, weights, laminate.transformed_shear_stiffness
    )
    across = -stiffness[0, 1] / stiffness[0, 0] if reduction == "narrow" else 0.0
    turn = np.array([across, 1.0])
    assert third.shear_force_stiffness == pytest.approx(turn @ stiffness @ turn, rel=1e-12)
    moduli = laminate.transformed_shear_stiffness[:, 1] @ turn
    angle = stress / (moduli[:, None] * parabola)
    np.testing.assert_allclose(angle, angle[0, 0], rtol=1e-10)
    energy = np.sum(t / 2 * weights * stress * parabola * angle)
    assert energy == pytest.approx(third.shear_force_stiffness * angle[0, 0] ** 2, rel=1e-10)


def test_third_order_moments_of_a_symmetric_cross_ply() -> None:
    """[0/90/0], h = 6, outer layers beyond 1: powers of 3 less powers of 1."""
    ply = Ply(100.0, 10.0, 5.0, 5.0, 2.0, 0.0, 1.0)
    layers = (Layer(ply, 2.0), Layer(ply, 2.0, np.pi / 2), Layer(ply, 2.0))
    section = LaminateSection(Laminate(layers), 1.0)
    moments = {
        p: 2 * (100 * (3.0 ** (p + 1) - 1) + 10) / (p + 1) if p % 2 == 0 else 0.0
        for p in (0, 1, 2, 3, 4, 6)
    }
    exact = [[moments[p + q] for q in (0, 1, 3)] for p in (0, 1, 3)]
    np.testing.assert_allclose(section.third_order.stiffness, exact, rtol=1e-12, atol=1e-9)
    shear = [2 * (5 * (3.0 ** (p + 1) - 1) + 2) / (p + 1) for p in (0, 2, 4)]
    np.testing.assert_allclose(section.third_order.shear_stiffness, shear, rtol=1e-12)
