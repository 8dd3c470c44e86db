"""Failures that name the position of the linkage at which they happen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.linkages import RigidMotion

__all__ = ["refuse_positions"]


def refuse_positions(
    motion: RigidMotion, refused: NDArray[np.bool_], what: str, advice: str
) -> None:
    """Refuse a batch if some of its positions fail, and name the first of them.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,).
    refused : ndarray of bool, shape (B,)
    what : str
        What fails; crank angle and crank speed follow.
    advice : str
        What stands after them: the reason and the remedy.

    Raises
    ------
    ComputationError
        If a position is refused.
    """
    if not refused.any():
        return
    first = int(np.argmax(refused))
    angle = np.degrees(motion.crank_angle[first])
    raise ComputationError(
        f"{what} at crank angle {angle:.6g} deg and crank speed {CRANK_SPEED}{advice}",
        crank_speed=float(motion.crank_speed[first]),
    )
