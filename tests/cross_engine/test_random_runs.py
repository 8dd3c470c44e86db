"""Runs of random planar linkages under loads, springs and dampers, from every kind of start."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, response
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.plan import planned
from flexmech.analyses.response.run import run_engine
from flexmech.time_domain import DrivenLinkage, linear_run
from tests.support.random_runs import random_run

# Below this part of a peak an error is not worth a comparison.
NEGLIGIBLE = 3e-5


# Without the long form, a slider-crank under two loads and a spring.
@pytest.mark.parametrize(
    "seed",
    [54, *(pytest.param(s, marks=pytest.mark.thorough) for s in (53, 4, 9, 40, 41, 44, 45, 48))],
)
def test_engines_agree_and_account_for_all_energy(seed: int) -> None:
    case = random_run(seed)
    run = response(
        [engine(case.mechanism, 4) for engine in (ReferenceEngine, ExudynEngine)], case.request
    )
    gaps, forces, errors = run.agreement(), run.force_agreement(), run.errors()
    assert gaps is not None
    assert forces is not None
    # Of links that deflect by a thousandth of the softest one what the step leaves is more.
    allowed = np.maximum(1e-2, errors["deflection"].sel(link=gaps["link"]).sum("engine"))
    assert (gaps <= allowed).all()
    assert float(forces["peak_joint_force"].max()) < 2e-2
    assert float(forces["peak_driving_torque"]) < 2e-2
    assert float(run.dataset["energy_error"].max()) < 2e-5


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [63, 8, 40, 60])
def test_errors_told_by_the_step_are_true_or_bounds(seed: int) -> None:
    """Against a quarter of the step that the run chose, where links stretch."""
    case = random_run(seed)
    engine, request = ReferenceEngine(case.mechanism, 4), case.request
    assert request.start == "rigid"
    plan = planned([engine], request)
    run = run_engine(engine, request, plan, lambda *told: None)
    linkage = DrivenLinkage(engine, request.drive, modes=request.modes, stretches=True)
    state, nothing = linkage.unstressed(), np.zeros(linkage.size)
    coarse, told = run.trajectory, run.step_error
    fine = linear_run(linkage, state, nothing, plan.time, coarse.step / 4, band=plan.band)
    curves, expected = deflections(engine, coarse), deflections(engine, fine)
    apart = np.linalg.norm(coarse.joint_force - fine.joint_force, axis=-1).max(axis=0)
    bent = np.abs(expected).max(axis=0)
    true = np.abs(curves - expected).max(axis=0) / np.where(bent > 0, bent, 1.0)
    assert true.max() > NEGLIGIBLE
    assert (true <= np.maximum(2 * told.of["deflection"], NEGLIGIBLE)).all()
    true = apart / fine.peak_joint_force
    assert (true <= np.maximum(2 * told.of["force"], NEGLIGIBLE)).all()
