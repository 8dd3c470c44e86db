"""Identified modes of the four-bars against the eigen model, at crank angles all over the turn."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import HammerRequest, LinkPoint, ReferenceEngine, hammer_test, load_mechanism
from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.example_models import example_model

ANGLES = np.radians([0.0, 45.0, 96.9, 150.0, 210.0, 300.0])
FOUR_BARS = ["aluminium_fourbar", "steel_fourbar", "composite_fourbar"]


@pytest.mark.parametrize("method", ["lscf", "circle-fit"])
@pytest.mark.parametrize(
    "name",
    [FOUR_BARS[0], *(pytest.param(name, marks=pytest.mark.thorough) for name in FOUR_BARS[1:])],
)
def test_first_three_modes_without_noise(name: str, method: str) -> None:
    """Issue: frequencies within 0.1 %, damping within 5 %.

    At 300 deg of the aluminium four-bar a fifth mode overlaps the band's end.
    """
    engine = ReferenceEngine(load_mechanism(example_model(name)), elements=4)
    if name != "composite_fourbar":
        engine = with_damping_ratio(engine, 0.005)
    request = HammerRequest(
        ANGLES if name != FOUR_BARS[0] or method == "lscf" else ANGLES[[2, 5]],
        impact=LinkPoint("coupler", 0.4),
        response=LinkPoint("rocker", 0.3),
        modes=3,
        method=method,  # type: ignore[arg-type]
    )
    data = hammer_test(engine, request).dataset.isel(mode=slice(0, 3))
    np.testing.assert_allclose(data["identified_frequency"], data["eigen_frequency"], rtol=1e-3)
    np.testing.assert_allclose(
        data["identified_damping_ratio"], data["eigen_damping_ratio"], rtol=0.05
    )
