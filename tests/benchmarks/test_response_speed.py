"""Speed of runs in time, model building included, one thread, the same time step for both."""

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.linkages import CrankDrive
from flexmech.threads import one_thread
from flexmech.time_domain import DrivenLinkage, LinkState, linear_run, periodic_turn

DRIVE = CrankDrive(20.0)
TURN = DRIVE.revolution_time
STEPS = 2880


@pytest.fixture(autouse=True)
def _one_thread():
    with one_thread():
        yield


def samples(turns):
    return TURN / 720 * np.arange(round(720 * turns) + 1)


def reference_run(mechanism, elements, turns, level):
    engine = ReferenceEngine(mechanism, elements)
    linkage = DrivenLinkage(engine, DRIVE, level, stretches=level == "equilibrium")
    nothing = np.zeros(linkage.size)
    return linear_run(linkage, nothing, nothing, samples(turns), TURN / STEPS)


def exudyn_run(mechanism, elements, turns):
    engine = ExudynEngine(mechanism, elements)
    return engine.simulate(DRIVE, LinkState.rigid(engine.links), samples(turns), TURN / STEPS)


@pytest.mark.parametrize("level", ["axial", "equilibrium"])
@pytest.mark.parametrize("elements", [8, 16, 32])
def test_transient_against_exudyn(aluminium, against, elements, level):
    against(
        f"transient, 4 turns, {elements} elements, {level}: against Exudyn",
        lambda: reference_run(aluminium, elements, 4, level),
        lambda: exudyn_run(aluminium, elements, 4),
        rounds=3,
        plain_rounds=1,
    )


def test_periodic_motion_against_settling(aluminium, against):
    """Damping of 0.3 % in the first mode: 1 % of the start is left after 80 turns."""
    time = 2e-5
    sections = {k: s.with_damping_time(time) for k, s in aluminium.sections.items()}
    mechanism = replace(aluminium, sections=sections)
    turns = np.log(100) / (np.pi * time * (2 * np.pi * 45.0) * 45.0 * TURN)
    against(
        f"periodic motion against Exudyn's {turns:.0f} turns until 1 % of the start is left",
        lambda: periodic_turn(
            DrivenLinkage(
                ReferenceEngine(mechanism, 8), DRIVE, "equilibrium", detail=2.0, with_energy=False
            ),
            960,
        ),
        lambda: exudyn_run(mechanism, 8, 2),
        rounds=3,
        plain_rounds=1,
        plain_covers=2 / turns,
    )
