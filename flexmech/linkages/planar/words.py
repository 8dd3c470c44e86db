"""How messages on planar linkages tell where they cannot stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.types import FloatArray

Cause = Literal["apart", "locked"]
SAID: dict[Cause, str] = {
    "apart": "the linkage cannot be assembled at crank angle {angle}: {links} do not meet in joint "
    "{joint} there; choose crank angles inside its range of motion or other dimensions",
    "locked": "the linkage locks at crank angle {angle}: at joint {joint} {links} are in a dead "
    "point and the crank cannot drive them through; leave that crank angle out or change the "
    "dimensions",
}


def degrees(angle: float) -> str:
    """An angle in rad as text in degrees."""
    return f"{float(np.round(np.degrees(angle), 9)):g} deg"


@dataclass(frozen=True)
class Refusal:
    """Refuses crank angles at which a joint is apart or in a dead point.

    Parameters
    ----------
    joint : str
    links : str
        Those that meet there.
    drawn_at : float
        Crank angle in rad from which angles are counted.
    """

    joint: str
    links: str
    drawn_at: float

    def refuse(self, cause: Cause, where: NDArray[np.bool_], angle: FloatArray) -> None:
        """Refuse crank angles at which the joint cannot be put together or cannot be driven.

        Parameters
        ----------
        cause : {"apart", "locked"}
        where : ndarray of bool, shape (B,)
            Where that is so.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.

        Raises
        ------
        InputError
            Names the first of them.
        """
        if np.any(where):
            place = self.first(where, angle)
            raise InputError(SAID[cause].format(angle=place, links=self.links, joint=self.joint))

    def first(self, where: NDArray[np.bool_], angle: FloatArray) -> str:
        """First of the crank angles in a set, as text."""
        return degrees(float(self.drawn_at + np.broadcast_to(angle, where.shape)[where].flat[0]))
