"""Angles of links that are counted on as the crank turns, for springs in joints and tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.positions import standing
from flexmech.types import FloatArray

# Of a turn, at which angles are followed; no link may turn by half a turn from one to the next.
STEPS = 720
TURN = 2 * np.pi


def continuous_angles(linkage: Linkage, motion: RigidMotion) -> FloatArray:
    """Angles of the links without jumps of whole turns.

    A linkage gives each angle within one turn. Here every angle is followed from crank angle
    zero, where it keeps its value, and it counts on with every further turn of the crank. Of a
    crank that does not turn fully, each range of crank angles is followed on its own, the one
    around zero from there and any other from its start; a whole turn more is the same posture.

    Parameters
    ----------
    linkage : Linkage
    motion : RigidMotion
        Of the linkage.

    Returns
    -------
    ndarray, shape (..., n_links)
        In rad; ``motion.angle`` but for whole turns.
    """
    step = TURN / STEPS
    around = np.asarray(step * np.arange(STEPS + 1), dtype=float)
    stands = standing(linkage, around)
    turns, places = np.divmod(np.rint(motion.crank_angle / step).astype(int), STEPS)
    if np.all(stands):
        followed = np.unwrap(linkage.motion(around).angle, axis=0)
        gained = TURN * np.round((followed[-1] - followed[0]) / TURN)
        near = followed[places] + turns[..., None] * gained
    else:
        near = _in_ranges(linkage, around[:-1], stands[:-1], motion.angle.shape[-1])[places]
        # A range too narrow to be met by a step is its own.
        near = np.where(np.isnan(near), motion.angle, near)
    counted: FloatArray = motion.angle + TURN * np.round((near - motion.angle) / TURN)
    return counted


def _in_ranges(
    linkage: Linkage, around: FloatArray, stands: NDArray[np.bool_], links: int
) -> FloatArray:
    """Angles over a turn, followed in each range that stands; not a number elsewhere."""
    followed = np.full((len(around), links), np.nan)
    # Begun where the linkage does not stand, no range runs over the end.
    order = np.roll(np.arange(len(around)), -int(np.argmin(stands)))
    edges = np.flatnonzero(np.diff(stands[order].astype(int))) + 1
    for part in np.split(order, edges):
        if stands[part[0]]:
            angles = np.unwrap(linkage.motion(around[part]).angle, axis=0)
            if 0 in part:
                kept = linkage.motion(0.0).angle
                angles = angles + TURN * np.round((kept - angles[part == 0][0]) / TURN)
            followed[part] = angles
    # Between the last step of a range and its end.
    for shift in (1, -1):
        beside = np.roll(followed, shift, axis=0)
        followed = np.where(np.isnan(followed) & ~np.isnan(beside), beside, followed)
    return followed
