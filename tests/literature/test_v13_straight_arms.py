"""V13 of the validation numbers: rotating planar L-beam, linear theory about its straight arms.

The published frequencies are cases of the verification. Those stated here are of 28 Hermite
elements with the tension at a linear preload.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import Mechanism, ReferenceEngine, load_mechanism
from flexmech.analyses import solve_modes
from flexmech.linear_system import (
    ChainMatrix,
    RotationTerms,
    element_tensions,
    inertia_loads,
    straight_forces,
    whole,
)


@pytest.fixture(scope="module")
def l_beam() -> Mechanism:
    """Wallrapp & Schwertassek 1998."""
    return load_mechanism(Path(__file__).parents[2] / "models" / "rotating_l_beam.toml")


@pytest.mark.parametrize(
    ("speed", "reduced"),
    [(0.0, False), (0.0, True), (6.0, True), pytest.param(6.0, False, marks=pytest.mark.thorough)],
)
def test_with_the_tension_of_the_straight_arms(
    l_beam: Mechanism, speed: float, reduced: bool
) -> None:
    engine = ReferenceEngine(l_beam, 28, "euler", component_modes=reduced)
    found = solve_modes(engine.linear_system(0.3, speed, prestress="axial"), 3).frequency[0]
    stated = {0.0: (0.9614, 7.0364, 16.757), 6.0: (1.0383, 7.5100, 17.117)}[speed]
    np.testing.assert_allclose(found, stated, rtol=2e-3 if speed else 3e-5)


def test_tension_of_the_arms_displaced_by_linear_theory(l_beam: Mechanism) -> None:
    """The stated Hermite values: k_G with the tension of a linear preload that is iterated."""
    engine = ReferenceEngine(l_beam, 28, "euler", component_modes=False)
    motion = l_beam.linkage.motion(np.array([0.3]), 6.0)
    frames = engine.equilibrium.frames
    loads = inertia_loads(engine.links, motion, (0.0, 0.0))
    straight = straight_forces(l_beam, frames, motion, loads)
    tensions = element_tensions(l_beam, engine.nodes, motion, straight.links)
    for _ in range(30):
        tangent = [
            whole(chain.model.stiffness)
            + ChainMatrix(chain.elements.geometric_stiffness(tensions[number])).whole()
            for number, chain in engine.chains.items()
        ]
        matrices = frames.assemble(motion, tangent, RotationTerms())
        moved = np.linalg.solve(matrices.stiffness, frames.gather(motion, loads)[..., None])
        change = 0.0
        for number, q in enumerate(frames.link_coordinates(motion, moved)):
            elements = engine.chains[number].elements
            along = np.diff(q[0, ::3, 0]) / elements.length
            mean = elements.section.axial_stiffness * along
            change = max(change, np.abs(mean - tensions[number][0, :, 0]).max())
            tensions[number][0, :, 0] = mean
    assert change < 1e-6
    system = engine.linear_system(0.3, 6.0, prestress="none")
    iterated = replace(system, stiffness=matrices.stiffness)
    found = solve_modes(iterated, 3).frequency[0]
    np.testing.assert_allclose(found, (1.0383, 7.5100, 17.117), rtol=2e-4)
