"""Failures that name the position of the linkage at which they happen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.linkages import RigidMotion

LESS_LOADED = "{less_loaded}"
"""Placeholder of an advice for the loads to lower: crank speed and loads at rest, or these alone.

No crank speed is low enough for a linkage that its weight bends too far.
"""
ACTS_AT_REST = "the loads at rest (gravity, forces, springs, heat or water)"
RUNNING = f"lower the crank speed or {ACTS_AT_REST}"
AT_REST = f"lower {ACTS_AT_REST}"


class RefusedPositionsError(ComputationError):
    """Failure at some positions of a batch, with all of them that are known to fail.

    Parameters
    ----------
    message : str
        Names the first of them.
    crank_speed : float, optional
        Crank speed of the first, in rad/s.
    crank_angles, crank_speeds : ndarray, shape (n,), optional
        Crank angles in rad and crank speeds in rad/s of all positions without equilibrium.
    """

    def __init__(
        self,
        message: str,
        *,
        crank_speed: float | None = None,
        crank_angles: FloatArray | None = None,
        crank_speeds: FloatArray | None = None,
    ) -> None:
        super().__init__(message, crank_speed=crank_speed)
        none = np.empty(0)
        self.crank_angles = none if crank_angles is None else crank_angles
        self.crank_speeds = none if crank_speeds is None else crank_speeds


class BucklingError(RefusedPositionsError):
    """The equilibrium is statically unstable."""


class EquilibriumError(RefusedPositionsError):
    """No equilibrium is found."""


def refuse_positions(
    motion: RigidMotion,
    refused: NDArray[np.bool_],
    what: str,
    advice: str,
    error: Callable[..., RefusedPositionsError] = RefusedPositionsError,
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
        What stands after them: the reason and the remedy, in which :data:`LESS_LOADED` stands
        for what helps at that crank speed.
    error : callable
        Makes the error of its message and of the positions.

    Raises
    ------
    RefusedPositionsError
        If a position is refused.
    """
    if not refused.any():
        return
    first = int(np.argmax(refused))
    angle = np.degrees(motion.crank_angle[first])
    speed = float(motion.crank_speed[first])
    remedy = advice.replace(LESS_LOADED, RUNNING if speed else AT_REST)
    raise error(
        f"{what} at crank angle {angle:.6g} deg and crank speed {CRANK_SPEED}{remedy}",
        crank_speed=speed,
        crank_angles=motion.crank_angle[refused],
        crank_speeds=motion.crank_speed[refused],
    )


class OverdampedError(RefusedPositionsError):
    """Damping keeps modes that are asked for from oscillating.

    It takes the further keywords of :class:`RefusedPositionsError`.

    Parameters
    ----------
    message : str
    most_modes : int
        How many of the lowest modes oscillate in all positions of the batch.

    """

    def __init__(self, message: str, *, most_modes: int = 0, **positions: Any) -> None:
        super().__init__(message, **positions)
        self.most_modes = most_modes


class TooManyModesError(InputError):
    """A model has fewer modes than are asked for.

    Parameters
    ----------
    message : str
    most_modes : int
        How many it has.
    crank_speed : float, optional
        In rad/s.
    """

    def __init__(
        self, message: str, *, most_modes: int = 0, crank_speed: float | None = None
    ) -> None:
        super().__init__(message, crank_speed=crank_speed)
        self.most_modes = most_modes
