"""What the quasi-static equilibria of all engines have in common.

Each engine has a Newton's method of its own. How long it may go on, what it may leave out of
balance and which equilibria it must not find are the same for all.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.joints.position_errors import LESS_LOADED, refuse_positions
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import RigidMotion, Topology
from flexmech.sections import BeamSection

MAX_ITERATIONS = 40
"""Of Newton's method in one load step."""
LOAD_STEPS = (1, 5, 25)
"""Where all load at once leads nowhere, it is brought on in steps, swelling along with it."""
RELATIVE_RESIDUAL = 1e-10
"""Part of the load that may be out of balance when Exudyn's static solver stops.

Convergence is quadratic: the last iteration brings far more than that.
"""
LAST_STEP = 5e-8
"""Newton's method takes its last step where that turns no section, and moves no node by a part of
the linkage's size, by more than this.

The error that is left is the step's square times at most 8000 on random mechanisms, loaded twice as
much as at their speeds: 2e-11. Forces out of balance are no measure: one that is lost in the
round-off of a stiff link may bend a soft one that is pinned to it.
"""
ROUND_OFF = 8 * float(np.finfo(float).eps)
"""What round-off leaves of forces between nodes that cancel, relative to these forces."""
# A link displaced by more than this part of its length is no longer near the rigid linkage,
# about whose motion vibrations are asked for; Newton's method may have found any equilibrium.
FARTHEST = 0.5


def free_load(section: BeamSection, length: float) -> float:
    """Force in N by which swelling that is held back pulls and bends an element of a length."""
    bending = abs(section.free_curvature) * section.bending_stiffness / length
    return bending + abs(section.free_strain) * section.axial_stiffness


def refuse_large_displacements(
    topology: Topology,
    links: Sequence[LinkModel],
    motion: RigidMotion,
    displacements: Sequence[FloatArray],
) -> None:
    """Refuse an equilibrium far from the rigid linkage.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        Unreduced.
    motion : RigidMotion
        Batch of shape (B,).
    displacements : sequence of ndarray, shape (B, n_link)
        Elastic displacement of each link in its frame.

    Raises
    ------
    ComputationError
        Where a link is displaced by more than half its length; names the crank angle.
    """
    for link, body, q in zip(links, topology.links, displacements, strict=True):
        moved = np.einsum("scn,bn->bsc", link.shape, q)
        farthest = np.linalg.norm(moved, axis=2).max(axis=1) / body.length
        too_far = farthest > FARTHEST
        refuse_positions(
            motion,
            too_far,
            f"the {link.name} is displaced by {100 * farthest[too_far.argmax()]:.3g} % of its "
            "length",
            f": that equilibrium is not near the rigid linkage; {LESS_LOADED} or stiffen the links",
        )


def greatest(vectors: Iterable[FloatArray]) -> FloatArray:
    """Greatest entry of several batches of vectors.

    Parameters
    ----------
    vectors : iterable of ndarray, shape (B, n_link)

    Returns
    -------
    ndarray, shape (B,)
    """
    return np.asarray(np.max([np.abs(v).max(axis=1) for v in vectors], axis=0), dtype=float)
