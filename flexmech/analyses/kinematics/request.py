"""What is asked of the kinematics of a linkage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from flexmech.analyses.requests import in_radians
from flexmech.errors import InputError
from flexmech.mechanism import Mechanism
from flexmech.numbers import check_count, check_number, checked_tuple
from flexmech.types import FloatArray

MOST_LUMPS = 1000
"""Elements of a link whose mass is lumped."""


@dataclass(frozen=True)
class KinematicsRequest:
    """Crank angles and speed, and how masses are lumped for a comparison.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        In rad, increasing; a turn in steps of one degree if left out.
    crank_speed : float, optional
        In rad/s; may be zero or negative. Left out: the first speed at which the mechanism
        operates, zero if it names none.
    lumped : sequence of int, optional
        For each link in order the number of elements whose mass is halved onto their ends, or
        one number for all; Kumar & Chandrakar's Figure 1.5 has (1, 4, 4).
    speed_unit : str
        In which crank speeds are printed and drawn.

    Raises
    ------
    InputError
        If angles or speed are no numbers, angles do not increase, or a number of elements is
        below one or beyond 1000.

    Examples
    --------
    >>> flexmech.KinematicsRequest(crank_speed=20.0, lumped=(1, 4, 4)).crank_angles.shape
    (361,)
    """

    crank_angles: FloatArray = field(default_factory=lambda: np.radians(np.arange(361.0)))
    crank_speed: float | None = None
    lumped: Sequence[int] | None = None
    speed_unit: str = "rad/s"

    def __post_init__(self) -> None:
        angles = in_radians("crank_angles", self.crank_angles)
        if angles.ndim != 1 or not angles.size or np.any(np.diff(angles) <= 0):
            raise InputError(
                f"crank_angles must be one or more in increasing order, got shape {angles.shape}"
            )
        object.__setattr__(self, "crank_angles", angles)
        if self.crank_speed is not None:
            check_number(self.crank_speed, "crank_speed", "rad/s")
        if self.lumped is not None:
            remedy = "give the elements of each link, as (1, 4, 4)"
            counts = checked_tuple(self.lumped, object, "lumped", remedy)
            for count in counts:
                check_count(count, "lumped: each number of elements")
                if count > MOST_LUMPS:
                    raise InputError(
                        f"lumped: {count} elements of a link are beyond {MOST_LUMPS}; the "
                        "distributed mass is what they tend to"
                    )
            object.__setattr__(self, "lumped", counts)

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: the one asked for, or the first at which a mechanism operates."""
        if self.crank_speed is not None:
            return float(self.crank_speed)
        return float(mechanism.operating_speeds[0]) if mechanism.operating_speeds else 0.0

    def lumped_of(self, mechanism: Mechanism) -> tuple[int, ...] | None:
        """Number of elements of each link of a mechanism; None where masses stay distributed.

        Parameters
        ----------
        mechanism : Mechanism

        Returns
        -------
        tuple of int or None

        Raises
        ------
        InputError
            If there are not as many numbers as links.
        """
        links = mechanism.linkage.topology.link_names
        if self.lumped is None:
            return None
        if len(self.lumped) == 1:
            return tuple(self.lumped) * len(links)
        if len(self.lumped) != len(links):
            raise InputError(
                f"lumped: {len(self.lumped)} numbers of elements for {len(links)} links; give one "
                f"for all, or one for each of {', '.join(links)}"
            )
        return tuple(self.lumped)
