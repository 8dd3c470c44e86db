"""Link proportions of crank-rockers from the transmission angle that is wanted.

Elamy et al. 2023, eqs. 11-17: the transmission angle deviates from 90 degrees by the same
angle either way (Gupta's mini-max), and the rocker's angle at the least transmission angle,
where the crank points along the ground, is chosen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.errors import InputError
from flexmech.linkages.fourbar import FourBar

__all__ = ["CrankRockerProportions", "rocker_swing", "synthesize_crank_rocker"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class CrankRockerProportions:
    """Link lengths over the ground's.

    Parameters
    ----------
    deviation : ndarray
        Greatest deviation of the transmission angle from a right angle, in rad.
    rocker_angle : ndarray
        Angle of the rocker at crank angle zero, in rad.
    crank, coupler, rocker : ndarray
        Ratios L2, L3 and L4, all arrays of one shape.
    """

    deviation: FloatArray
    rocker_angle: FloatArray
    crank: FloatArray
    coupler: FloatArray
    rocker: FloatArray

    def linkage(self, ground: float = 1.0) -> FourBar:
        """Linkage of the proportions; of one design only.

        Parameters
        ----------
        ground : float
            Distance of the ground pivots in m.

        Returns
        -------
        FourBar
            On the open branch.

        Raises
        ------
        InputError
            If these are several designs or the length is not positive.
        """
        if self.crank.size != 1:
            raise InputError(
                f"a linkage is made of one design, these are {self.crank.size}; choose one"
            )
        crank, coupler, rocker = (
            ground * float(np.squeeze(v)) for v in (self.crank, self.coupler, self.rocker)
        )
        return FourBar(ground, crank, coupler, rocker)


def synthesize_crank_rocker(
    deviation: ArrayLike, rocker_angle: ArrayLike
) -> CrankRockerProportions:
    """Proportions whose transmission angle stays within 90 degrees plus or minus a deviation.

    Elamy et al. 2023, eqs. 14, 15 and 17. Every pair of angles within the bounds gives one
    crank-rocker.

    Parameters
    ----------
    deviation : array_like
        Between 0 and pi/2, in rad.
    rocker_angle : array_like
        Angle theta_4i of the rocker against the ground at crank angle zero, between the least
        transmission angle (pi/2 less the deviation) and pi, in rad; broadcast against
        ``deviation``.

    Returns
    -------
    CrankRockerProportions

    Raises
    ------
    InputError
        If an angle is out of its bounds.
    """
    delta, theta = (np.array(v, dtype=float) for v in np.broadcast_arrays(deviation, rocker_angle))
    _refuse(delta, (delta > 0) & (delta < np.pi / 2), "deviation", 0.0, 90.0)
    least = np.pi / 2 - delta
    low = float(np.degrees(least.max()))
    _refuse(theta, (theta > least) & (theta < np.pi), "rocker angle", low, 180.0)
    ratio_coupler = np.sin(theta) / np.sin(least)
    ratio_rocker = np.sin(theta - least) / np.sin(least)
    square = ratio_coupler**2 + ratio_rocker**2
    # (square - root) / (square - 1), written without the difference of nearly equal numbers.
    crank = (square - 1) / (square + np.sqrt(2 * square - 1))
    return CrankRockerProportions(
        delta, theta, crank, ratio_coupler * (1 - crank), ratio_rocker * (1 - crank)
    )


def rocker_swing(linkage: FourBar) -> float:
    """Angle through which the rocker of a crank-rocker swings, in rad.

    Between the positions where crank and coupler are in line.

    Parameters
    ----------
    linkage : FourBar

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the linkage is no crank-rocker.
    """
    if linkage.grashof_class != "crank-rocker":
        raise InputError(
            f"a swing has the rocker of a crank-rocker; this linkage is a {linkage.grashof_class}"
        )
    reach = linkage.coupler + np.array([-1.0, 1.0]) * linkage.crank
    cosine = (linkage.ground**2 + linkage.rocker**2 - reach**2) / (
        2 * linkage.ground * linkage.rocker
    )
    folded, stretched = np.arccos(cosine)
    return float(stretched - folded)


def _refuse(
    angle: FloatArray, allowed: NDArray[np.bool_], what: str, low: float, high: float
) -> None:
    if not np.all(allowed):
        got = float(np.degrees(np.asarray(angle)[~allowed].flat[0]))
        why = "; the least transmission angle bounds it" if what == "rocker angle" else ""
        raise InputError(
            f"{what} must lie between {low:.6g} and {high:.6g} deg, got {got:.6g} deg{why}"
        )
