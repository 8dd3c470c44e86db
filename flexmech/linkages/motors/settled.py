"""The settled motion under a motor, which repeats itself from turn to turn: found directly.

The crank angle is the independent variable: after a turn of it all other unknowns are as before.
That is a boundary value problem, solved by collocation of fourth order (Kierzenka & Shampine, "A
BVP solver based on residual control and the MATLAB PSE", *ACM Trans. Math. Softw.* 27, 2001).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.motors.drive_train import MotorOutput
from flexmech.linkages.motors.shaft_equation import ShaftEquation, TwistedShaft

# Angles turned through at which the motion is told.
_TURN: FloatArray = np.linspace(0.0, 2 * np.pi, 721)
# Of the residual between the nodes, relative: mean speeds are within 1e-9 of those by steps of
# 1e-11.
_TOLERANCE = 1e-7
# Work alone.
_MOST_NODES = 10_000
# Over the speed near which it is sought: a motor whose torque does not fall knows no bound.
_FAST = 1e3
# Of the speed from which it is sought.
_DOUBLINGS = 6


@dataclass(frozen=True, eq=False)
class SettledMotion:
    """A turn of the settled motion.

    Parameters
    ----------
    equation : ShaftEquation or TwistedShaft
        Whose solution it is.
    time : ndarray, shape (m,)
        In s, from zero.
    values : ndarray, shape (n, m)
        Crank angle, speed and the states of the drive train, at even crank angles.
    """

    equation: ShaftEquation | TwistedShaft
    time: FloatArray
    values: FloatArray

    @property
    def crank_angle(self) -> FloatArray:
        """In rad, over a turn, (m,)."""
        return np.asarray(self.values[0])

    @property
    def speed(self) -> FloatArray:
        """Of the crank in rad/s, (m,)."""
        return np.asarray(self.values[1])

    @cached_property
    def output(self) -> MotorOutput:
        """What the motor gives, arrays of shape (m,)."""
        return self.equation.train.motor_output(self.values[1], self.values[2:])

    @property
    def power(self) -> FloatArray:
        """Of the motor in W, (m,)."""
        train = self.equation.train
        turning = train.rotor_speed(self.values[1], self.values[2:])
        return self.output.torque * train.motor.gear_ratio * turning

    @property
    def mean_speed(self) -> float:
        """Of the crank in rad/s: a turn over its time."""
        turn = float(self.crank_angle[-1] - self.crank_angle[0])
        return turn / float(self.time[-1])

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation: greatest less least speed over the mean."""
        return speed_range(self.time, self.speed) / abs(self.mean_speed)

    @property
    def mean_power(self) -> float:
        """Of the motor in W."""
        from scipy.integrate import simpson

        return float(simpson(self.power, x=self.time)) / float(self.time[-1])


def speed_range(time: FloatArray, speed: FloatArray) -> float:
    """Greatest less least speed in rad/s, also between the samples.

    Parameters
    ----------
    time, speed : ndarray, shape (m,)
        In s, increasing, and in rad/s.

    Returns
    -------
    float
    """
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(time, speed)
    extremes = spline.derivative().roots(extrapolate=False)
    # Of a piece of constant speed SciPy gives its begin, and not a number for the rest of it.
    between = spline(extremes[np.isfinite(extremes)])
    return float(np.ptp(np.append(speed, between)))


def settled_motion(equation: ShaftEquation, near: FloatArray) -> SettledMotion | None:
    """The motion of a shaft that repeats itself from turn to turn.

    Parameters
    ----------
    equation : ShaftEquation
    near : ndarray, shape (n,)
        Values near it.

    Returns
    -------
    SettledMotion or None
        None where there is no such motion near, or loads go over time.
    """
    if equation.load.over_time:
        return None
    turn, bound = _Turn(equation, float(near[0]), float(np.sign(near[1]))), abs(_FAST * near[1])
    start = turn.unknowns(near)
    for _ in range(_DOUBLINGS):
        found = turn.repeated(start)
        if found is not None and np.abs(found[0]).max() <= bound:
            return SettledMotion(equation, found[-1], turn.values(turn.angles, found[:-1]))
        # Near a start from rest a slow turn would stand before it ends.
        start[0] *= 2.0
    return None


class _Turn:
    """A turn of the crank from an angle, with the other unknowns over it.

    These are the crank's speed, the twist of a coupling with its rotor's speed, and the states of
    the motor.
    """

    def __init__(self, equation: ShaftEquation, angle: float, way: float) -> None:
        self._equation, self._angle, self._way = equation, angle, way

    def unknowns(self, values: FloatArray) -> FloatArray:
        """The unknowns (n - 1,) of values (n,)."""
        own = values[1:].copy()
        if self._equation.train.is_coupled:
            own[1] -= values[0]
        return own

    def values(self, angle: FloatArray | float, own: FloatArray) -> FloatArray:
        """Values (n, ...) of unknowns (n - 1, ...) at crank angles (...)."""
        values = np.concatenate([np.broadcast_to(angle, own.shape[1:])[None], own])
        if self._equation.train.is_coupled:
            values[2] += angle
        return values

    def repeated(self, unknown: FloatArray) -> FloatArray | None:
        """Unknowns that end a turn as they began it, and the time, at the angles.

        Parameters
        ----------
        unknown : ndarray, shape (n - 1,)
            Near them.

        Returns
        -------
        ndarray, shape (n, m), or None
            None where there are none near: the crank stands, or at no speed does one turn end as
            it began.
        """
        from scipy.integrate import solve_bvp

        start = np.append(unknown, 0.0)[:, None] * np.ones(len(_TURN))
        start[-1] = _TURN / abs(unknown[0])
        with np.errstate(all="ignore"):
            found: Any = solve_bvp(
                self._rates,
                lambda first, last: np.append(last[:-1] - first[:-1], first[-1]),
                _TURN,
                start,
                tol=_TOLERANCE,
                max_nodes=_MOST_NODES,
            )
        if found.status or not np.all(self._way * found.y[0] > 0):
            return None
        return np.asarray(found.sol(_TURN))

    @property
    def angles(self) -> FloatArray:
        """Crank angles of the turn in rad, (m,)."""
        return np.asarray(self._angle + self._way * _TURN)

    def _rates(self, turned: FloatArray, own: FloatArray) -> FloatArray:
        """By the angle turned through (k,): of the unknowns (n - 1, k), and last of the time."""
        angle = self._angle + self._way * turned
        rates = self._equation.rates(0.0, self.values(angle, own[:-1]))
        if self._equation.train.is_coupled:
            rates[2] -= rates[0]
        by_time = np.concatenate([rates[1:], np.ones((1, own.shape[1]))])
        return np.asarray(self._way * by_time / own[0])
