"""Angles of links that are counted on as the crank turns, for springs in joints."""

from __future__ import annotations

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.positions import shown_crank_angle, standing
from flexmech.types import FloatArray

__all__ = ["continuous_angles"]

# Of crank angles between which angles are followed; no link may turn by half a turn there.
STEPS = 720


def continuous_angles(linkage: Linkage, motion: RigidMotion) -> FloatArray:
    """Angles of the links without jumps of whole turns.

    A linkage gives each angle within one turn. Here every angle is followed from crank angle
    zero (or from the crank angle at which pictures show a linkage that cannot stand there),
    where it keeps its value, and it counts on with every further turn of the crank.

    Parameters
    ----------
    linkage : Linkage
    motion : RigidMotion
        Of the linkage.

    Returns
    -------
    ndarray, shape (..., n_links)
        In rad; ``motion.angle`` but for whole turns.

    Raises
    ------
    InputError
        If a crank angle cannot be reached from there.
    """
    turn = 2 * np.pi
    crank = motion.crank_angle
    from_zero = bool(standing(linkage, np.zeros(1))[0])
    first = 0.0 if from_zero else shown_crank_angle(linkage)
    stands = standing(linkage, first + np.linspace(0.0, turn, STEPS + 1))
    if np.all(stands):
        steps, base = np.arange(STEPS + 1), 0
        turns = np.floor((crank - first) / turn)
    else:
        # Both ways as far as the linkage stands; a further turn is the same posture again.
        ahead, base = int(np.argmin(stands)), int(np.argmin(stands[::-1])) - 1
        steps = np.arange(-base, ahead)
        turns = np.round((crank - first - turn * steps.mean() / STEPS) / turn)
    around = first + steps * turn / STEPS
    followed = np.unwrap(linkage.motion(around).angle, axis=0)
    followed = followed + turn * np.round((linkage.motion(first).angle - followed[base]) / turn)
    wanted = crank - turn * turns
    step = turn / STEPS
    if np.any((wanted < around[0] - step) | (wanted > around[-1] + step)):
        raise InputError(
            "springs in joints need crank angles that the linkage reaches without leaving its "
            f"range of motion about {np.degrees(first):.6g} deg; choose crank angles inside it"
        )
    near = np.stack([np.interp(wanted, around, column) for column in followed.T], axis=-1)
    if np.all(stands):
        gained = turn * np.round((followed[-1] - followed[0]) / turn)
        near = near + turns[..., None] * gained
    counted: FloatArray = motion.angle + turn * np.round((near - motion.angle) / turn)
    return counted
