"""V8: the aluminium four-bar at 20 rad/s against MBDyn 1.7.3 and OpenSees 3.7.1, every degree.

Histories of the coupler middle over the first revolution, from undeformed links with the rigid
motion's velocities. A case of the verification compares every 30 degrees.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import ResponseRequest
from flexmech.linkages import ConstantSpeed
from flexmech.verification.methods.running import stored_deflection

pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def running(aluminium):
    request = ResponseRequest(ConstantSpeed(20.0), revolutions=1, samples=360)
    return response([ReferenceEngine(aluminium), ExudynEngine(aluminium)], request)


def coupler(running, engine):
    return running.dataset["deflection"].sel(engine=engine, link="coupler").values * 1e3


@pytest.mark.parametrize(
    ("engine", "program"),
    [
        ("exudyn", "mbdyn"),
        ("exudyn", "opensees"),
        # Linear about the quasi-static equilibrium: the bow it misses is one of second order.
        ("reference", "mbdyn"),
    ],
)
def test_curves_follow_independent_codes(running, engine, program):
    history = stored_deflection(program=program, every=1)
    curve = coupler(running, engine)[: len(history)]
    peak = np.abs(history).max()
    assert np.abs(curve).max() == pytest.approx(peak, rel=1e-2)
    assert np.abs(curve - history).max() < 2e-2 * peak


def test_checks_of_the_run(running):
    data = running.dataset
    assert (data["energy_error"] < 1e-4).all()
    assert (data["constraint_drift"] < 1e-9).all()
    assert (data["step_error"] < 2e-2).all()
