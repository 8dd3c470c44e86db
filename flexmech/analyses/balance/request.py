"""What can be asked of counterweights: for what they balance, where they are, at which speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from flexmech.analyses.aspects.shaking import checked_point
from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.requests import check_list, in_radians
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.frame_forces import OneCouplerLinkage
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_flag,
    check_number,
    checked_tuple,
)

WEIGHED = ("shaking force", "shaking moment", "driving torque")
"""What a compromise weighs against each other, in the order of its weights."""

# Part of a slider-crank's reciprocating mass that is usually balanced: the peak of the rest along
# the line and of what it brings across it are then alike.
_HALF = 0.5


@dataclass(frozen=True)
class BalanceRequest:
    """What counterweights shall do, and where they may be.

    Parameters
    ----------
    crank_speed : float, optional
        In ``speed_unit``, other than zero. Left out: the greatest speed at which the mechanism
        operates.
    weights : sequence of float, optional
        Of shaking force, shaking moment and driving torque in a compromise: the sum of their
        mean squares over the crank angles, each over that of the linkage as given, is made least.
        Left out: the shaking force of a four-bar is balanced fully, and of a slider-crank the
        ``share``.
    radii : float or sequence of float, optional
        Distance in m of the counterweights from the point about which their link rotates; one for
        all, or of the crank and of the follower. Left out: half of the link's length.
    share : float
        Of a slider-crank without weights: part of the reciprocating mass that the counterweight
        balances, as if it rotated with the crank's pin.
    crank_angles : array_like, shape (A,)
        In rad, increasing: over which means and peaks are taken; a turn in steps of one degree if
        left out.
    speed_unit : str, optional
        Unit of the crank speed, such as ``"rpm"``, in which it is printed and drawn. Left out:
        rad/s, and the unit of the model file for the mechanism's speed.
    moment_point : tuple of float, optional
        About which the shaking moment is taken, in ground axes in m; the shaft's axis if left out.
    elastic : bool
        Whether to run the elastic linkage by the reference engine, for what is left of its
        shaking force, and to compute its first natural frequency.

    Raises
    ------
    InputError
        If a number is out of its range, or no weight is positive.

    Examples
    --------
    >>> flexmech.BalanceRequest(300.0, weights=(1, 0.5, 0.5), speed_unit="rpm").weights
    (1.0, 0.5, 0.5)
    """

    crank_speed: float | None = None
    weights: Sequence[float] | None = None
    radii: float | Sequence[float] | None = None
    share: float = _HALF
    crank_angles: FloatArray = field(default_factory=lambda: np.radians(np.arange(361.0)))
    speed_unit: str | None = None
    moment_point: tuple[float, float] | None = None
    elastic: bool = True

    def __post_init__(self) -> None:
        angles = in_radians("crank_angles", self.crank_angles)
        check_list("crank_angles", angles, increasing=True)
        object.__setattr__(self, "crank_angles", angles)
        if self.crank_speed is not None and not one_rad_per_s(self.crank_speed, self.speed_unit):
            raise InputError("crank_speed: 0, at which nothing shakes; give another one")
        check_number(self.share, "share", "", NOT_NEGATIVE)
        if self.share > 1:
            raise InputError(f"share: must be 0 to 1, got {self.share:g}")
        check_flag(self.elastic, "elastic")
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        if self.weights is not None:
            object.__setattr__(self, "weights", _checked_weights(self.weights))
        if self.radii is not None:
            remedy = "give one for all, or those of crank and follower"
            given = [self.radii] if isinstance(self.radii, int | float) else self.radii
            radii = checked_tuple(given, object, "radii", remedy)
            for radius in radii:
                check_number(radius, "radii: each radius", "m", POSITIVE)
            object.__setattr__(self, "radii", tuple(np.array(radii, dtype=float).tolist()))

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: as asked for, or the greatest at which a mechanism operates."""
        if self.crank_speed is not None:
            return one_rad_per_s(self.crank_speed, self.speed_unit)
        greatest = float(max(mechanism.operating_speeds, key=abs, default=0.0))
        if not greatest:
            raise InputError(
                "crank_speed: is left out, and the model names none at which it turns; give one"
            )
        return greatest

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        own = mechanism.speed_unit if self.crank_speed is None else RAD_S
        return self.speed_unit or own

    def radii_of(self, linkage: OneCouplerLinkage) -> tuple[float, ...]:
        """Radius of the counterweight of each turning link of a linkage, in m.

        Parameters
        ----------
        linkage : OneCouplerLinkage

        Returns
        -------
        tuple of float

        Raises
        ------
        InputError
            If there are not as many radii as links.
        """
        links = linkage.turning
        if self.radii is None:
            return tuple(abs(link.arm) / 2 for link in links)
        radii = tuple(np.atleast_1d(self.radii).tolist())
        if len(radii) not in (1, len(links)):
            names = ", ".join(link.name for link in links)
            raise InputError(
                f"radii: got {len(radii)}, and {len(links)} can carry a counterweight ({names}); "
                "give one for all, or one for each of them"
            )
        return radii * len(links) if len(radii) == 1 else radii


def _checked_weights(weights: Sequence[float]) -> tuple[float, ...]:
    remedy = f"give those of {', '.join(WEIGHED)}"
    found = checked_tuple(weights, object, "weights", remedy)
    for weight in found:
        check_number(weight, "weights: each weight", "", NOT_NEGATIVE)
    numbers = tuple(np.array(found, dtype=float).tolist())
    if len(numbers) != len(WEIGHED) or not any(numbers):
        raise InputError(
            f"weights: must be {len(WEIGHED)} numbers, of {', '.join(WEIGHED)}, one of them "
            f"positive; got {numbers}"
        )
    return numbers
