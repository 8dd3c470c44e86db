"""Pins judged: their stresses over the turn, load and speed factors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.joint_loads import JointLoads
from flexmech.analyses.strength.pin_checks import TEARING, PinCheck, PinMode
from flexmech.analyses.strength.pin_speeds import (
    speed_of_force,
    speed_of_pull,
    speed_of_wear,
    tearing_force,
)
from flexmech.arrays import FloatArray, IntArray

Size = Callable[[FloatArray], FloatArray]
SpeedOf = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class JudgedPins:
    """What is found by each check, at its worst crank angle.

    Parameters
    ----------
    stress : ndarray, shape (c,)
        In Pa, or in Pa m/s.
    mean : ndarray, shape (c,)
        Over the crank angles.
    load_factor, speed_factor : ndarray, shape (c,)
        Speed factors over all crank angles; not numbers where they do not follow.
    worst : ndarray of int, shape (c,)
        Number of the crank angle at which the stress is greatest.
    fastest : ndarray of int, shape (c,)
        Number of the crank angle at which the speed factor is least.
    """

    stress: FloatArray
    mean: FloatArray
    load_factor: FloatArray
    speed_factor: FloatArray
    worst: IntArray
    fastest: IntArray


def judge_pins(
    checks: Sequence[PinCheck], loads: JointLoads, static: JointLoads | None
) -> JudgedPins:
    """Judge pins over the turn.

    Parameters
    ----------
    checks : sequence of PinCheck
    loads : JointLoads
        At A crank angles.
    static : JointLoads or None
        Forces that do not grow with the square of the speed, in the same positions; None where the
        rest does not either, and no speed factor follows.

    Returns
    -------
    JudgedPins
    """
    stress = np.zeros((len(checks), len(loads.force)))
    speed, fastest = np.full(len(checks), np.nan), np.zeros(len(checks), dtype=np.intp)
    for number, check in enumerate(checks):
        size, speed_of = _GROWTH.get(check.mode, (_length, speed_of_force))
        acting = _acting(check, loads, loads)
        stress[number] = check.stress * size(acting)
        if static is not None:
            still = _acting(check, static, loads)
            over = check.stress / check.allowable
            over_turn = speed_of(over * still, over * (acting - still))
            speed[number], fastest[number] = over_turn.min(), over_turn.argmin()
    allowable = np.array([check.allowable for check in checks])
    worst = stress.argmax(axis=1)
    greatest = np.take_along_axis(stress, worst[:, None], axis=1)[:, 0]
    with np.errstate(divide="ignore"):
        factor = allowable / greatest
    return JudgedPins(greatest, stress.mean(axis=1), factor, speed, worst, fastest)


def _acting(check: PinCheck, loads: JointLoads, running: JointLoads) -> FloatArray:
    """Force that a check counts, (A, 2); of a bush times the rate at which it runs."""
    if check.end is None:
        return loads.vector(check.joint) * running.turning(check.joint)[:, None]
    return loads.on_eye(check.end)


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))


# How large what a check counts is, and at which speed it reaches its bound.
_GROWTH: dict[PinMode, tuple[Size, SpeedOf]] = {
    **dict.fromkeys(TEARING, (tearing_force, speed_of_pull)),
    "p v": (_length, speed_of_wear),
}
