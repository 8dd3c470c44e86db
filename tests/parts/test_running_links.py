"""Links in a state of a run: their tangent is the derivative of their internal forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine
from tests.support.mechanisms import case


@pytest.mark.parametrize("make", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("name", ["aluminium four-bar", "unsymmetric laminates"])
def test_tangents_are_the_derivatives_of_the_internal_forces(name: str, make: Any) -> None:
    """About displacements drawn at random, of a hundredth of the links."""
    mechanism = case(name).mechanism
    engine = make(mechanism, elements=3)
    motion = mechanism.linkage.motion(np.array([0.4]), np.array([30.0]))
    random = np.random.default_rng(4)
    state = [2e-3 * random.standard_normal((1, link.size)) for link in engine.links]
    way = [random.standard_normal((1, link.size)) for link in engine.links]
    step = 1e-7
    ahead, behind = (
        engine.running_links(motion, [q + s * step * w for q, w in zip(state, way, strict=True)])
        for s in (1, -1)
    )
    stressed = engine.running_links(motion, state)
    for number, w in enumerate(way):
        slope = (ahead.internal_force[number] - behind.internal_force[number]) / (2 * step)
        expected = stressed.tangent[number] @ w[0]
        assert np.abs(slope - expected).max() < 1e-5 * np.abs(expected).max()
