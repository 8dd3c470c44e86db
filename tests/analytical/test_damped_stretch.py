"""Damped links that stretch by the square of their slopes: forces, steps and energies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ConstantSpeed, Mechanism, ReferenceEngine
from flexmech.time_domain import DrivenLinkage, Trajectory, linear_run
from flexmech.time_domain.integrators import stretch_march
from tests.cross_engine.joined_linkages import QuickReturn
from tests.cross_engine.test_exudyn_connectors import strips

DAMPING_TIME = 2e-4


def damped(mechanism: Mechanism) -> Mechanism:
    sections = {k: s.with_damping_time(DAMPING_TIME) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


@pytest.fixture(scope="module")
def linkage(aluminium: Mechanism) -> DrivenLinkage:
    return DrivenLinkage(ReferenceEngine(damped(aluminium), 2), ConstantSpeed(20.0), stretches=True)


def run(linkage: DrivenLinkage, turns: float, steps: int) -> Trajectory:
    """From rest in the frames of the rigid links."""
    time = turns * linkage.drive.revolution_time * np.linspace(0.0, 1.0, 11)
    nothing = np.zeros(linkage.size)
    return linear_run(linkage, nothing, nothing, time, linkage.drive.revolution_time / steps)


def test_forces_one_by_one_are_those_of_the_links(linkage: DrivenLinkage) -> None:
    """The damping feels that ends turn against the links that follow them."""
    random, time = np.random.default_rng(1), np.array([0.01, 0.07])
    motion, stretch = linkage.motion(time), linkage.stretch
    assert stretch is not None
    assert stretch.is_damped
    z, rate = 1e-3 * random.normal(size=(2, 2, linkage.size))
    parts = linkage.frames.link_motion(motion, z, rate, 0 * z)
    forces = [
        sum(own.nonlinear_forces(q, q_1))
        for own, (q, q_1, _) in zip(stretch.links, parts, strict=True)
    ]
    wanted = linkage.frames.gather(motion, forces)
    found = stretch.nonlinear_forces(stretch.pin_rotations(motion), z, rate)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_both_ways_of_solving_a_step_agree(
    linkage: DrivenLinkage, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Newton's method takes the tangent of the bowed links, with the damping of turned ends."""
    found = []
    for passes in ((), (6,)):
        monkeypatch.setattr(stretch_march, "PASSES", passes)
        found.append(run(linkage, 0.05, 1440).displacement)
    for newton, usual in zip(*found, strict=True):
        np.testing.assert_allclose(usual, newton, rtol=0, atol=1e-6 * np.abs(newton).max())


def test_energies_balance_where_a_link_slides_on_a_moving_one() -> None:
    """The forces between the point and its guide do work at the shaft."""
    engine = ReferenceEngine(damped(strips(QuickReturn())), 2, "euler")
    linkage = DrivenLinkage(engine, ConstantSpeed(10.0), stretches=True)
    found = run(linkage, 0.05, 2000)
    assert np.ptp(found.energy.drive_work) > 0.01 * found.energy.kinetic.max()
    assert found.energy_error < 1e-5
