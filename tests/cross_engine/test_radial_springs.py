"""Joints that radial springs hold: the gap that the joint's force opens is in the equilibrium."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, Mechanism, ReferenceEngine, natural_frequencies
from flexmech.linkages import JointSpring
from tests.cross_engine.test_exudyn_connectors import SprungFourBar, strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

ANGLES = np.radians([130.0, 310.0])


def sprung(*rigid: str) -> Mechanism:
    return strips(
        SprungFourBar(FOUR_BAR, rigid=rigid),
        joint_springs=(
            JointSpring("B", 0.5, 0.0, 1.0, 2e4, 1.0),
            JointSpring("O4", 0.3, 0.002, 0.0, 1e4, 0.5),
        ),
    )


@pytest.mark.parametrize("rigid", [(), ("rocker",), ("crank",)], ids=str)
def test_the_gap_is_in_the_equilibrium_of_both_engines(rigid: tuple[str, ...]) -> None:
    """Without it frequencies of the elastic links were 1.5e-3 apart."""
    mechanism = sprung(*rigid)
    engines = (ReferenceEngine(mechanism, 10, "euler"), ExudynEngine(mechanism, 10, "ancf"))
    motion = mechanism.linkage.motion(ANGLES, 20.0)
    moved = []
    for engine in engines:
        displacement = engine.stressed_links(motion, "equilibrium").displacement
        assert displacement is not None
        ends = [link.shape[[0, -1]] for link in engine.links]
        pairs = zip(ends, displacement, strict=True)
        moved.append(np.stack([np.einsum("scn,bn->bsc", end, q) for end, q in pairs]))
    rocker = mechanism.linkage.topology.index("rocker")
    gap = np.linalg.norm(moved[0][rocker, :, 0], axis=1)  # at its pivot
    assert gap.min() > 1e-4
    np.testing.assert_allclose(moved[1], moved[0], rtol=0, atol=1e-4 * gap.min())
    first, second = (natural_frequencies(engine, ANGLES, 20.0, modes=3) for engine in engines)
    np.testing.assert_allclose(second, first, rtol=3e-5)
