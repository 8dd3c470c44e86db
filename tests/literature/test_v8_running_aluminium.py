"""V8: the aluminium four-bar at 20 rad/s against MBDyn 1.7.3 and OpenSees 3.7.1.

Histories of the coupler middle over the first revolution, from undeformed links with the
rigid motion's velocities: ``data/aluminium_20_rad_s_history.csv``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.analyses.response import ResponseRequest, response
from flexmech.linkages import CrankDrive

HISTORY = Path(__file__).parent / "data" / "aluminium_20_rad_s_history.csv"
EVERY_30_DEG = [0, -0.4738, -0.4539, -0.2266, 0.2827, 0.8470, 0.8605]
EVERY_30_DEG += [0.3319, -0.3184, -0.4582, -0.0387, 0.5690, 0.2087]


@pytest.fixture(scope="module")
def running(aluminium):
    request = ResponseRequest(CrankDrive(20.0), revolutions=1, samples=360)
    return response([ReferenceEngine(aluminium), ExudynEngine(aluminium)], request)


def coupler(running, engine):
    return running.dataset["deflection"].sel(engine=engine, link="coupler").values * 1e3


@pytest.mark.parametrize("column", ["mbdyn_mm", "opensees_mm"])
def test_exudyn_follows_independent_codes(running, column):
    history = pd.read_csv(HISTORY, comment="#")[column].dropna().to_numpy()
    curve = coupler(running, "exudyn")[: len(history)]
    peak = np.abs(history).max()
    assert np.abs(curve).max() == pytest.approx(peak, rel=1e-2)
    assert np.abs(curve - history).max() < 2e-2 * peak


def test_linear_reference_follows_them_too(running):
    """Linear about the quasi-static equilibrium: the bow it misses is one of second order."""
    history = pd.read_csv(HISTORY, comment="#")["mbdyn_mm"].to_numpy()
    curve, peak = coupler(running, "reference"), np.abs(history).max()
    assert np.abs(curve).max() == pytest.approx(peak, rel=1e-2)
    assert np.abs(curve - history).max() < 2e-2 * peak


def test_printed_values_every_30_degrees(running):
    printed = coupler(running, "exudyn")[::30]
    assert np.abs(printed - EVERY_30_DEG).max() < 0.02 * 1.2249


def test_checks_of_the_run(running):
    data = running.dataset
    assert (data["energy_error"] < 1e-4).all()
    assert (data["constraint_drift"] < 1e-9).all()
    assert (data["step_error"] < 2e-2).all()
