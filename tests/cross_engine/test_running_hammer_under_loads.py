"""A hammer on the running linkage under loads and springs: Exudyn's runs against the prediction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    JointSpring,
    LinkPoint,
    Load,
    Mechanism,
    RunningHammerRequest,
    running_hammer_test,
)
from flexmech.linkages.attachments import AttachmentPoint


@pytest.fixture
def loaded(aluminium: Mechanism) -> Mechanism:
    """A rocker pulled over the turn, and a stiff spring in its joint with the coupler."""
    turn = tuple(np.radians([0.0, 90.0, 180.0, 270.0]).tolist())
    pull = ((0.0, -2.0), (1.0, 0.0), (0.5, 1.0), (0.0, 0.0))
    load = Load(
        "pull", AttachmentPoint("rocker", 0.1), pull, (0.0,) * 4, over="crank_angle", at=turn
    )
    return replace(aluminium, loads=(load,), joint_springs=(JointSpring("B", 0.8, 1e-4),))


@pytest.mark.thorough
def test_exudyn_is_hit_under_loads_and_springs(loaded: Mechanism) -> None:
    hit, seen = map(LinkPoint.parse, ("coupler:0.5", "rocker:0.5"))
    request = RunningHammerRequest(15.0, hit, seen, damping_ratio=0.05, bandwidth=80.0, orders=1)
    found = running_hammer_test(ExudynEngine(loaded, 2), request).dataset
    # The runs begin on the periodic motion that loads and springs make.
    assert found.attrs["twin_defect"] < 2e-3
    apart = np.abs(found["identified_peak"] - found["predicted_peak"])
    assert float(apart.max() / found["predicted_peak"].max()) < 0.02
