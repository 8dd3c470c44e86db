"""Loads of a quasi-static equilibrium in which springs and turning forces depend on displacements.

An engine's solver displaces the links under given forces. Those of the connectors are sought that
are theirs at that displacement: from the last one a step of Newton's method with the links' tangent
stiffness predicts where the links will be, and what the connectors do there is the next load.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexmech.linear_system.connectors import Connectors
from flexmech.linear_system.link_frames import LinkFrames
from flexmech.linear_system.position_errors import refuse_positions
from flexmech.linear_system.quasi_static import greatest
from flexmech.linear_system.rotation_terms import RotationTerms
from flexmech.linkages import RigidMotion
from flexmech.types import FloatArray

__all__ = ["balanced_loads"]

MOST_PASSES = 60
# Greatest change of a load in the last pass, relative to the greatest.
LAST_PASS = 1e-10
STILL = RotationTerms.all_or_none(False)


def balanced_loads(
    connectors: Connectors,
    frames: LinkFrames,
    motion: RigidMotion,
    loads: Sequence[FloatArray],
    solve: Callable[[list[FloatArray]], list[FloatArray]],
    tangents: Callable[[list[FloatArray]], list[FloatArray]],
) -> list[FloatArray]:
    """Loads on the links with those of connectors.

    Parameters
    ----------
    connectors : Connectors
        Of the links of ``frames``.
    frames : LinkFrames
    motion : RigidMotion
        Batch of shape (B,).
    loads : sequence of ndarray, shape (B, n_link)
        Others.
    solve : callable
        Displacements (B, n_link) at equilibrium under loads.
    tangents : callable
        Tangent stiffness (B, n_link, n_link) at displacements.

    Returns
    -------
    list of ndarray, shape (B, n_link)

    Raises
    ------
    ComputationError
        Where no forces of the connectors are found; names the crank angle.
    """
    acting = connectors.forces(motion)
    if not connectors.depend_on_displacement:
        return _sum(loads, acting)
    stiffness = [link.stiffness for link in frames.links]
    displacement = [np.zeros_like(force) for force in acting]
    gap = frames.gather(motion, _sum(loads, acting))
    for number in range(MOST_PASSES):
        links = frames.assemble(motion, stiffness, STILL)
        held = connectors.added(frames, motion, links, STILL, "equilibrium", displacement)
        step = frames.link_coordinates(motion, np.linalg.solve(held.stiffness, gap[..., None]))
        moved = [q + change[..., 0] for q, change in zip(displacement, step, strict=True)]
        before, acting = acting, connectors.forces(motion, moved)
        apart = greatest([b - a for a, b in zip(before, acting, strict=True)])
        size = np.maximum(greatest(acting), greatest(loads))
        if number and not np.any(apart > LAST_PASS * size):
            return _sum(loads, acting)
        displacement = solve(_sum(loads, acting))
        stiffness = tangents(displacement)
        there = connectors.forces(motion, displacement)
        gap = frames.gather(motion, [b - a for a, b in zip(acting, there, strict=True)])
    refuse_positions(
        motion,
        apart > LAST_PASS * size,
        "no equilibrium with the springs and the forces that turn with the links",
        f": their forces still change by {float((apart / size).max()):.3g} of the greatest after "
        f"{MOST_PASSES} passes; use softer springs or smaller loads, or prestress 'axial'",
    )
    return _sum(loads, acting)


def _sum(loads: Sequence[FloatArray], others: Sequence[FloatArray]) -> list[FloatArray]:
    return [a + b for a, b in zip(loads, others, strict=True)]
