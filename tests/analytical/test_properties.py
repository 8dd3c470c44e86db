"""What must hold for any linkage: symmetry, reversal, scaling, invariance, two solutions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.analyses import moving_frequencies, natural_frequencies, solve_modes
from flexmech.linear_system import PRESTRESS_LEVELS, LinearSystem, Prestress
from flexmech.linkages import FourBar
from flexmech.mechanism import Mechanism, PointMass
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection
from tests.support.strategies import LINKS, Running, fourbar, numbers, running_mechanisms, scaled

FloatArray = NDArray[np.float64]
few = settings(max_examples=25)
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
levels = st.sampled_from(PRESTRESS_LEVELS)


def engine_of(mechanism: Mechanism, *, reduced: bool = False, elements: int = 2) -> ReferenceEngine:
    """Of slender elements, named: to choose them for each mechanism takes longer than the rest."""
    count = max(elements, 1 + len(mechanism.link_masses))
    return ReferenceEngine(mechanism, count, "euler", component_modes=reduced)


def system_of(
    drawn: Running, prestress: Prestress, *, terms: bool = True, ahead: float | FloatArray = 0.0
) -> LinearSystem:
    """The unreduced system, ``ahead`` rad further on."""
    return engine_of(drawn.mechanism).linear_system(
        drawn.crank_angle + ahead, drawn.crank_speed, prestress=prestress, rotation_terms=terms
    )


def frequencies(
    mechanism: Mechanism,
    angle: float,
    speed: float = 0.0,
    prestress: Prestress = "equilibrium",
    *,
    terms: bool = True,
) -> FloatArray:
    return natural_frequencies(
        engine_of(mechanism), angle, speed, prestress=prestress, rotation_terms=terms
    )


def skew(matrix: FloatArray) -> FloatArray:
    return (matrix - np.swapaxes(matrix, -1, -2)) / 2


def asymmetry(matrix: FloatArray) -> float:
    return float(np.abs(skew(matrix)).max() / np.abs(matrix).max())


def damped(mechanism: Mechanism, damping_time: float) -> Mechanism:
    beams = {k: s.with_damping_time(damping_time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=beams)


@few
@given(running_mechanisms(), levels)
def test_mass_is_symmetric_and_positive_definite(drawn: Running, prestress: Prestress) -> None:
    mass = system_of(drawn, prestress).mass[0]
    assert asymmetry(mass) < 1e-14
    assert scipy.linalg.eigvalsh(mass)[0] > 0


@few
@given(running_mechanisms(), levels)
def test_stiffness_is_symmetric_without_rotation_terms(
    drawn: Running, prestress: Prestress
) -> None:
    system = system_of(drawn, prestress, terms=False)
    assert asymmetry(system.stiffness[0]) < 1e-13
    assert not system.damping.any()
    assert scipy.linalg.eigvalsh(system.stiffness[0])[0] > 0


@few
@given(running_mechanisms())
def test_material_damping_is_symmetric_and_takes_energy(drawn: Running) -> None:
    lossy = replace(drawn, mechanism=damped(drawn.mechanism, 1e-5))
    damping = system_of(lossy, "none", terms=False).damping[0]
    stiffness = system_of(lossy, "none", terms=False).stiffness[0]
    assert damping == pytest.approx(1e-5 * stiffness, rel=1e-12)


def rate(drawn: Running, prestress: Prestress, name: str) -> FloatArray:
    """Time derivative of a matrix by central differences over the crank angle."""
    # Ninth order: at 2e-3 a linkage that nearly locks is off by 2e-8, here by 3e-13.
    step = 5e-4
    path = system_of(drawn, prestress, ahead=step * np.arange(-4, 5))
    slope = np.einsum("k,kij->ij", FIRST, getattr(path, name)) / step
    return drawn.crank_speed * slope


@few
@given(running_mechanisms(), levels)
def test_damping_less_the_rate_of_mass_is_skew(drawn: Running, prestress: Prestress) -> None:
    damping = system_of(drawn, prestress).damping[0]
    rest = damping - rate(drawn, prestress, "mass")
    assert np.abs(rest + rest.T).max() < 1e-8 * np.abs(damping).max()
    assert np.abs(skew(damping)).max() > 1e-3 * np.abs(damping).max()


@few
@given(running_mechanisms(), levels)
def test_skew_stiffness_is_half_the_rate_of_the_skew_damping(
    drawn: Running, prestress: Prestress
) -> None:
    """Lagrange's equations of ``z'Mz/2 + z'Bz - zAz/2``: C = M' + B - B^T, K = A + B'."""
    found = skew(system_of(drawn, prestress).stiffness[0])
    expected = skew(rate(drawn, prestress, "damping")) / 2
    elastic = np.abs(system_of(drawn, "none", terms=False).stiffness).max()
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max() + 1e-14 * elastic


@few
@given(running_mechanisms(), levels)
def test_reversing_the_crank_reflects_the_eigenvalues(drawn: Running, prestress: Prestress) -> None:
    """C changes its sign, M and K do not: lambda becomes -conj(lambda)."""
    engine = engine_of(drawn.mechanism)
    systems = [
        engine.linear_system(drawn.crank_angle, s * drawn.crank_speed, prestress=prestress)
        for s in (1, -1)
    ]
    forward, backward = (solve_modes(system, 4).eigenvalues[0] for system in systems)
    assert np.abs(backward + forward.conj()).max() < 1e-8 * np.abs(forward[-1])


@few
@given(running_mechanisms(), levels)
def test_mirrored_linkage_has_the_same_eigenvalues(drawn: Running, prestress: Prestress) -> None:
    linkage = drawn.mechanism.linkage
    other = replace(linkage, branch="crossed" if linkage.branch == "open" else "open")
    mirrored = replace(drawn.mechanism, linkage=other)
    systems = [
        engine_of(mechanism).linear_system(
            side * drawn.crank_angle, side * drawn.crank_speed, prestress=prestress
        )
        for mechanism, side in ((drawn.mechanism, 1), (mirrored, -1))
    ]
    here, there = (solve_modes(system, 4).eigenvalues[0] for system in systems)
    assert np.abs(here - there).max() < 1e-8 * np.abs(here[-1])


def test_a_full_turn_leads_back_to_the_same_frequencies() -> None:
    first, last = (frequencies(fourbar(), angle, 20.0) for angle in (0.7, 0.7 + 2 * np.pi))
    assert last == pytest.approx(first, rel=1e-10)


def times(section: BeamSection, length: float, modulus: float, density: float) -> BeamSection:
    """The section with lengths, Young's modulus and density multiplied."""
    return BeamSection(
        axial_stiffness=section.axial_stiffness * modulus * length**2,
        bending_stiffness=section.bending_stiffness * modulus * length**4,
        shear_stiffness=section.shear_stiffness * modulus * length**2,
        mass_per_length=section.mass_per_length * density * length**2,
        rotary_inertia=section.rotary_inertia * density * length**4,
        in_plane_thickness=section.in_plane_thickness * length,
    )


def similar(drawn: Mechanism, length: float, modulus: float, density: float) -> Mechanism:
    mass = density * length**3
    return Mechanism(
        scaled(drawn.linkage, length),
        {k: times(s, length, modulus, density) for k, s in drawn.sections.items()},
        {k: m * mass for k, m in drawn.joint_masses.items()},
        tuple(PointMass(p.link, p.position * length, p.mass * mass) for p in drawn.link_masses),
    )


@few
@given(running_mechanisms(), levels, numbers(0.2, 5), numbers(0.2, 5), numbers(0.2, 5))
def test_similar_mechanisms_have_similar_frequencies(
    drawn: Running, prestress: Prestress, length: float, modulus: float, density: float
) -> None:
    """At rest and at a crank speed scaled alike: f ~ sqrt(E / rho) / length."""
    factor = np.sqrt(modulus / density) / length
    other = similar(drawn.mechanism, length, modulus, density)
    for speed in (0.0, drawn.crank_speed):
        small = frequencies(drawn.mechanism, drawn.crank_angle, speed, prestress)
        large = frequencies(other, drawn.crank_angle, speed * factor, prestress)
        assert large == pytest.approx(factor * small, rel=1e-7)


def test_a_rectangle_scales_like_a_similar_section() -> None:
    section = fourbar().sections["crank"]
    large = fourbar(thickness=(3 * 4.24e-3, 1.0, 1.0), width=3 * 25.4e-3).sections["crank"]
    expected = times(section, 3.0, 1.0, 1.0)
    for name in ("axial_stiffness", "bending_stiffness", "mass_per_length", "rotary_inertia"):
        assert getattr(large, name) == pytest.approx(getattr(expected, name))


@few
@given(running_mechanisms(), levels)
def test_mass_at_a_ground_pivot_changes_nothing(drawn: Running, prestress: Prestress) -> None:
    heavy = replace(
        drawn.mechanism, joint_masses={**drawn.mechanism.joint_masses, "O2": 5.0, "O4": 3.0}
    )
    at = (drawn.crank_angle, drawn.crank_speed, prestress)
    assert frequencies(heavy, *at) == pytest.approx(frequencies(drawn.mechanism, *at), rel=1e-10)


@few
@given(running_mechanisms(), st.sampled_from(("A", "B")))
def test_mass_at_a_pin_lowers_the_frequencies(drawn: Running, joint: str) -> None:
    masses = drawn.mechanism.joint_masses
    heavy = replace(drawn.mechanism, joint_masses={**masses, joint: masses[joint] + 0.05})
    before = frequencies(drawn.mechanism, drawn.crank_angle)
    after = frequencies(heavy, drawn.crank_angle)
    assert (after <= before * (1 + 1e-10)).all()
    assert (after < before * (1 - 1e-9)).any()


def test_mass_at_the_crank_pin_lowers_the_first_frequencies() -> None:
    ratio = frequencies(fourbar(joint_masses={"A": 0.05}), 0.7) / frequencies(fourbar(), 0.7)
    assert (ratio < 1 - 1e-5).all()
    assert ratio.min() < 0.97


@pytest.mark.parametrize("prestress", PRESTRESS_LEVELS)
def test_the_same_place_written_twice_is_one_point_mass(prestress: Prestress) -> None:
    place = 0.1397
    again = float(np.nextafter(place, 1))
    first, same, near = (PointMass("coupler", x, 0.005) for x in (place, place, again))
    expected = frequencies(fourbar(link_masses=(first, same)), 0.5, 20.0, prestress)
    found = frequencies(fourbar(link_masses=(first, near)), 0.5, 20.0, prestress)
    assert found == pytest.approx(expected, rel=1e-9)


def test_zero_gravity_is_the_default_and_gravity_counts_only_as_prestress() -> None:
    still, heavy = fourbar(gravity=(0.0, 0.0)), fourbar(gravity=(0.0, -9.81))
    plain = fourbar()
    for level in PRESTRESS_LEVELS:
        at = (0.4, 20.0, level)
        assert np.array_equal(frequencies(still, *at), frequencies(plain, *at))
    at_rest = [frequencies(heavy, 0.4, 0.0, level) for level in PRESTRESS_LEVELS]
    assert at_rest[0] == pytest.approx(frequencies(plain, 0.4), rel=1e-12)
    for loaded in at_rest[1:]:
        assert np.abs(loaded / at_rest[0] - 1).max() > 1e-4


def test_gravity_acts_like_an_acceleration_of_the_ground() -> None:
    """Turning weight and linkage by a half turn together: B hangs below, weight points up."""
    up = fourbar(gravity=(0.0, 9.81))
    down = replace(fourbar(gravity=(0.0, -9.81)), linkage=replace(up.linkage, branch="crossed"))
    assert frequencies(up, 0.6, 10.0) == pytest.approx(frequencies(down, -0.6, 10.0), rel=1e-9)


def assert_modes_are_those_of_a_dense_solver(system: LinearSystem, tolerance: float) -> None:
    mass, damping, stiffness = system.mass[0], system.damping[0], system.stiffness[0]
    modes = solve_modes(system, 4)
    if system.is_conservative:
        squares = scipy.linalg.eigh(stiffness, mass, eigvals_only=True)
        values = 1j * np.sqrt(squares[:4])
        x = modes.vectors[0]
        assert x.T @ mass @ x == pytest.approx(np.eye(4), abs=1e-8)
    else:
        unit = np.abs(modes.eigenvalues[0, 0])  # of time, so that both blocks are of order one
        zero, one = np.zeros_like(mass), np.eye(len(mass))
        left = np.block([[zero, one], [-stiffness / unit**2, -damping / unit]])
        values = unit * scipy.linalg.eigvals(left, np.block([[one, zero], [zero, mass]]))
        values = values[values.imag > 0]
        values = values[np.argsort(np.abs(values))][:4]
    found = modes.eigenvalues[0]
    assert found == pytest.approx(values, rel=tolerance)
    for value, x in zip(found, modes.vectors[0].T, strict=True):
        residual = (value**2 * mass + value * damping + stiffness) @ x
        assert np.abs(residual).max() < 1e-12 * np.abs(stiffness).max() * np.abs(x).max()
        assert x.conj() @ mass @ x == pytest.approx(1.0)


@few
@given(running_mechanisms(), levels, st.booleans(), st.sampled_from((0.0, 1e-5)))
def test_modes_of_any_mechanism_are_those_of_a_dense_solver(
    drawn: Running, prestress: Prestress, terms: bool, damping_time: float
) -> None:
    lossy = replace(drawn, mechanism=damped(drawn.mechanism, damping_time))
    # The dense solvers lose as many digits as the links are stiffer along than across.
    assert_modes_are_those_of_a_dense_solver(system_of(lossy, prestress, terms=terms), 1e-7)


@pytest.mark.parametrize("terms", [False, True])
@pytest.mark.parametrize("prestress", PRESTRESS_LEVELS)
@pytest.mark.parametrize("damping_time", [0.0, 1e-5])
def test_modes_of_the_aluminium_mechanism_are_those_of_a_dense_solver(
    prestress: Prestress, terms: bool, damping_time: float
) -> None:
    mechanism = fourbar(damping_time=damping_time)
    system = engine_of(mechanism, elements=4).linear_system(
        0.7, 20.0, prestress=prestress, rotation_terms=terms
    )
    assert_modes_are_those_of_a_dense_solver(system, 1e-9)


# Of three mechanisms at equilibrium in tests/cross_engine/test_random_mechanisms.py.
@pytest.mark.thorough
@settings(max_examples=12)
@given(running_mechanisms(), levels, st.booleans())
def test_reported_reduction_error_is_small_and_true(
    drawn: Running, prestress: Prestress, terms: bool
) -> None:
    engine = engine_of(drawn.mechanism, reduced=True, elements=4)
    angles = drawn.crank_angle + np.array([0.0, 0.01])
    result = moving_frequencies(
        engine, angles, [drawn.crank_speed], prestress=prestress, rotation_terms=terms
    ).dataset
    full = natural_frequencies(
        engine.unreduced(), angles, drawn.crank_speed, prestress=prestress, rotation_terms=terms
    )
    reported = result["reduction_error"].values[0, 0]
    actual = np.abs(result["frequency"].values[0, 0] / full - 1)
    assert reported.max() <= 2e-5
    assert actual == pytest.approx(reported, rel=0.2, abs=2e-7)


def test_natural_frequencies_in_component_modes_are_right_or_refused() -> None:
    """A strongly bowed linkage: the first frequency rises from 27.7 Hz at rest to 33.8 Hz."""
    section = fourbar(thickness=(3e-3, 3e-3, 3e-3), width=10e-3).sections["crank"]
    linkage = FourBar(ground=0.275, crank=0.164, coupler=0.2, rocker=0.166)
    mechanism = Mechanism(linkage, dict.fromkeys(LINKS, section), {"A": 0.01, "B": 0.03})
    engine = ReferenceEngine(mechanism, 16)
    full = natural_frequencies(engine.unreduced(), 0.0, 40.0)
    assert natural_frequencies(engine, 0.0, 40.0) == pytest.approx(full, rel=1e-4)
