"""Forces in the rigid linkage: virtual power, equilibrium, lumped masses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.linkages import (
    InverseDynamics,
    LinkMass,
    RigidMotion,
    RotatingArm,
    Topology,
    inverse_dynamics,
)
from tests.support.strategies import STEEL_LINKAGE, Posture, numbers, postures

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
WEIGHT_OF_STEEL = 7800 * 6.1e-3 * 4.25e-3
GRAVITY = (1.5, -9.81)


@st.composite
def masses(draw: st.DrawFn, lengths: tuple[float, ...]) -> tuple[LinkMass, ...]:
    links = []
    for length in lengths:
        places = draw(st.lists(numbers(0, 1), max_size=3))
        points = draw(st.lists(numbers(0, 2), min_size=len(places), max_size=len(places)))
        positions = tuple(sorted(length * p for p in places))
        links.append(LinkMass(length, draw(numbers(0.1, 3)), positions, tuple(points)))
    return tuple(links)


@st.composite
def loaded_linkages(draw: st.DrawFn) -> tuple[Posture, InverseDynamics]:
    drawn = draw(postures())
    linkage = drawn.linkage
    links = draw(masses((linkage.crank, linkage.coupler, linkage.rocker)))
    gravity = draw(st.sampled_from(((0.0, 0.0), GRAVITY)))
    motion = linkage.motion(drawn.crank_angle, draw(numbers(1, 20)), draw(numbers(-99, 99)))
    return drawn, inverse_dynamics(linkage.topology, motion, links, gravity)


def steel_masses() -> tuple[LinkMass, ...]:
    return tuple(LinkMass(x, WEIGHT_OF_STEEL) for x in (0.1, 0.2794, 0.2667))


def parts(mass: LinkMass) -> list[tuple[float, float]]:
    """Masses and places that have the link's moments up to the seventh."""
    share = mass.mass_per_length * mass.length / 2
    places = (POINTS + 1) * mass.length / 2
    points = zip(mass.point_masses, mass.point_positions, strict=True)
    return [*zip(share * WEIGHTS, places, strict=True), *points]


def force_of(motion: RigidMotion, link: int, mass: float, x: float, gravity: object) -> np.ndarray:
    return -mass * (motion.acceleration(link, x) - np.asarray(gravity))


@given(loaded_linkages())
def test_virtual_power_of_torque_and_inertia_forces_is_zero(
    drawn: tuple[Posture, InverseDynamics],
) -> None:
    forces, motion = drawn[1], drawn[1].motion
    loads = [
        (force_of(motion, link, m, x, forces.gravity), motion.velocity(link, x))
        for link, mass in enumerate(forces.masses)
        for m, x in parts(mass)
    ]
    power = forces.driving_torque * motion.crank_speed + sum(f @ v for f, v in loads)
    assert abs(power) <= 1e-12 * sum(np.linalg.norm(f) * np.linalg.norm(v) for f, v in loads)


def cross(arm: np.ndarray, force: np.ndarray) -> float:
    return float(arm[0] * force[1] - arm[1] * force[0])


@given(loaded_linkages())
def test_each_link_is_in_equilibrium(drawn: tuple[Posture, InverseDynamics]) -> None:
    forces, motion, linkage = drawn[1], drawn[1].motion, drawn[0].linkage
    pin = forces.joint_force
    acting = {  # at start, at end, couple
        0: (pin["O2"], -pin["A"], forces.driving_torque),
        1: (pin["A"], -pin["B"], 0.0),
        2: (pin["O4"], pin["B"], 0.0),
    }
    lengths = (linkage.crank, linkage.coupler, linkage.rocker)
    for link, (at_start, at_end, couple) in acting.items():
        loads = [(at_start, motion.position(link, 0.0))]
        loads += [(at_end, motion.position(link, lengths[link]))]
        loads += [
            (force_of(motion, link, m, x, forces.gravity), motion.position(link, x))
            for m, x in parts(forces.masses[link])
        ]
        scale = sum(np.abs(f).max() for f, _ in loads)
        assert np.abs(sum(f for f, _ in loads)).max() <= 1e-12 * scale
        moments = [cross(place, f) for f, place in loads]
        scale = sum(np.linalg.norm(f) * np.linalg.norm(place) for f, place in loads)
        assert abs(sum(moments) + couple) <= 1e-12 * scale


@given(loaded_linkages())
def test_axial_force_joins_the_forces_at_both_ends(drawn: tuple[Posture, InverseDynamics]) -> None:
    forces, motion = drawn[1], drawn[1].motion
    pin = forces.joint_force
    ends = ((pin["O2"], -pin["A"]), (pin["A"], -pin["B"]), (pin["O4"], pin["B"]))
    for link, (at_start, at_end) in enumerate(ends):
        mass = forces.masses[link]
        along = np.array([np.cos(motion.angle[link]), np.sin(motion.angle[link])])
        beyond = [
            force_of(motion, link, m, x, forces.gravity) @ along
            for m, x in zip(mass.point_masses, mass.point_positions, strict=True)
            if x >= mass.length
        ]
        scale = 1e-12 * (np.abs(at_start).max() + np.abs(at_end).max() + sum(map(abs, beyond)))
        assert abs(forces.axial_force(link, 0.0) + at_start @ along) <= scale
        assert (
            abs(forces.axial_force(link, mass.length) - at_end @ along - sum(beyond)) <= 9 * scale
        )


@given(postures(), numbers(1, 20), numbers(-99, 99))
def test_axial_force_falls_by_the_distributed_inertia_force(
    drawn: Posture, speed: float, acceleration: float
) -> None:
    linkage = drawn.linkage
    links = tuple(LinkMass(x, 1.3) for x in (linkage.crank, linkage.coupler, linkage.rocker))
    motion = linkage.motion(drawn.crank_angle, speed, acceleration)
    forces = inverse_dynamics(linkage.topology, motion, links, GRAVITY)
    for link, mass in enumerate(links):
        along = np.array([np.cos(motion.angle[link]), np.sin(motion.angle[link])])
        x, step = 0.4 * mass.length, 0.1 * mass.length
        slope = forces.axial_force(link, x + step) - forces.axial_force(link, x - step)
        load = force_of(motion, link, 1.3, x, GRAVITY) @ along
        scale = np.abs(forces.start_force[link]).max() / step + np.abs(load)
        assert abs(slope / (2 * step) + load) <= 1e-11 * scale


def test_a_point_mass_makes_the_axial_force_jump() -> None:
    motion = RotatingArm(1.0).motion(0.3, 5.0)
    arm = LinkMass(1.0, 0.0, (0.6,), (2.0,))
    forces = inverse_dynamics(RotatingArm(1.0).topology, motion, (arm,))
    tension = 2.0 * 0.6 * 25
    assert forces.axial_force(0, 0.59) == pytest.approx(tension)
    assert forces.axial_force(0, 0.6) == pytest.approx(tension)
    assert forces.axial_force(0, 0.61) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("hub", [0.0, 0.5])
def test_tension_and_torque_of_a_rotating_arm(hub: float) -> None:
    length, rho, speed, alpha = 2.0, 1.5, 10.0, 7.0
    linkage = RotatingArm(length, hub)
    motion = linkage.motion(np.linspace(0, 6, 5), speed, alpha)
    forces = inverse_dynamics(linkage.topology, motion, (LinkMass(length, rho),))
    for x in (0.0, 0.7, 2.0):
        tension = rho * speed**2 * ((length**2 - x**2) / 2 + hub * (length - x))
        assert forces.axial_force(0, x) == pytest.approx(tension, abs=1e-10)
    torque = alpha * rho * ((hub + length) ** 3 - hub**3) / 3
    assert forces.driving_torque == pytest.approx(torque, rel=1e-12)


def test_weight_of_an_arm_is_held_by_the_clamp() -> None:
    linkage = RotatingArm(2.0, 0.5)
    mass = LinkMass(2.0, 1.5, (2.0,), (4.0,))
    forces = inverse_dynamics(linkage.topology, linkage.motion(0.0), (mass,), (0.0, -9.81))
    assert forces.joint_force["O2"] == pytest.approx([0.0, 7 * 9.81], abs=1e-12)
    assert forces.driving_torque == pytest.approx(9.81 * (3 * 1.5 + 4 * 2.5))


def lumped(link: LinkMass, segments: int) -> LinkMass:
    """The same link with each of the equal segments halved onto its two ends.

    Four segments for coupler and rocker and one for the crank give the twelve masses of Kumar &
    Chandrakar, Figure 1.5.
    """
    share = link.mass_per_length * link.length / segments
    masses = np.full(segments + 1, share)
    masses[[0, -1]] = share / 2
    positions = np.linspace(0.0, link.length, segments + 1)
    return LinkMass(
        length=link.length,
        mass_per_length=0.0,
        point_positions=(*positions.tolist(), *link.point_positions),
        point_masses=(*masses.tolist(), *link.point_masses),
    )


def test_segments_give_the_twelve_lumped_masses_of_the_paper() -> None:
    crank, coupler, rocker = steel_masses()
    lumps = [lumped(crank, 1), lumped(coupler, 4), lumped(rocker, 4)]
    assert sum(len(link.point_masses) for link in lumps) == 12
    assert lumps[1].point_positions[1:-1] == pytest.approx((69.85e-3, 139.7e-3, 209.55e-3))
    assert lumps[2].point_positions[1:-1] == pytest.approx((66.675e-3, 133.35e-3, 200.025e-3))
    assert lumps[0].point_positions == (0.0, 0.1)
    quarter = WEIGHT_OF_STEEL * 0.2794 / 4
    assert lumps[1].point_masses == pytest.approx([quarter / 2, *[quarter] * 3, quarter / 2])
    assert all(link.mass_per_length == 0 for link in lumps)


@given(masses((0.7,)), st.integers(1, 12))
def test_lumping_keeps_mass_and_centre(links: tuple[LinkMass, ...], segments: int) -> None:
    link, points = links[0], lumped(links[0], segments)
    assert points.moment(0) == pytest.approx(link.moment(0), rel=1e-13)
    assert points.moment(1) == pytest.approx(link.moment(1), rel=1e-13)
    excess = link.mass_per_length * 0.7**3 / (6 * segments**2)
    assert points.moment(2) - link.moment(2) == pytest.approx(excess, rel=1e-9)


def test_lumped_forces_converge_with_the_square_of_the_number_of_masses() -> None:
    motion = STEEL_LINKAGE.motion(np.linspace(0, 6, 7), 20.0, 30.0)

    def forces(links: tuple[LinkMass, ...]) -> np.ndarray:
        solved = inverse_dynamics(STEEL_LINKAGE.topology, motion, links)
        pins = np.concatenate([solved.joint_force[j] for j in ("A", "B", "O4")], axis=-1)
        return np.concatenate([pins, solved.driving_torque[:, None]], axis=-1)

    exact = forces(steel_masses())
    error = [forces(tuple(lumped(link, n) for link in steel_masses())) - exact for n in (2, 4, 8)]
    assert np.abs(error[0]).max() > 0.01 * np.abs(exact).max()
    assert error[0] == pytest.approx(4 * error[1], abs=1e-12)
    assert error[1] == pytest.approx(4 * error[2], abs=1e-12)


def test_forces_grow_with_the_square_of_the_speed() -> None:
    motion = STEEL_LINKAGE.motion(1.0, np.array([5.0, -10.0]))
    torque = inverse_dynamics(STEEL_LINKAGE.topology, motion, steel_masses()).driving_torque
    assert torque[1] == pytest.approx(4 * torque[0], rel=1e-12)


@settings(max_examples=20)
@given(loaded_linkages())
def test_start_force_collects_the_joints_at_a_links_start(
    drawn: tuple[Posture, InverseDynamics],
) -> None:
    forces = drawn[1]
    joints = [forces.joint_force[name] for name in ("O2", "A", "O4")]
    assert np.array_equal(forces.start_force, joints)


def test_a_linkage_that_is_not_held_is_refused() -> None:
    topology = STEEL_LINKAGE.topology
    loose = Topology(topology.links, (), topology.pivots, topology.pins)
    with pytest.raises(InputError, match="6 connection forces for 9 equations"):
        inverse_dynamics(loose, STEEL_LINKAGE.motion(0.3), steel_masses())


@given(
    length=numbers(0.05, 2),
    places=st.lists(numbers(0, 1), max_size=6),
    distance=numbers(0, 3e-3),
    data=st.data(),
)
def test_points_that_are_close_move_together_and_keep_mass_and_centre(
    length, places, distance, data
):
    """A second point lies close to each."""
    places = [*places, *(min(1.0, place + distance) for place in places)]
    weights = [data.draw(numbers(0.01, 2)) for _ in places]
    points = [(length * place, weight) for place, weight in zip(places, weights, strict=True)]
    given_mass = LinkMass(length, 0.3, *(tuple(x) for x in zip(*points, strict=True)))
    apart = LinkMass.of_points(length, 0.3, points)
    assert apart.moment(0) == pytest.approx(given_mass.moment(0), rel=1e-12)
    assert apart.moment(1) == pytest.approx(given_mass.moment(1), rel=1e-12)
    lost = abs(apart.moment(2) - given_mass.moment(2))
    assert lost <= 2e-5 * sum(weights) * length**2
    inner = sorted({x for x in apart.point_positions if 1e-9 < x / length < 1 - 1e-9})
    gaps = np.diff([0.0, *inner, length])
    assert gaps.min() >= length / 500 * (1 - 1e-9)


def test_points_that_are_apart_stay():
    points = [(0.3, 2.0), (0.0, 1.0), (0.1, 0.5), (1.0, 4.0)]
    mass = LinkMass.of_points(1.0, 0.3, points, 0.2)
    expected = ((0.0, 0.1, 0.3, 1.0), (1.0, 0.5, 2.0, 4.0))
    assert mass == LinkMass(1.0, 0.3, *expected, 0.2)
