"""Speed of runs in time, model building included, one thread.

Linear equations run with Exudyn's time step. Links that stretch run by a method of fourth order,
with longer steps and a smaller error: the last benchmark but one states both errors.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.analyses.response.measurements import deflections
from flexmech.linkages import ConstantSpeed
from flexmech.mechanics.running import DrivenLinkage, LinkState
from flexmech.solvers import linear_run, periodic_turn
from flexmech.threads import one_thread

DRIVE = ConstantSpeed(20.0)
TURN = DRIVE.revolution_time
STEPS = 2880
STRETCHING_STEPS = 800
# Frequency in Hz up to which joint forces are compared; what the longer steps show.
BAND = 300.0


@pytest.fixture(autouse=True)
def _one_thread():
    with one_thread():
        yield


def samples(turns):
    return TURN / 720 * np.arange(round(720 * turns) + 1)


def reference_run(mechanism, elements, turns, level, *, refined=1, band=None):
    engine = ReferenceEngine(mechanism, elements)
    stretches = level == "equilibrium"
    linkage = DrivenLinkage(engine, DRIVE, level, stretches=stretches)
    nothing = np.zeros(linkage.size)
    step = TURN / (refined * (STRETCHING_STEPS if stretches else STEPS))
    return linear_run(linkage, nothing, nothing, samples(turns), step, band=band)


def exudyn_run(mechanism, elements, turns, *, refined=1, band=None):
    engine = ExudynEngine(mechanism, elements)
    start, step = LinkState.rigid(engine.links), TURN / (refined * STEPS)
    return engine.simulate(DRIVE, start, samples(turns), step, band=band)


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


def test_errors_of_the_steps(aluminium, benchmark, tell):
    """Errors over four turns, against runs with an eighth of the step."""

    def errors(run, engine):
        coarse, fine = (run(refined=refined, band=BAND) for refined in (1, 8))
        curves, expected = (
            deflections(engine(aluminium, 8), one.displacement) for one in (coarse, fine)
        )
        apart = np.linalg.norm(coarse.joint_force - fine.joint_force, axis=-1).max(axis=0)
        return (
            np.abs(curves - expected).max() / np.abs(expected).max(),
            (apart / np.linalg.norm(fine.joint_force, axis=-1).max(axis=0)).max(),
        )

    ours = errors(partial(reference_run, aluminium, 8, 4, "equilibrium"), ReferenceEngine)
    other = errors(partial(exudyn_run, aluminium, 8, 4), ExudynEngine)
    for name, own, its in zip(("deflections", "joint forces"), ours, other, strict=True):
        tell(f"transient, 4 turns, equilibrium: error of {name}", f"{own:13.4f} {its:15.4f}")
    assert np.less(ours, other).all()
    benchmark.pedantic(lambda: None, rounds=1)


def test_periodic_motion_against_settling(aluminium, against):
    """Damping of 0.3 % in the first mode: 1 % of the start is left after 80 turns."""
    time = 2e-5
    sections = {k: s.with_damping_time(time) for k, s in aluminium.sections.items()}
    mechanism = replace(aluminium, sections=sections)
    turns = np.log(100) / (np.pi * time * (2 * np.pi * 45.0) * 45.0 * TURN)
    against(
        f"periodic motion against Exudyn's {turns:.0f} turns until 1 % of the start is left",
        lambda: periodic_turn(
            DrivenLinkage(ReferenceEngine(mechanism, 8), DRIVE, "equilibrium", detail=2.0),
            960,
        ),
        lambda: exudyn_run(mechanism, 8, 2),
        rounds=3,
        plain_rounds=1,
        plain_covers=2 / turns,
    )
