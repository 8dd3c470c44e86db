"""Sections of laminates against closed forms, hand-worked stacks and another library.

Stacks are named from the lowest layer up; a bar along the link is 0 degrees.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from composites import laminated_plate
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from flexmech import InputError, Mechanism, PointMass, RotatingArm
from flexmech.materials import Laminate, Layer, Material, Ply, PlyDamping
from flexmech.sections import (
    BeamSection,
    DampingTimes,
    LaminateSection,
    Reduction,
)
from tests.support.strategies import fourbar, numbers

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


def test_isotropic_rectangle() -> None:
    section = one_layer(Ply.isotropic(STEEL))
    assert section.axial_stiffness == pytest.approx(200e9 * AREA, rel=1e-13)
    assert section.bending_stiffness == pytest.approx(200e9 * B * H**3 / 12, rel=1e-13)
    assert section.shear_stiffness == pytest.approx(5 / 6 * STEEL.shear_modulus * AREA, rel=1e-13)
    assert section.shear_correction == pytest.approx(5 / 6, rel=1e-13)
    assert section.mass_per_length == pytest.approx(7800 * AREA)
    assert section.rotary_inertia == pytest.approx(7800 * B * H**3 / 12)
    assert (section.coupling_stiffness, section.neutral_axis, section.mass_axis) == (0, 0, 0)


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


CARBON = Ply(138e9, 9e9, 6e9, 5e9, 3e9, 0.3, 1600.0, PlyDamping(0.005, 0.06, 0.08))
GLASS = Ply(39e9, 8.4e9, 4.2e9, 4.2e9, 3.4e9, 0.26, 2000.0, PlyDamping(0.01, 0.05, 0.07))
BIMETAL = LaminateSection(
    Laminate(
        (
            Layer(Ply.isotropic(Material(70e9, 2700.0)), 1e-3),
            Layer(Ply.isotropic(Material(200e9, 7800.0)), 2e-3),
        )
    ),
    0.02,
)


def resultant(section: LaminateSection, values: np.ndarray) -> float:
    """Integral over the cross-section of values at the places of ``gauss_places``."""
    weights = np.polynomial.legendre.leggauss(4)[1]
    return float(
        section.width * np.sum(np.diff(section.laminate.boundaries) / 2 @ values @ weights)
    )


def gauss_places(section: LaminateSection) -> np.ndarray:
    faces = section.laminate.boundaries
    points = np.polynomial.legendre.leggauss(4)[0]
    return (faces[:-1] + faces[1:])[:, None] / 2 + np.diff(faces)[:, None] / 2 * points


@given(ANGLES, st.sampled_from(["narrow", "wide"]), numbers(-1e3, 1e3), numbers(-10, 10))
@settings(max_examples=20)
def test_stresses_balance_their_loads(
    degrees: list[float], reduction: Reduction, axial: float, moment: float
) -> None:
    """Force and moment about the neutral axis; shear force; no shear stress at the faces."""
    section = stack(LOSSY, degrees, 1e-3 * len(degrees), reduction)
    places, h, shear = gauss_places(section), section.laminate.thickness, 300.0
    scale = abs(axial) + abs(moment) / h + shear
    for theory in ("equilibrium", "third-order"):
        found = section.stresses(places, axial, moment, shear, theory=theory)
        bent = resultant(section, -(places - section.neutral_axis) * found.normal_stress)
        assert resultant(section, found.normal_stress) == pytest.approx(axial, abs=1e-9 * scale)
        assert bent == pytest.approx(moment, abs=1e-9 * scale * h)
        assert resultant(section, found.shear_stress) == pytest.approx(shear, abs=1e-9 * scale)
        faces = section.stresses(section.places(3), shear_force=shear, theory=theory).shear_stress
        np.testing.assert_allclose(faces[[0, -1], [0, -1]], 0, atol=1e-9 * np.abs(faces).max())


@given(ANGLES, st.sampled_from(["narrow", "wide"]))
@settings(max_examples=20)
def test_strain_energies_of_unit_loads_are_those_of_the_stiffness(
    degrees: list[float], reduction: Reduction
) -> None:
    section = stack(LOSSY, degrees, 1e-3 * len(degrees), reduction)
    for load, stiffness in (
        ({"axial_force": 1.0}, section.axial_stiffness),
        ({"bending_moment": 1.0}, section.bending_stiffness),
    ):
        found = section.stresses(gauss_places(section), **load)
        energy = resultant(section, found.strain * found.normal_stress)
        assert energy == pytest.approx(1 / stiffness, rel=1e-9)


def test_symmetric_stacks_bend_about_their_middle_exactly() -> None:
    for angles in ((45, -45, -45, 45), (30, 0, -20, 0, 30)):
        section = stack(LOSSY, angles, 0.1e-3 / 3 * len(angles))
        assert section.neutral_axis == section.mass_axis == section.coupling_stiffness == 0.0


def test_kelvin_voigt_times_of_a_laminate() -> None:
    section = LaminateSection(Laminate((Layer(CARBON, 1e-3), Layer(GLASS, 1e-3))), 0.01)
    beam = BeamSection.of_laminate(section)
    assert beam.specific_damping == section.specific_damping
    damped = beam.with_damping_frequency(50.0)
    assert damped.damping_frequency == 50.0
    assert replace(damped, damping=DampingTimes(), damping_frequency=None) == beam
    # A cycle of viscous damping loses 2 pi omega tau.
    lost = 2 * np.pi * (2 * np.pi * 50.0) * damped.damping.bending
    assert lost == pytest.approx(section.specific_damping.bending)
    with pytest.raises(InputError, match="damping frequency must be positive"):
        beam.with_damping_frequency(0.0)
    with pytest.raises(InputError, match="needs the specific damping of the plies"):
        BeamSection.of_laminate(BIMETAL).with_damping_frequency(50.0)


def test_a_rectangle_by_hand_and_its_shear_stiffness_by_cowpers_coefficient() -> None:
    section = BeamSection.rectangle(replace(STEEL, poisson_ratio=0.25), 0.01, 0.02)
    second_moment = 0.02 * 0.01**3 / 12
    stiffness = section.axial_stiffness, section.bending_stiffness
    assert stiffness == pytest.approx((200e9 * 2e-4, 200e9 * second_moment), rel=1e-13)
    inertia = section.mass_per_length, section.rotary_inertia
    assert inertia == pytest.approx((7800 * 2e-4, 7800 * second_moment), rel=1e-13)
    assert section.shear_stiffness == pytest.approx(12.5 / 14.75 * 80e9 * 2e-4)


def test_a_damping_ratio_at_a_frequency_is_half_of_omega_tau() -> None:
    section = BeamSection.rectangle(STEEL, 0.01, 0.02).with_damping_ratio(0.02, 50.0)
    assert section.damping.bending * 2 * np.pi * 50.0 / 2 == pytest.approx(0.02)
    assert section.with_damping_time(3e-5).damping == DampingTimes(3e-5, 3e-5, 3e-5)


SECTION = BeamSection.rectangle(STEEL, 0.01, 0.02)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(SECTION, axial_stiffness=0.0), "axial_stiffness of a beam section"),
        (lambda: replace(SECTION, shear_stiffness=-1.0), "shear_stiffness of a beam section"),
        (lambda: replace(SECTION, neutral_axis=-0.006), "neutral_axis must lie inside"),
        (lambda: replace(SECTION, mass_axis=np.nan), "mass_axis of a beam section"),
        (lambda: SECTION.with_damping_time(-1e-9), "damping_time"),
        (lambda: SECTION.with_damping_ratio(0.01, 0.0), "damping frequency"),
        (lambda: BeamSection.rectangle(STEEL, 0.01, np.nan), "out_of_plane_width"),
        (lambda: LaminateSection(BIMETAL.laminate, 0.0), "width of a laminate section"),
        (lambda: LaminateSection(BIMETAL.laminate, 0.01, "thin"), "narrow, wide"),  # type: ignore[arg-type]
        (lambda: LaminateSection(BIMETAL.laminate, 0.01, twist="loose"), "free, held"),  # type: ignore[arg-type]
        (lambda: BIMETAL.places(1), "per_layer must be 2"),
        (lambda: BIMETAL.stresses(BIMETAL.places(2), np.nan), "loads on a section"),
        (lambda: BIMETAL.stresses(np.array([0.0, 2e-3])), "place 0.002 m is outside its layer"),
        (lambda: BIMETAL.stresses(np.zeros((3, 4))), "one row for each of the 2 layers"),
        (lambda: fourbar(joint_masses={"C": 1.0}), "unknown joint 'C'"),
        (lambda: fourbar(joint_masses={"A": -1.0}), "A must be zero or positive"),
        (lambda: fourbar(link_masses=(PointMass("crank", 0.2, 1.0),)), "is not on the crank"),
        (lambda: fourbar(gravity=(0.0, np.inf)), "gravity must be a number"),
        (lambda: Mechanism(RotatingArm(1.0), {"rod": SECTION}), "one section for each link"),
        (
            lambda: replace(SECTION, layers=None).third_order,
            "third-order theory needs the layers.*timoshenko",
        ),
    ],
)
def test_what_cannot_be_a_section_is_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()
