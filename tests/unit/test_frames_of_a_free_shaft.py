"""Torques of a free shaft, and the frames in which a run is told as it turns ahead.

A rigid linkage that is turned ahead is not deformed in the frames that turn with it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ConstantSpeed,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
)
from flexmech.arrays import FloatArray
from flexmech.linkages import AttachmentPoint, Load
from flexmech.time_domain import DrivenLinkage, Trajectory, linear_run
from flexmech.time_domain.recorded_runs.recording import StepBlock
from flexmech.time_domain.recorded_runs.states import ShaftMotion, rigid_torque
from flexmech.time_domain.recorded_runs.trajectory import EnergyHistory

SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
START, SPEED = 0.02, 6.0


def turned(time: FloatArray) -> FloatArray:
    """Rotation of the shaft ahead of its prescribed angle in rad."""
    return 0.05 + 3.0 * (time - START)


def with_shaft(model: str) -> Mechanism:
    return replace(load_mechanism(f"models/{model}.toml"), shaft_inertia=1e-3)


def greatest(parts: list[FloatArray]) -> float:
    return max(float(np.abs(part).max()) for part in parts)


def test_small_turns() -> None:
    """The displacements are the turn times the linkage's own fields, and their rates follow."""
    mechanism = with_shaft("aluminium_fourbar")
    engine = ReferenceEngine(mechanism, 2, "euler", component_modes=False, shaft="free")
    linkage = DrivenLinkage(engine, ConstantSpeed(SPEED), "axial")
    shaft, step = linkage.shaft, 1e-6
    assert shaft is not None
    assert not shaft.is_natural
    time = START + step * np.array([-1.0, 0.0, 1.0])
    place = turned(time)[:, None] * shaft.turn(linkage.motion(time))
    speed, now = (place[2:] - place[:1]) / (2 * step), linkage.motion(time[1:2])
    moving = linkage.frames.link_motion(now, place[1:2], speed, np.zeros_like(speed))
    displacement, rate = [q for q, _, _ in moving], [q_1 for _, q_1, _ in moving]
    none, joints = np.zeros(1), len(engine.topology.joint_names)
    block = StepBlock(
        time[1:2], now.crank_speed, displacement, rate, np.zeros((1, joints, 2)), *6 * [none]
    )
    found = shaft.carried(block, now)
    assert found.shaft is not None
    assert found.shaft.rotation == turned(time[1:2])
    np.testing.assert_allclose(found.shaft.rate, 3.0, rtol=1e-6)
    assert greatest(found.displacement) < 1e-9 * greatest(displacement)
    assert greatest(found.rate) < 1e-6 * greatest(rate)


def test_far_turns() -> None:
    """Nodes move on arcs, and sections have the sine of their angle as coordinate."""
    engine = ReferenceEngine(with_shaft("slider_crank_free_shaft"), 2, "euler", shaft="free")
    drive, linkage, step = ConstantSpeed(SPEED), engine.mechanism.linkage, 1e-6
    shaft = DrivenLinkage(engine, drive, stretches=True).shaft
    assert shaft is not None
    assert shaft.is_natural
    time = START + step * np.array([-1.0, 0.0, 1.0])
    mean = drive.motion(linkage, time)
    ahead = linkage.motion(mean.crank_angle + turned(time), mean.crank_speed + 3.0)
    moved = (ahead.origin - mean.origin) @ [1.0, 1.0j] * np.exp(-1j * mean.angle)
    turn = np.exp(1j * (ahead.angle - mean.angle))
    places = []
    for number, link in enumerate(engine.links):
        fields, (x, y) = link.fields, link.vectors
        origin = moved[:, number, None] * fields.along[x]
        vector = (turn[:, number, None] - 1) * (fields.tangential[y] - 1j * fields.tangential[x])
        places.append(np.outer(turn[:, number].imag, fields.tangential))
        places[-1][:, x], places[-1][:, y] = (origin + vector).real, (origin + vector).imag
    displacement = [q[1:2] for q in places]
    rate = [(q[2:] - q[:1]) / (2 * step) for q in places]
    none, joints = np.zeros(1), len(engine.topology.joint_names)
    run = Trajectory(
        time[1:2],
        displacement,
        rate,
        np.zeros((1, joints, 2)),
        none,
        np.zeros(joints),
        0.0,
        EnergyHistory(*6 * [none]),
        0.0,
        step,
        ShaftMotion(turned(time[1:2]), np.full(1, 3.0)),
    )
    found = shaft.turned_back(run)
    assert greatest(found.displacement) < 1e-9 * greatest(displacement)
    assert greatest(found.rate) < 1e-6 * greatest(rate)


def test_rotation_of_a_shaft_that_turns_far() -> None:
    """Its coordinates are the cosine less one and the sine of the angle."""
    engine = ReferenceEngine(with_shaft("slider_crank_free_shaft"), 2, "euler", shaft="free")
    linkage = DrivenLinkage(engine, ConstantSpeed(SPEED), stretches=True)
    shaft, angle, rate = linkage.shaft, 0.8, 3.0
    assert shaft is not None
    natural = np.array([np.cos(angle) - 1, np.sin(angle)])
    turning = rate * np.array([-np.sin(angle), np.cos(angle)])
    places, rates = ([np.zeros((1, link.size)) for link in linkage.links] for _ in range(2))
    for parts, wanted in ((places, natural), (rates, turning)):
        parts[shaft.link][0] = np.linalg.pinv(shaft.rows) @ wanted
    now, none, joints = linkage.motion(np.zeros(1)), np.zeros(1), len(engine.topology.joint_names)
    block = StepBlock(none, now.crank_speed, places, rates, np.zeros((1, joints, 2)), *6 * [none])
    found = shaft.carried(block, now)
    assert found.shaft is not None
    assert (found.shaft.rotation, found.shaft.rate) == pytest.approx((angle, rate), rel=1e-12)
    assert found.crank_speed == pytest.approx(SPEED + rate, rel=1e-12)


def test_the_torque_of_a_run_up_turns_the_arm_and_the_shaft() -> None:
    """Second moments of both times the acceleration, less the torque of a load over time."""
    length, inertia, drive = 0.3, 2e-3, ConstantSpeed(SPEED, run_up_time=0.1)
    load = Load(
        "table",
        AttachmentPoint("arm", length),
        ((0.0, 0.0), (0.0, 0.0)),
        (0.0, 0.4),
        over="time",
        at=(0.0, 0.1),
    )
    arm = Mechanism(RotatingArm(length), {"arm": SECTION}, shaft_inertia=inertia, loads=(load,))
    time = np.linspace(0.01, 0.09, 5)
    own = SECTION.mass_per_length * length**3 / 3
    wanted = (own + inertia) * drive.crank_acceleration(time) - 4.0 * time
    assert rigid_torque(arm, drive, time) == pytest.approx(wanted, rel=1e-9)


def test_a_load_over_time_that_never_changes_is_a_constant_load() -> None:
    """The torque that balances it acts on the shaft in both."""
    runs = []
    tables: list[dict[str, Any]] = [
        {"force": ((2.0, -3.0),), "torque": (0.05,)},
        {"force": 2 * ((2.0, -3.0),), "torque": (0.05, 0.05), "over": "time", "at": (0.0, 1.0)},
    ]
    for table in tables:
        load = Load("push", AttachmentPoint("coupler", 0.1), **table)
        mechanism = replace(with_shaft("aluminium_fourbar"), loads=(load,))
        engine = ReferenceEngine(mechanism, 2, "euler", component_modes=False, shaft="free")
        linkage = DrivenLinkage(engine, ConstantSpeed(SPEED), "none")
        nothing = np.zeros(linkage.size)
        runs.append(linear_run(linkage, nothing, nothing, np.linspace(0.0, 0.01, 3), 1e-4))
    constant, over_time = (run.shaft for run in runs)
    assert constant is not None
    assert over_time is not None
    assert np.abs(constant.rotation).max() > 1e-4
    np.testing.assert_allclose(over_time.rotation, constant.rotation, rtol=1e-9, atol=1e-12)
