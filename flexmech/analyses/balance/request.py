"""Request of counterweights: their purpose, their places and the speed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.analyses.aspects.shaking import checked_point
from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.options import BalanceOptions
from flexmech.analyses.requests import check_list, in_radians
from flexmech.errors import InputError
from flexmech.linkages.frame_forces import OneCouplerLinkage
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_number,
    checked_tuple,
)

WEIGHED = ("shaking force", "shaking moment", "driving torque")
"""Quantities that a compromise weighs, in the order of its weights."""

EQUAL = (1.0, 1.0, 1.0)
"""Weights of the compromise for a four-bar, if none are asked for."""


class BalanceRequest(BalanceOptions):
    """Checked request of counterweights: their purpose and their places.

    Parameters as for :class:`flexmech.analyses.options.BalanceOptions`.

    Raises
    ------
    InputError
        If a number is out of its range, or no weight is positive.

    Examples
    --------
    >>> BalanceRequest(300.0, weights=(1, 0.5, 0.5), speed_unit="rpm").weights
    (1.0, 0.5, 0.5)
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        angles = in_radians("crank_angles", self.crank_angles)
        check_list("crank_angles", angles, increasing=True)
        object.__setattr__(self, "crank_angles", angles)
        if self.speed is not None and not one_rad_per_s(self.speed, self.speed_unit, "speed"):
            raise InputError("speed: 0, at which nothing shakes; give another one")
        check_number(self.share, "share", "", NOT_NEGATIVE)
        if self.share > 1:
            raise InputError(f"share: must be 0 to 1, got {self.share:g}")
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        if self.full and self.weights is not None:
            raise InputError("full: weights ask for a compromise; give one of both")
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
        if self.speed is not None:
            return one_rad_per_s(self.speed, self.speed_unit, "speed")
        greatest = float(max(mechanism.operating_speeds, key=abs, default=0.0))
        if not greatest:
            raise InputError(
                "speed: is left out, and the model names none at which it turns; give one"
            )
        return greatest

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        own = mechanism.speed_unit if self.speed is None else RAD_S
        return self.speed_unit or own

    def weights_of(self, linkage: OneCouplerLinkage) -> tuple[float, ...] | None:
        """Weights of the compromise for a linkage; None for a balance of force alone.

        Parameters
        ----------
        linkage : OneCouplerLinkage

        Returns
        -------
        tuple of float or None

        Raises
        ------
        InputError
            If the full balance of a slider-crank is asked for.
        """
        if linkage.follower is None:
            if self.full:
                raise InputError(
                    "full: a slider-crank's counterweight balances a share of its reciprocating "
                    "mass; give that, as in share 1"
                )
            return None if self.weights is None else tuple(self.weights)
        if self.full:
            return None
        return EQUAL if self.weights is None else tuple(self.weights)

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
