"""Normal stress of running links by both engines."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flexmech import ExudynEngine, ReferenceEngine, ResponseRequest, load_mechanism, response

MODELS = Path(__file__).parents[2] / "models"


def test_greatest_stresses_agree() -> None:
    """Bending by the displacements of each engine, the normal force by its joint forces."""
    mechanism = load_mechanism(MODELS / "steel_fourbar.toml")
    engines = [ReferenceEngine(mechanism, 8), ExudynEngine(mechanism, 8)]
    found = response(engines, ResponseRequest(20.0, 0.5)).dataset
    for name in ("peak_stress", "peak_axial_stress"):
        own, other = found[name].values
        np.testing.assert_allclose(own, other, rtol=0.01)
    place = found["peak_stress_place"] / found["length"]
    np.testing.assert_allclose(place[0], place[1], atol=0.1)
