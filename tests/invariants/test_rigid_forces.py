"""The forces in every rigid linkage: balance, energy, slopes, symmetry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech import ConstantSpeed, Mechanism, Spring, example_model, kinematics, load_mechanism
from flexmech.analyses import KinematicsRequest
from flexmech.linkages import (
    GROUND,
    InverseDynamics,
    LinkEnd,
    LinkMass,
    RigidMotion,
    inverse_dynamics,
)
from flexmech.linkages.inverse_dynamics import needed_by_inertia
from tests.support.random_linkages import LoadedLinkage, link_masses, loaded_linkages

GRAVITY = (1.5, -9.81)
# Differences of eighth order for the first and second derivative.
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
STEP = 1e-4
DRIVE = ConstantSpeed(20.0, start_angle=0.4, run_up_time=0.5)
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)


def solved(case: LoadedLinkage) -> InverseDynamics:
    return inverse_dynamics(
        case.topology,
        case.motion,
        case.masses,
        GRAVITY,
        loads=case.loads,
        springs=case.springs,
        joint_springs=case.joint_springs,
    )


def lumps(mass: LinkMass) -> list[tuple[float, float, float, float]]:
    """Mass, inertia and place along and across of what has the link's moments."""
    half = mass.length / 2
    line = zip(mass.mass_per_length * half * WEIGHTS, half * (POINTS + 1), strict=True)
    points = zip(mass.point_masses, mass.point_positions, strict=True)
    return [
        *((m, 0.0, x, mass.offset) for m, x in line),
        *((m, 0.0, x, 0.0) for m, x in points),
        *((b.mass, b.inertia, b.position + b.offset[0], b.offset[1]) for b in mass.bodies),
    ]


def axes(motion: RigidMotion, link: int) -> np.ndarray:
    """Unit vectors along and across a link, as rows."""
    c, s = np.cos(motion.angle[link]), np.sin(motion.angle[link])
    return np.array([[c, s], [-s, c]])


def point_motion(motion: RigidMotion, link: int, x: float, y: float) -> tuple[np.ndarray, ...]:
    """Position, velocity and acceleration."""
    arm = np.array([x, y]) @ axes(motion, link)
    ahead = np.array([-arm[1], arm[0]])
    omega, alpha = motion.angular_velocity[link], motion.angular_acceleration[link]
    return (
        motion.origin[link] + arm,
        motion.origin_velocity[link] + omega * ahead,
        motion.origin_acceleration[link] + alpha * ahead - omega**2 * arm,
    )


def ends(case: LoadedLinkage, spring: Spring) -> list[tuple[np.ndarray, np.ndarray]]:
    return [
        (np.array([p.x, p.y]), np.zeros(2))
        if p.link == GROUND
        else point_motion(case.motion, case.topology.index(p.link), p.x, 0.0)[:2]
        for p in (spring.first, spring.second)
    ]


def turning_links(case: LoadedLinkage, joint: str) -> list[int]:
    """Numbers of the following and the leading link, or of the pivoted one."""
    index = case.topology.index
    for pin in case.topology.pins:
        if pin.joint == joint:
            return [index(pin.follower.link), index(pin.leader.link)]
    return [index(pivot.link_end.link) for pivot in case.topology.pivots if pivot.joint == joint]


@settings(max_examples=60)
@given(loaded_linkages())
def test_all_power_becomes_kinetic_energy(case: LoadedLinkage) -> None:
    """Power of torque, weight, loads, springs and dampers, on any linkage at any rate.

    A term is a force times a velocity; its size is counted before what is at right angles cancels.
    What the crank's joints carry has a power too, which drops out.
    """
    motion, forces = case.motion, solved(case)
    terms = [float(forces.driving_power)]
    crank = case.topology.links[0].length * abs(float(motion.crank_speed))
    sizes = [crank * max(float(np.abs(force).max()) for force in forces.joint_force.values())]

    def add(force: np.ndarray, velocity: np.ndarray) -> None:
        terms.append(float(force @ velocity))
        sizes.append(float(np.linalg.norm(force) * np.linalg.norm(velocity)))

    def turn(torque: float, link: int) -> None:
        add(np.array([torque]), motion.angular_velocity[link : link + 1])

    for link, mass in enumerate(case.masses):
        for m, inertia, x, y in lumps(mass):
            _, velocity, acceleration = point_motion(motion, link, x, y)
            add(-m * acceleration, velocity)
            add(m * np.asarray(GRAVITY), velocity)
            turn(-inertia * motion.angular_acceleration[link], link)
    for load in case.loads:
        link = case.topology.index(load.point.link)
        force = np.asarray(load.force[0])
        if load.axes == "link":
            force = force @ axes(motion, link)
        add(force, point_motion(motion, link, load.point.x, 0.0)[1])
        turn(load.torque[0], link)
    for spring in case.springs:
        (p1, v1), (p2, v2) = ends(case, spring)
        length = np.linalg.norm(p2 - p1)
        along = (p2 - p1) / length
        pull = spring.stiffness * (length - spring.free_length)
        pull = pull + spring.damping * (v2 - v1) @ along
        add(pull * along, v1)
        add(-pull * along, v2)
    for own in case.joint_springs:
        follower, *leader = turning_links(case, own.joint)
        angle, rate = (
            of[follower] - sum(of[link] for link in leader)
            for of in (motion.angle, motion.angular_velocity)
        )
        torque = -own.torsional_stiffness * (angle - own.free_angle)
        torque -= own.torsional_damping * rate
        turn(torque, follower)
        for link in leader:
            turn(-torque, link)
    assert abs(sum(terms)) <= 1e-12 * max(sizes)


def cross(arm: np.ndarray, force: np.ndarray) -> float:
    return float(arm[0] * force[1] - arm[1] * force[0])


def at_the_end(case: LoadedLinkage, forces: InverseDynamics, link: str) -> tuple[np.ndarray, float]:
    """Force and couple of the joints on a link's end."""
    topology, end = case.topology, LinkEnd(link, "end")
    force, couple = np.zeros(2), 0.0
    for holder in (*topology.clamps, *topology.pivots, *topology.sliders):
        if holder.link_end == end:
            force = force + forces.joint_force[holder.joint]
            couple += forces.joint_moment[holder.joint]
    for tie in topology.ties:
        for place, sign in ((tie.follower, 1), (tie.leader, -1)):
            if place == end:
                force = force + sign * forces.joint_force[tie.joint]
                couple += sign * forces.joint_moment[tie.joint]
    return force, couple


@settings(max_examples=30)
@given(loaded_linkages())
def test_every_link_is_in_balance(case: LoadedLinkage) -> None:
    """Cut beyond the last force, where all but the forces on its end are passed from its start.

    A slider is pushed across its line, and its guide pushed back.
    """
    forces = solved(case)
    guided = [slider.joint for slider in case.topology.sliders if slider.guide]
    on_guides = forces.applied[len(forces.applied) - len(guided) :]
    inertia = [
        needed_by_inertia(forces.motion, forces.gravity, number, mass.moments)[0]
        for number, mass in enumerate(forces.masses)
    ]
    for number, link in enumerate(case.topology.links):
        reach = [link.length, *(float(one.x) for one in on_guides if one.link == number)]
        # The distributed mass ends with the link.
        if max(reach) > link.length and case.masses[number].mass_per_length:
            continue
        beyond = max(reach) * (1 + 1e-9)
        force, couple = at_the_end(case, forces, link.name)
        force = axes(case.motion, number) @ force
        couple += cross(np.array([link.length - beyond, 0.0]), force)
        inside = [
            getattr(forces, name)(number, beyond)
            for name in ("axial_force", "shear_force", "bending_moment")
        ]
        size = 1e-10 + 1e-8 * sum(np.abs(f).max() for f in forces.joint_force.values())
        size += 1e-8 * sum(abs(float(m)) for m in forces.joint_moment.values())
        size += 1e-8 * np.abs(inertia).max()
        assert np.abs(np.array(inside) - [*force, couple]).max() <= size
    for slider in case.topology.sliders:
        angle = slider.direction
        if slider.guide:
            angle += case.motion.angle[case.topology.index(slider.guide)]
        force = forces.joint_force[slider.joint]
        assert abs(force @ [np.cos(angle), np.sin(angle)]) <= 1e-14 * np.abs(force).max()
    for joint, back in zip(guided, on_guides, strict=True):
        assert np.array_equal(back.force, -forces.joint_force[joint])


@given(st.data())
def test_moments_of_a_links_mass_are_those_of_its_parts(data: st.DataObject) -> None:
    mass = data.draw(link_masses(0.8))
    parts = lumps(mass)
    total = sum(m for m, *_ in parts)
    assert mass.moment(0) == pytest.approx(total, rel=1e-13, abs=1e-15)
    assert mass.moment(1) == pytest.approx(sum(m * x for m, _, x, _ in parts), rel=1e-12)
    across = sum(m * y for m, _, _, y in parts)
    assert mass.moment_across == pytest.approx(across, rel=1e-12, abs=1e-15)
    polar = sum(i + m * (x**2 + y**2) for m, i, x, y in parts)
    assert mass.moment(2) == pytest.approx(polar, rel=1e-12, abs=1e-15)
    if total > 1e-3:
        x0, y0 = mass.centre
        central = sum(i + m * ((x - x0) ** 2 + (y - y0) ** 2) for m, i, x, y in parts)
        assert mass.central_inertia == pytest.approx(central, rel=1e-9, abs=1e-9)


def unloaded(name: str) -> Mechanism:
    """A model without anything that acts on it but its inertia."""
    mechanism = load_mechanism(example_model(name))
    return replace(mechanism, gravity=(0.0, 0.0), loads=(), springs=(), joint_springs=())


@pytest.mark.parametrize(
    "name", ["steel_fourbar", "slider_crank", "watt_six_bar", "carton_pusher", "rotating_l_beam"]
)
def test_in_a_run_up_torque_and_accelerations_are_rates(name: str) -> None:
    """Rates of kinetic energies and of places, which contain no acceleration."""
    mechanism = unloaded(name)
    masses = mechanism.link_masses_in_order
    mass = np.array([each.moment(0) for each in masses])
    inertia = np.array([each.central_inertia for each in masses])
    for time in (0.11, 0.4):
        request = KinematicsRequest(
            float(DRIVE.crank_speed(time)),
            crank_angles=[float(DRIVE.crank_angle(time))],
            crank_acceleration=float(DRIVE.crank_acceleration(time)),
        )
        data = kinematics(mechanism, request).dataset.isel(crank_angle=0)
        motion = DRIVE.motion(mechanism.linkage, time + STEP * np.arange(-4, 5))
        centres = [each.centre for each in masses]
        place, velocity = (
            np.stack([getattr(motion, what)(n, *at) for n, at in enumerate(centres)], axis=1)
            for what in ("position", "velocity")
        )
        for found, values in (
            ("angular_acceleration", np.unwrap(motion.angle, axis=0)),
            ("centre_acceleration", place),
        ):
            second = np.tensordot(SECOND, values, 1) / STEP**2
            assert data[found].values == pytest.approx(second, abs=1e-6 * np.abs(second).max())
        energy = mass * np.sum(velocity**2, axis=-1) + inertia * motion.angular_velocity**2
        power = FIRST @ np.sum(energy, axis=-1) / 2 / STEP
        assert data["driving_power"].item() == pytest.approx(power, rel=1e-7)


def test_forces_of_inertia_grow_with_the_square_of_the_speed_either_way() -> None:
    steel = unloaded("steel_fourbar")
    slow, fast = (kinematics(steel, v, crank_angles=[0.4, 2.0]) for v in (5.0, -10.0))
    for name in ("driving_torque", "joint_force", "shaking_force", "shaking_moment"):
        np.testing.assert_allclose(fast.dataset[name], 4 * slow.dataset[name], rtol=1e-11)


def test_a_mirrored_linkage_has_mirrored_forces() -> None:
    """The crossed branch at the opposite angle and speed."""
    here = unloaded("steel_fourbar")
    there = replace(here, linkage=replace(here.linkage, branch="crossed"))
    angles = np.array([0.4, 2.0])
    first = kinematics(here, 10.0, crank_angles=angles, crank_acceleration=30.0).dataset
    asked = KinematicsRequest(-10.0, crank_angles=-angles[::-1], crank_acceleration=-30.0)
    second = kinematics(there, asked).dataset.isel(crank_angle=slice(None, None, -1))
    force = first["joint_force"].transpose("crank_angle", "joint", "component").values
    other = second["joint_force"].transpose("crank_angle", "joint", "component").values
    np.testing.assert_allclose(other, force * [1, -1], rtol=1e-9, atol=1e-9 * np.abs(force).max())
    for name in ("driving_torque", "shaking_moment"):
        np.testing.assert_allclose(second[name].values, -first[name].values, rtol=1e-9)
