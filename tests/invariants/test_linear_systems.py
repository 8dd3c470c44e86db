"""The linear equations of any linkage: symmetry, reversal, mirror, scaling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech import (
    BeamSection,
    FourBar,
    Mechanism,
    PointMass,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.solvers import solve_modes
from tests.support.mechanisms import drawn, four_bar
from tests.support.strategies import LINKS, Running, fourbar, numbers, running_mechanisms, scaled

few = settings(max_examples=10)
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
LEVELS = ("none", "axial", "equilibrium")
levels = st.sampled_from(LEVELS)


def engine_of(mechanism: Mechanism, *, reduced: bool = False, elements: int = 2) -> ReferenceEngine:
    """Engine of slender elements, named because choosing them takes longer than the test."""
    count = max(elements, 1 + len(mechanism.link_masses))
    return ReferenceEngine(mechanism, count, "euler", component_modes=reduced)


def system_of(case: Running, prestress: str, *, terms: bool = True, ahead=0.0):
    """The unreduced system, ``ahead`` rad further on."""
    return engine_of(case.mechanism).linear_system(
        case.crank_angle + ahead, case.crank_speed, prestress=prestress, rotation_terms=terms
    )


def frequencies(
    mechanism: Mechanism, angle: float, speed: float = 0.0, prestress: str = "equilibrium"
) -> np.ndarray:
    return natural_frequencies(engine_of(mechanism), angle, speed, prestress=prestress)


def skew(matrix: np.ndarray) -> np.ndarray:
    return (matrix - np.swapaxes(matrix, -1, -2)) / 2


def asymmetry(matrix: np.ndarray) -> float:
    return float(np.abs(skew(matrix)).max() / np.abs(matrix).max())


def damped(mechanism: Mechanism, damping_time: float) -> Mechanism:
    beams = {k: s.with_damping_time(damping_time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=beams)


@pytest.mark.thorough
@few
@given(running_mechanisms(), levels)
def test_frozen_matrices_are_symmetric_and_positive_definite(case: Running, level: str) -> None:
    """Material damping is the damping time times the stiffness."""
    system = system_of(case, level, terms=False)
    assert not system.damping.any()
    for matrix, error in ((system.mass[0], 1e-14), (system.stiffness[0], 1e-13)):
        assert asymmetry(matrix) < error
        assert scipy.linalg.eigvalsh(matrix)[0] > 0
    lossy = replace(case, mechanism=damped(case.mechanism, 1e-5))
    slack = system_of(lossy, "none", terms=False)
    assert slack.damping[0] == pytest.approx(1e-5 * slack.stiffness[0], rel=1e-12)


@few
@given(running_mechanisms(), levels)
def test_matrices_are_those_of_a_lagrangian(case: Running, level: str) -> None:
    """``z'Mz/2 + z'Bz - zAz/2``: C = M' + B - B^T, K = A + B', whose skew part is half of C's.

    Rates are central differences over the crank angle.
    """
    # Eighth order: at 2e-3 a linkage that nearly locks is off by 2e-8, here by 3e-13.
    step = 5e-4
    path = system_of(case, level, ahead=step * np.arange(-4, 5))
    mass, damping, stiffness = path.mass, path.damping, path.stiffness

    def rate(matrices: np.ndarray) -> np.ndarray:
        return case.crank_speed * np.einsum("k,kij->ij", FIRST, matrices) / step

    rest = damping[4] - rate(mass)
    assert np.abs(rest + rest.T).max() < 1e-8 * np.abs(damping[4]).max()
    assert np.abs(skew(damping[4])).max() > 1e-3 * np.abs(damping[4]).max()
    expected = rate(skew(damping)) / 2
    elastic = np.abs(system_of(case, "none", terms=False).stiffness).max()
    apart = np.abs(skew(stiffness[4]) - expected).max()
    assert apart < 1e-6 * np.abs(expected).max() + 1e-14 * elastic


@few
@given(running_mechanisms(), levels)
def test_a_reversed_crank_and_a_mirrored_linkage(case: Running, level: str) -> None:
    """Reversed, lambda becomes -conj(lambda); mirrored, it stays."""
    linkage = case.mechanism.linkage
    other = replace(linkage, branch="crossed" if linkage.branch == "open" else "open")
    mirrored = replace(case.mechanism, linkage=other)
    forward, backward, mirror = (
        solve_modes(
            engine_of(mechanism).linear_system(
                side * case.crank_angle, way * case.crank_speed, prestress=level
            ),
            4,
        ).eigenvalues[0]
        for mechanism, side, way in (
            (case.mechanism, 1, 1),
            (case.mechanism, 1, -1),
            (mirrored, -1, -1),
        )
    )
    scale = 1e-8 * np.abs(forward[-1])
    assert np.abs(backward + forward.conj()).max() < scale
    assert np.abs(mirror - forward).max() < scale


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


@few
@given(running_mechanisms(), levels, numbers(0.2, 5), numbers(0.2, 5), numbers(0.2, 5))
def test_similar_mechanisms_have_similar_frequencies(
    case: Running, level: str, length: float, modulus: float, density: float
) -> None:
    """At rest and at a crank speed scaled alike: f ~ sqrt(E / rho) / length."""
    own, factor = case.mechanism, np.sqrt(modulus / density) / length
    mass = density * length**3
    other = Mechanism(
        scaled(own.linkage, length),
        {k: times(s, length, modulus, density) for k, s in own.sections.items()},
        {k: m * mass for k, m in own.joint_masses.items()},
        tuple(PointMass(p.link, p.position * length, p.mass * mass) for p in own.link_masses),
    )
    for speed in (0.0, case.crank_speed):
        small = frequencies(own, case.crank_angle, speed, level)
        large = frequencies(other, case.crank_angle, speed * factor, level)
        assert large == pytest.approx(factor * small, rel=1e-7)


@few
@given(running_mechanisms(), levels, st.sampled_from(("A", "B")))
def test_mass_lowers_frequencies_where_it_moves(case: Running, level: str, joint: str) -> None:
    """At a ground pivot it changes nothing."""
    own, at = case.mechanism, (case.crank_angle, case.crank_speed, level)
    held = replace(own, joint_masses={**own.joint_masses, "O2": 5.0, "O4": 3.0})
    before = frequencies(own, *at)
    assert frequencies(held, *at) == pytest.approx(before, rel=1e-10)
    masses = {**own.joint_masses, joint: own.joint_masses[joint] + 0.05}
    rest, heavy = (
        frequencies(each, case.crank_angle) for each in (own, replace(own, joint_masses=masses))
    )
    assert (heavy <= rest * (1 + 1e-10)).all()
    assert (heavy < rest * (1 - 1e-9)).any()


@pytest.mark.parametrize("level", LEVELS)
def test_frequencies_come_back_after_a_turn_and_know_no_order_of_masses(level: str) -> None:
    """The same place written twice, a rounding apart, is one point mass."""
    place = 0.1397
    again = float(np.nextafter(place, 1))
    first, same, near = (PointMass("coupler", x, 0.005) for x in (place, place, again))
    expected = frequencies(fourbar(link_masses=(first, same)), 0.5, 20.0, level)
    other = frequencies(fourbar(link_masses=(near, first)), 0.5, 20.0, level)
    assert other == pytest.approx(expected, rel=1e-9)
    turned = frequencies(fourbar(link_masses=(first, same)), 0.5 + 2 * np.pi, 20.0, level)
    assert turned == pytest.approx(expected, rel=1e-9)


def test_gravity_counts_as_prestress_and_like_an_acceleration_of_the_ground() -> None:
    """Turned over with its weight, crossed and backwards, a linkage has the same frequencies."""
    up, down = fourbar(gravity=(0.0, 9.81)), fourbar(gravity=(0.0, -9.81))
    turned = replace(down, linkage=replace(down.linkage, branch="crossed"))
    expected = frequencies(up, 0.6, 10.0)
    assert frequencies(turned, -0.6, 10.0) == pytest.approx(expected, rel=1e-9)
    plain = frequencies(fourbar(), 0.4)
    assert frequencies(down, 0.4, 0.0, "none") == pytest.approx(plain, rel=1e-12)
    for level in ("axial", "equilibrium"):
        assert np.abs(frequencies(down, 0.4, 0.0, level) / plain - 1).max() > 1e-4


@few
@given(running_mechanisms(), levels, st.booleans(), st.sampled_from((0.0, 1e-5)))
def test_modes_are_those_of_a_dense_solver(
    case: Running, level: str, terms: bool, damping_time: float
) -> None:
    """Residuals of the eigenproblem are round-off; vectors have unit modal mass."""
    lossy = replace(case, mechanism=damped(case.mechanism, damping_time))
    system = system_of(lossy, level, terms=terms)
    mass, damping, stiffness = system.mass[0], system.damping[0], system.stiffness[0]
    modes = solve_modes(system, 4)
    unit = np.abs(modes.eigenvalues[0, 0])  # of time, so that both blocks are of order one
    zero, one = np.zeros_like(mass), np.eye(len(mass))
    left = np.block([[zero, one], [-stiffness / unit**2, -damping / unit]])
    values = unit * scipy.linalg.eigvals(left, np.block([[one, zero], [zero, mass]]))
    values = values[values.imag > 0]
    values = values[np.argsort(np.abs(values))][:4]
    # The dense solver loses as many digits as the links are stiffer along than across.
    assert modes.eigenvalues[0] == pytest.approx(values, rel=1e-7)
    for value, x in zip(modes.eigenvalues[0], modes.vectors[0].T, strict=True):
        residual = (value**2 * mass + value * damping + stiffness) @ x
        assert np.abs(residual).max() < 1e-12 * np.abs(stiffness).max() * np.abs(x).max()
        assert x.conj() @ mass @ x == pytest.approx(1.0)


def test_component_modes_are_right_on_a_strongly_bowed_linkage() -> None:
    """They give the frequencies of the unreduced equations to 1e-4."""
    section = fourbar(thickness=(3e-3, 3e-3, 3e-3), width=10e-3).sections["crank"]
    linkage = FourBar(ground=0.275, crank=0.164, coupler=0.2, rocker=0.166)
    mechanism = Mechanism(linkage, dict.fromkeys(LINKS, section), {"A": 0.01, "B": 0.03})
    engine = ReferenceEngine(mechanism, 12)
    full = natural_frequencies(engine.unreduced(), 0.0, 40.0)
    assert natural_frequencies(engine, 0.0, 40.0) == pytest.approx(full, rel=1e-4)


def test_which_end_of_a_pin_leads_changes_no_frequency_at_rest() -> None:
    """A four-bar drawn with its links in another order and direction."""
    section = fourbar().sections["crank"]
    first = four_bar()
    links = {"rocker": ("B", "O4"), "coupler": ("B", "A"), "crank": ("O2", "A")}
    second = drawn(first.points, links, {"O2": "clamp"}, ("O4",))
    one, other = (
        frequencies(Mechanism(linkage, dict.fromkeys(LINKS, section)), 1.0)
        for linkage in (first, replace(second, drawn_at=first.drawn_angle))
    )
    assert one == pytest.approx(other, rel=1e-8)


def test_the_damping_ratio_of_damped_links_grows_with_the_frequency() -> None:
    """At rest it is half the damping time by the angular frequency, as for any oscillator."""
    system = engine_of(fourbar(damping_time=2e-5)).linear_system(0.7, 0.0, prestress="none")
    modes = solve_modes(system, 4)
    angular = np.abs(modes.eigenvalues[0])
    assert modes.damping_ratio[0] == pytest.approx(1e-5 * angular, rel=1e-9)
    plain = frequencies(fourbar(), 0.7, 0.0, "none").ravel()[:4]
    assert angular == pytest.approx(2 * np.pi * plain, rel=1e-9)
