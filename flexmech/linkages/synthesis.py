"""Synthesis of crank-rockers by their transmission angle, and its inverse.

Elamy et al. 2023, eqs. 11-17: the transmission angle deviates from 90 degrees by the same
angle either way (Gupta's mini-max), and the rocker's angle at the least transmission angle,
where the crank points along the ground, is chosen. L2, L3 and L4 are the lengths of crank,
coupler and rocker over that of the ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.fourbar import FourBar
from flexmech.model_text import short_repr
from flexmech.validation import checked_array

RIGHT_ANGLE = np.pi / 2


@dataclass(frozen=True)
class CrankRockerProportions:
    """Link lengths over the ground's.

    Parameters
    ----------
    deviation : ndarray, shape (...)
        Greatest deviation of the transmission angle from a right angle, in rad.
    rocker_angle : ndarray, shape (...)
        Angle of the rocker at crank angle zero, in rad.
    crank, coupler, rocker : ndarray, shape (...)
        Ratios L2, L3 and L4.
    """

    deviation: FloatArray
    rocker_angle: FloatArray
    crank: FloatArray
    coupler: FloatArray
    rocker: FloatArray

    def __repr__(self) -> str:
        ratios = {"crank": self.crank, "coupler": self.coupler, "rocker": self.rocker}
        if self.crank.size != 1:
            return short_repr(self, f"{self.crank.size} designs")
        return short_repr(self, *(f"{name} {float(x):.6g}" for name, x in ratios.items()))

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


@dataclass(frozen=True)
class TransmissionDesign:
    """Design data of a crank-rocker: deviation and rocker angle.

    Parameters
    ----------
    deviation : float
        Greatest deviation of the transmission angle from a right angle, in rad.
    rocker_angle : float
        Angle of the rocker against the ground at crank angle zero, in rad, between 0 and pi
        (on the crossed branch its negative).
    imbalance : float
        L3^2 + L4^2 - L2^2 - 1, the residual of eq. 11: zero where the limits of the
        transmission angle add up to pi. It is L3 L4 times the sum of their cosines.
    """

    deviation: float
    rocker_angle: float
    imbalance: float


def synthesize_crank_rocker(
    deviation: ArrayLike, rocker_angle: ArrayLike
) -> CrankRockerProportions:
    """Proportions whose transmission angle stays within 90 degrees plus or minus a deviation.

    Elamy et al. 2023, eqs. 14, 15 and 17. Every pair of angles inside the bounds gives one
    crank-rocker: L2 lies between 0 and 1, and the transmission angle reaches neither 0 nor
    180 degrees, so that the crank, which is shorter than the ground, turns fully.

    Parameters
    ----------
    deviation : array_like, shape (...)
        Between 0 and pi/2, in rad.
    rocker_angle : array_like, shape (...)
        Angle theta_4i of the rocker against the ground at crank angle zero, between the least
        transmission angle (pi/2 less the deviation) and pi, in rad; broadcast against
        ``deviation``.

    Returns
    -------
    CrankRockerProportions

    Raises
    ------
    InputError
        If an angle is out of its bounds, or so near to them that the linkage would be at a
        change point within round-off.

    Examples
    --------
    >>> design = flexmech.synthesize_crank_rocker(np.radians(30), np.radians(90))
    >>> linkage = design.linkage(ground=0.25)
    >>> np.degrees(linkage.transmission_angle_limits()).round(9)
    array([ 60., 120.])
    """
    delta, theta = (
        np.array(angle)
        for angle in np.broadcast_arrays(
            checked_array(deviation, "deviation", "rad"),
            checked_array(rocker_angle, "rocker_angle", "rad"),
        )
    )
    least = RIGHT_ANGLE - delta
    _refuse_deviation(delta)
    _refuse_rocker_angle(delta, theta, (theta > least) & (theta < np.pi))
    ratio_coupler = np.sin(theta) / np.sin(least)
    ratio_rocker = np.sin(theta - least) / np.sin(least)
    square = ratio_coupler**2 + ratio_rocker**2
    # (square - root) / (square - 1), written without the difference of nearly equal numbers.
    crank = (square - 1) / (square + np.sqrt(2 * square - 1))
    proportions = CrankRockerProportions(
        delta, theta, crank, ratio_coupler * (1 - crank), ratio_rocker * (1 - crank)
    )
    _refuse_change_points(proportions)
    return proportions


def transmission_design(linkage: FourBar) -> TransmissionDesign:
    """Deviation and rocker angle of a crank-rocker: the inverse of the synthesis.

    Elamy et al. 2023, eqs. 2, 3, 11 and the triangle of eq. 13. Where the linkage is balanced,
    :func:`synthesize_crank_rocker` gives its proportions back.

    Parameters
    ----------
    linkage : FourBar
        Balanced or not.

    Returns
    -------
    TransmissionDesign

    Raises
    ------
    InputError
        If the linkage is no crank-rocker.
    """
    _refuse_other_classes(linkage)
    crank, coupler, rocker = (
        length / linkage.ground for length in (linkage.crank, linkage.coupler, linkage.rocker)
    )
    least, greatest = linkage.transmission_angle_limits()
    cosine = (coupler**2 - rocker**2 - (1 - crank) ** 2) / (2 * rocker * (1 - crank))
    return TransmissionDesign(
        deviation=float(max(RIGHT_ANGLE - least, greatest - RIGHT_ANGLE)),
        rocker_angle=float(np.arccos(np.clip(cosine, -1.0, 1.0))),
        imbalance=coupler**2 + rocker**2 - crank**2 - 1,
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
    _refuse_other_classes(linkage)
    folded, stretched = _angles_in_line(linkage, linkage.rocker, _reach(linkage))
    return float(stretched - folded)


def time_ratio(linkage: FourBar) -> float:
    """Duration of the rocker's slower stroke over that of its faster one.

    At constant crank speed. One where the transmission angle is balanced: eq. 11 is also the
    condition of a unit time ratio.

    Parameters
    ----------
    linkage : FourBar

    Returns
    -------
    float
        At least 1.

    Raises
    ------
    InputError
        If the linkage is no crank-rocker.
    """
    _refuse_other_classes(linkage)
    reach = _reach(linkage)
    # In line, the crank points to B when stretched and away from it when folded.
    folded, stretched = _angles_in_line(linkage, reach, linkage.rocker)
    offset = abs(folded - stretched)
    return float((np.pi + offset) / (np.pi - offset))


def _reach(linkage: FourBar) -> FloatArray:
    """Distance from O2 to B with the coupler folded over the crank and stretched out; (2,)."""
    return linkage.coupler + np.array([-1.0, 1.0]) * linkage.crank


def _angles_in_line(
    linkage: FourBar, beside: float | FloatArray, opposite: float | FloatArray
) -> FloatArray:
    """Angle between the ground and a side in the triangle O2-B-O4, by the cosine rule; (2,)."""
    cosine = (linkage.ground**2 + beside**2 - opposite**2) / (2 * linkage.ground * beside)
    # Clipped: the triangles of links that hardly move are flat within round-off.
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _refuse_other_classes(linkage: FourBar) -> None:
    if linkage.grashof_class != "crank-rocker":
        raise InputError(
            f"the lengths must make a crank-rocker, got a {linkage.grashof_class}: make the crank "
            "the shortest link, and shortest and longest together shorter than the other two"
        )


def _refuse_deviation(delta: FloatArray) -> None:
    wrong = ~((delta > 0) & (delta < RIGHT_ANGLE))
    if np.any(wrong):
        got = delta[wrong].flat[0]
        remedy = f"; angles are in rad, give np.radians({got:g})" if got > np.pi else ""
        raise InputError(
            "deviation must lie between 0 and 90 deg (both excluded), got "
            f"{_degrees(got)} deg{remedy}"
        )


def _refuse_rocker_angle(delta: FloatArray, theta: FloatArray, inside: NDArray[np.bool_]) -> None:
    if np.all(inside):
        return
    deviation, got = delta[~inside].flat[0], theta[~inside].flat[0]
    remedy = ""
    if got >= np.pi:
        remedy = "; at 180 deg nothing is left of the coupler: choose a smaller one"
    elif got <= RIGHT_ANGLE - deviation:
        remedy = "; it must exceed the least transmission angle: raise it"
        if got > 0:
            remedy += f" or choose a deviation above {_degrees(RIGHT_ANGLE - got)} deg"
    raise InputError(
        f"rocker angle must lie between {_degrees(RIGHT_ANGLE - deviation)} and 180 deg (both "
        f"excluded) at a deviation of {_degrees(deviation)} deg, got {_degrees(got)} deg{remedy}"
    )


def _refuse_change_points(proportions: CrankRockerProportions) -> None:
    """Refuse proportions too near a change point by Grashof's criterion."""
    crank, coupler, rocker = proportions.crank, proportions.coupler, proportions.rocker
    ratios = np.stack([np.ones_like(crank), crank, coupler, rocker])
    shortest, second, third, longest = np.sort(ratios, axis=0)
    # Twice: the criterion is asked again with the round-off of lengths in m.
    enough = 2 * SAME_PLACE * ratios.sum(axis=0)
    wrong = ~(second + third - shortest - longest > enough)
    if np.any(wrong):
        delta, theta = proportions.deviation[wrong].flat[0], proportions.rocker_angle[wrong].flat[0]
        raise InputError(
            f"deviation of {_degrees(delta)} deg and rocker angle of {_degrees(theta)} deg are "
            "at a bound within round-off, where the linkage meets a change point; rocker angles "
            f"between {_degrees(RIGHT_ANGLE - delta)} and 180 deg (both excluded) work, and "
            "deviations between 0 and 90 deg: move away from the bound"
        )


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.12g}"
