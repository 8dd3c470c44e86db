"""The settled motion under a motor, which repeats itself from turn to turn: found directly.

The crank angle is the independent variable: after a turn of it all other unknowns are as before
(shooting; Nayfeh & Balachandran, *Applied Nonlinear Dynamics*, 1995, sect. 5.2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.linkages.motors.drive_train import DriveTrain
from flexmech.linkages.motors.shaft_equation import ShaftEquation
from flexmech.linkages.motors.speed_control import MotorOutput

# Angles of a turn at which the motion is told.
_ANGLES = 721
_TOLERANCE = 1e-11
# Over the speed near which it is sought: a motor whose torque does not fall knows no bound.
_FAST = 1e3
# Newton's method by differences gains some five digits a pass, once it is near.
_PASSES, _DIFFERENCE, _CONVERGED = 40, 1e-6, 1e-9


class TurningShaft(Protocol):
    """A shaft whose crank angle and speed, and the states of its drive train, are unknown."""

    @property
    def train(self) -> DriveTrain:
        """What turns it."""

    def rates(self, time: ArrayLike, values: FloatArray) -> FloatArray:
        """Time derivatives of the values, (n, ...) at times (...)."""


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

    equation: TurningShaft
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
        return self.output.torque * train.driven_by.motor.gear_ratio * turning

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
    between = spline(spline.derivative().roots(extrapolate=False))
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
    turn = _Turn(equation, float(near[0]), float(np.sign(near[1])))
    unknown = turn.unknowns(near)
    scale = np.maximum(np.abs(unknown), 1e-3 * abs(float(near[1])))
    for _ in range(_PASSES):
        # The turn, and beside it one for each unknown that begins a little farther.
        beside = np.column_stack([np.zeros_like(scale), np.diag(_DIFFERENCE * scale)])
        ends = turn.ends(unknown[:, None] + beside)
        if ends is None:
            return None
        gap = ends[:, 0] - unknown
        if np.all(np.abs(gap) <= _CONVERGED * scale):
            return turn.motion(unknown)
        slope = (ends[:, 1:] - ends[:, :1]) / (_DIFFERENCE * scale) - np.eye(len(unknown))
        try:
            change = np.linalg.solve(slope, -gap)
        except np.linalg.LinAlgError:
            # Neutral: no turn differs from the next at any speed, or all do alike.
            return None
        # At a far lower speed the slope is another one: no farther than to its double at once.
        way = abs(change[0]) / abs(unknown[0])
        unknown = unknown + change / max(1.0, way)
        if abs(unknown[0]) > _FAST * abs(float(near[1])):
            return None
    return None


class _Turn:
    """A turn of the crank from an angle, as a map of the other unknowns.

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

    def _rates(self, angle: float, own: FloatArray) -> FloatArray:
        """By the crank angle: of the unknowns (n - 1, k), and of the time, which comes last."""
        rates = self._equation.rates(0.0, self.values(angle, own[:-1]))
        rates = rates.copy()
        if self._equation.train.is_coupled:
            rates[2] -= rates[0]
        speed = np.where(self._way * own[0] > 0, own[0], np.nan)
        return np.concatenate([rates[1:], np.ones((1, own.shape[1]))]) / speed

    def _solved(self, unknowns: FloatArray, angles: FloatArray | None) -> FloatArray | None:
        """Unknowns (n - 1, k) of turns beside each other, and the time, at angles; (n, k, m)."""
        from scipy.integrate import solve_ivp

        start = np.concatenate([unknowns, np.zeros((1, unknowns.shape[1]))])
        floor = np.maximum(np.abs(start), 1e-6)
        floor[-1] = 1e-3
        with np.errstate(invalid="ignore", divide="ignore"):
            found = solve_ivp(
                lambda angle, own: self._rates(angle, own.reshape(start.shape)).ravel(),
                (self._angle, self._angle + self._way * 2 * np.pi),
                start.ravel(),
                method="DOP853",
                rtol=_TOLERANCE,
                atol=0.1 * _TOLERANCE * floor.ravel(),
                t_eval=angles,
            )
        ended = found.success and np.isfinite(found.y).all()
        return np.asarray(found.y.reshape(*start.shape, -1)) if ended else None

    def ends(self, unknowns: FloatArray) -> FloatArray | None:
        """Unknowns (n - 1, k) a turn later; None where the crank stands before."""
        found = self._solved(unknowns, None)
        return None if found is None else found[:-1, :, -1]

    def motion(self, unknown: FloatArray) -> SettledMotion | None:
        """The turn from these unknowns."""
        angle = self._angle + self._way * np.linspace(0.0, 2 * np.pi, _ANGLES)
        solved = self._solved(unknown[:, None], angle)
        if solved is None:
            return None
        found = solved[:, 0]
        return SettledMotion(self._equation, found[-1], self.values(angle, found[:-1]))
