"""Whether an equilibrium is the loaded posture of the linkage or another one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.errors import ComputationError
from flexmech.linear_system.link_model import LinkModel
from flexmech.linkages import RigidMotion, Topology
from flexmech.types import FloatArray

__all__ = ["refuse_other_postures"]


# A link displaced by more than this part of its length has left the posture whose
# vibrations are asked for; Newton's method may then have found any other equilibrium.
FARTHEST = 0.5


def refuse_other_postures(
    topology: Topology,
    links: Sequence[LinkModel],
    motion: RigidMotion,
    displacements: Sequence[FloatArray],
) -> None:
    """Refuse an equilibrium far from the rigid linkage's posture.

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
        if np.any(farthest > FARTHEST):
            first = int(np.flatnonzero(farthest > FARTHEST)[0])
            raise ComputationError(
                f"the {link.name} is displaced by {100 * farthest[first]:.3g} % of its length at "
                f"crank angle {np.degrees(motion.crank_angle[first]):.6g} deg and crank speed "
                f"{motion.crank_speed[first]:.6g} rad/s: that equilibrium is no vibration about "
                "the rigid posture; lower the crank speed or stiffen the links"
            )
