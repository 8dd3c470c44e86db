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
    """What each check gives at every crank angle.

    Parameters
    ----------
    stresses : ndarray, shape (c, A)
        In Pa, or in Pa m/s.
    load_factors, speed_factors : ndarray, shape (c, A)
        Speed factors are not numbers where they do not follow.
    """

    stresses: FloatArray
    load_factors: FloatArray
    speed_factors: FloatArray

    @property
    def stress(self) -> FloatArray:
        """Greatest stress of each check, (c,)."""
        return np.asarray(self.stresses.max(axis=1))

    @property
    def worst(self) -> IntArray:
        """Number of the crank angle at which the stress of each check is greatest, (c,)."""
        return np.asarray(self.stresses.argmax(axis=1))

    @property
    def load_factor(self) -> FloatArray:
        """Least load factor of each check, (c,)."""
        return np.asarray(self.load_factors.min(axis=1))

    @property
    def speed_factor(self) -> FloatArray:
        """Least speed factor of each check, (c,)."""
        return np.asarray(self.speed_factors.min(axis=1))

    @property
    def fastest(self) -> IntArray:
        """Number of the crank angle at which the speed factor of each check is least, (c,)."""
        return np.asarray(self.speed_factors.argmin(axis=1))


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
    speed = np.full_like(stress, np.nan)
    for number, check in enumerate(checks):
        size, speed_of = _GROWTH.get(check.mode, (_length, speed_of_force))
        acting = _acting(check, loads, loads)
        stress[number] = check.stress * size(acting)
        if static is not None:
            still = _acting(check, static, loads)
            over = check.stress / check.allowable
            speed[number] = speed_of(over * still, over * (acting - still))
    allowable = np.array([check.allowable for check in checks])
    with np.errstate(divide="ignore"):
        return JudgedPins(stress, allowable[:, None] / stress, speed)


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
