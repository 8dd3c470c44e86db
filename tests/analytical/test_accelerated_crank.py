"""Kinematics of a crank that accelerates, against its own run-up: by differences in time.

In a run-up the crank passes states of angle, speed and acceleration. The analysis is asked for some
of them; differences over time of what has no acceleration in it, the angles, places and kinetic
energies of the rigid linkage, say what accelerations and power must be.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    ConstantSpeed,
    InputError,
    KinematicsRequest,
    Mechanism,
    example_model,
    kinematics,
    load_mechanism,
)
from flexmech.arrays import FloatArray
from flexmech.linkages import AttachmentPoint, Load, RigidMotion
from tests.support.strategies import arm

DRIVE = ConstantSpeed(20.0, start_angle=0.4, run_up_time=0.5)
TIMES = np.array([0.11, 0.25, 0.4])
# Of differences in time, of fourth order.
STEP = 1e-4
FIRST = np.array([1, -8, 0, 8, -1]) / (12 * STEP)
SECOND = np.array([-1, 16, -30, 16, -1]) / (12 * STEP**2)
NAMES = ["steel_fourbar", "slider_crank", "watt_six_bar", "carton_pusher", "rotating_l_beam"]


def unloaded(name: str) -> Mechanism:
    """A model without anything that acts on it but its inertia."""
    mechanism = load_mechanism(example_model(name))
    return replace(mechanism, gravity=(0.0, 0.0), loads=(), springs=(), joint_springs=())


def around(mechanism: Mechanism, time: float) -> RigidMotion:
    return DRIVE.motion(mechanism.linkage, time + STEP * np.arange(-2, 3))


def asked(time: float) -> KinematicsRequest:
    return KinematicsRequest(
        [float(DRIVE.crank_angle(time))],
        float(DRIVE.crank_speed(time)),
        crank_acceleration=float(DRIVE.crank_acceleration(time)),
    )


def centres(mechanism: Mechanism, motion: RigidMotion) -> tuple[FloatArray, FloatArray]:
    """Places and velocities of the centres of mass."""
    points = [mass.centre for mass in mechanism.link_masses_in_order]
    places = [motion.position(link, *point) for link, point in enumerate(points)]
    velocities = [motion.velocity(link, *point) for link, point in enumerate(points)]
    return np.stack(places, axis=1), np.stack(velocities, axis=1)


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_are_second_differences_of_the_run_up(name: str) -> None:
    mechanism = unloaded(name)
    for time in TIMES:
        data = kinematics(mechanism, asked(time)).dataset.isel(crank_angle=0)
        motion = around(mechanism, time)
        turned = SECOND @ np.unwrap(motion.angle, axis=0)
        scale = np.abs(turned).max()
        assert data["angular_acceleration"].values == pytest.approx(turned, abs=1e-6 * scale)
        moved = np.tensordot(SECOND, centres(mechanism, motion)[0], 1)
        scale = np.abs(moved).max()
        assert data["centre_acceleration"].values == pytest.approx(moved, abs=1e-6 * scale)


@pytest.mark.parametrize("name", NAMES)
def test_the_power_of_the_torque_is_the_rate_of_the_kinetic_energy(name: str) -> None:
    mechanism = unloaded(name)
    masses = mechanism.link_masses_in_order
    mass = np.array([each.moment(0) for each in masses])
    inertia = np.array([each.central_inertia for each in masses])
    for time in TIMES:
        data = kinematics(mechanism, asked(time)).dataset.isel(crank_angle=0)
        motion = around(mechanism, time)
        moving = mass * np.sum(centres(mechanism, motion)[1] ** 2, axis=-1)
        energy = np.sum(moving + inertia * motion.angular_velocity**2, axis=-1) / 2
        assert data["driving_power"].item() == pytest.approx(FIRST @ energy, rel=1e-7)


def test_an_arm_needs_its_moment_of_inertia_times_the_acceleration() -> None:
    """At any speed; the shaft's own inertia is told beside it."""
    mechanism = replace(arm(), shaft_inertia=2e-3)
    mass = mechanism.link_masses_in_order[0]
    request = KinematicsRequest([0.0, 1.0], 20.0, crank_acceleration=-300.0)
    found = kinematics(mechanism, request)
    assert found.dataset["driving_torque"].values == pytest.approx(-300.0 * mass.moment(2))
    line = "driving torque: the shaft's own inertia takes -0.6 N m besides"
    assert line in found.summary().lines


def test_no_mean_power_of_a_turn_is_told_of_a_crank_that_does_not_keep_its_speed() -> None:
    steel = load_mechanism(example_model("steel_fourbar"))
    for acceleration in (0.0, 50.0):
        request = KinematicsRequest(crank_speed=20.0, crank_acceleration=acceleration)
        said = kinematics(steel, request).summary().lines
        assert any("mean driving power" in line for line in said) == (acceleration == 0)


def test_loads_over_time_are_refused_and_others_are_not() -> None:
    """When an accelerated crank is at an angle is not known."""
    tip = AttachmentPoint("arm", 1.0)
    forces = ((0.0, 0.0), (0.0, 10.0))
    ramp = Load("ramp", tip, forces, (0.0, 0.0), "link", "time", (0.0, 1.0))
    request = KinematicsRequest([0.5], 2.0, crank_acceleration=1.0)
    with pytest.raises(InputError, match="crank_acceleration: the load ramp goes over time"):
        kinematics(replace(arm(), loads=(ramp,)), request)
    over_angle = replace(ramp, over="crank_angle")
    torque = kinematics(replace(arm(), loads=(over_angle,)), request).dataset["driving_torque"]
    inertia = arm().link_masses_in_order[0].moment(2)
    assert torque.values == pytest.approx([inertia - 5.0])
