"""The running linkage in moving modes under its loads, against the full linear equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flexmech
from flexmech.analyses.damping_ratios import with_damping_ratio, with_damping_times
from flexmech.linear_system import Engine
from flexmech.linkages import GROUND, AttachmentPoint, ConstantSpeed, Spring
from flexmech.materials import Material
from flexmech.sections import BeamSection
from flexmech.time_domain import (
    DrivenLinkage,
    FreeAndForced,
    forced_modes,
    linear_run,
    periodic_turn,
)

SPEED = 30.0


def damped(engine: type[Engine], model: str = "aluminium_fourbar") -> Engine:
    mechanism = flexmech.load_mechanism(f"models/{model}.toml")
    return with_damping_ratio(engine(mechanism, 4), 0.01)


@pytest.mark.parametrize(
    ("kind", "speed"), [(flexmech.ReferenceEngine, -SPEED), (flexmech.ExudynEngine, SPEED)]
)
def test_motion_from_a_state_is_that_of_the_full_equations(kind, speed):
    """Any motion is the periodic one and a free one: 2e-3 of it is left to the higher modes."""
    engine, drive = damped(kind), ConstantSpeed(speed)
    linkage = DrivenLinkage(engine, drive, "equilibrium")
    time = np.linspace(0.0, 1.5 * drive.revolution_time, 301)
    run = linear_run(linkage, linkage.unstressed(), np.zeros(linkage.size), time, 5e-5)
    row = engine.links[1].curvature
    full = run.displacement[1] @ row
    motion = forced_modes(engine, speed, [[None, row, None]]).with_damping([1.0, 1.0, 1.0])
    forced, free = motion.readings(drive.crank_angle(time) * np.sign(speed) / (2 * np.pi))
    share = np.linalg.lstsq(free, full - forced, rcond=None)[0]
    left = full - forced - free @ share
    assert np.abs(full - forced).max() > 0.3 * np.abs(full).max()
    assert np.sqrt(np.mean(left**2)) < 2e-3 * full.std()


def test_the_forced_motion_is_periodic_from_any_crank_angle():
    engine = damped(flexmech.ReferenceEngine)
    motion = forced_modes(engine, SPEED, [[None, engine.links[1].curvature, None]])
    moved = motion.with_damping([1.0, 1.0, 1.0])
    turns = np.linspace(0.0, 2.0, 145)
    forced, _ = moved.readings(turns)
    assert forced[72:] == pytest.approx(forced[:73], abs=1e-9 * np.abs(forced).max())
    later, _ = moved.readings(turns + 25 / 72)
    assert later[:-25] == pytest.approx(forced[25:], abs=1e-6 * np.abs(forced).max())


def test_a_motion_that_no_turn_returns_drifts_on():
    """At a critical speed without damping no motion is periodic: a force pushes one state on."""
    steps, push = 64, 0.25
    transition = np.array([[1.0, 0.0, push], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]])
    moved = FreeAndForced(
        np.tile(transition, (steps, 1, 1)),
        np.tile([[1.0, 0.0]], (steps, 1, 1)),
        np.zeros((steps, 1)),
    )
    phase = np.linspace(0.0, 3.5, 57)
    forced, free = moved.readings(phase)
    assert forced - forced[0] == pytest.approx(push * steps * phase, abs=1e-9)
    assert free[:, 0] == pytest.approx(np.ones(57), abs=1e-9)


def test_each_link_has_its_own_damping():
    """Damping of one link times a factor is that of a model whose link is damped so."""
    engine = damped(flexmech.ReferenceEngine)
    rows = [[None, engine.links[1].curvature, None]]
    phase = np.linspace(0.0, 1.0, 101)
    times = {name: s.damping.bending for name, s in engine.mechanism.sections.items()}
    other = with_damping_times(engine, {"coupler": 3 * times["coupler"]})
    wanted, _ = forced_modes(other, SPEED, rows).with_damping([1, 1, 1]).readings(phase)
    found, _ = forced_modes(engine, SPEED, rows).with_damping([1, 3, 1]).readings(phase)
    plain, _ = forced_modes(engine, SPEED, rows).with_damping([1, 1, 1]).readings(phase)
    size = np.abs(wanted).max()
    assert found == pytest.approx(wanted, abs=2e-5 * size)
    assert np.abs(plain - wanted).max() > 1e-2 * size


def test_a_rotating_arm_bends_under_its_own_weight_as_the_full_equations_say():
    """The weight turns once a turn in the arm's frame; nothing else excites bending."""
    arm = damped(flexmech.ReferenceEngine, "rotating_arm")
    engine = arm.with_(mechanism=replace(arm.mechanism, gravity=(0.0, -9.81)))
    turn = periodic_turn(DrivenLinkage(engine, ConstantSpeed(10.0), "axial"), 720)[0]
    row = engine.links[0].shape[-1, 1]
    found, _ = (
        forced_modes(engine, 10.0, [[row]], "axial")
        .with_damping([1.0])
        .readings(np.arange(720) / 720)
    )
    assert np.abs(turn @ row).max() > 1e-4
    assert found == pytest.approx(turn @ row, abs=1e-3 * np.abs(turn @ row).max())


def test_a_bowed_arm_under_its_weight_moves_alike_in_both_engines():
    """The inertia of its displacement is part of the loads, which changes the tip by 1 %."""
    found = []
    for kind in (flexmech.ReferenceEngine, flexmech.ExudynEngine):
        mechanism = replace(damped(kind, "rotating_arm").mechanism, gravity=(0.0, -9.81))
        engine = kind(mechanism, 4, component_modes=False)
        row = engine.links[0].shape[-1, 1]
        motion = forced_modes(engine, 10.0, [[row]], "equilibrium").with_damping([1.0])
        found.append(motion.readings(np.arange(90) / 90)[0])
    assert np.abs(found[0]).max() > 1e-3
    assert found[1] == pytest.approx(found[0], abs=1e-4 * np.abs(found[0]).max())


def test_a_sprung_arm_moves_as_the_full_equations_say():
    """The spring's force at the bowed arm is not that at the straight one."""
    tip = AttachmentPoint("arm", 0.3)
    spring = Spring("hold", AttachmentPoint(GROUND, 0.2, 0.3), tip, 1.0, 0.1)
    strip = BeamSection.rectangle(Material(68.9e9, 2923.0), 1.5e-3, 25.4e-3)
    arm = flexmech.Mechanism(flexmech.RotatingArm(0.3), {"arm": strip}, springs=(spring,))
    engine = with_damping_ratio(flexmech.ReferenceEngine(arm, 3, "euler"), 0.02)
    turn = periodic_turn(DrivenLinkage(engine, ConstantSpeed(10.0), "equilibrium"), 720)[0]
    row = engine.links[0].shape[-1, 1]
    motion = forced_modes(engine, 10.0, [[row]], "equilibrium").with_damping([1.0])
    found = motion.readings(np.arange(720) / 720)[0]
    assert np.abs(turn @ row).max() > 1e-3
    assert found == pytest.approx(turn @ row, abs=6e-3 * np.abs(turn @ row).max())
