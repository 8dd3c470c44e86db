"""Failures to find as many modes as are asked for; they tell how many there are."""

from __future__ import annotations

from typing import Any

from flexmech.errors import InputError
from flexmech.linear_system.position_errors import RefusedPositionsError


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
