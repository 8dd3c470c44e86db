"""The rigid linkage under a motor: its crank angle is the one unknown.

With the inertia J of the linkage reduced to the crank, which depends on the crank angle::

    (J(theta) + J_shaft) theta'' + h(theta, theta', t) = torque on the crank

where h contains J'(theta) theta'^2 / 2 and what weight, springs and loads need (Uicker, Pennock &
Shigley, *Theory of Machines and Mechanisms*, 4th ed. 2011, ch. 16, the equivalent inertia). The
equations are integrated by an explicit Runge-Kutta method of eighth order (Hairer, Norsett &
Wanner, *Solving Ordinary Differential Equations I*, 1993, DOP853) between the corners of the motor.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError, InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.hermite import hermite_coefficients, hermite_motion
from flexmech.linkages.drives.pieces import PiecewiseMotion
from flexmech.linkages.motors.motor_drive import MotorDrive
from flexmech.linkages.motors.settled import SettledMotion, TurningShaft, settled_motion
from flexmech.linkages.motors.shaft_equation import ShaftEquation
from flexmech.linkages.motors.speed_control import MotorOutput
from flexmech.model_text import TomlTable

_TOLERANCE = 1e-11
# Of the shorter step beside an instant, over which rates are differentiated.
_DIFFERENCE = 1e-3
# How far a run is known beyond its end, of its time, so that its end is no corner.
_BEYOND = 0.02
# Turns after which a motor that does not settle is left alone, and the part by which the time of
# a turn still changes where it has settled.
_MOST_TURNS, _REPEATS = 200, 1e-3
# In s: a turn that takes longer is none.
_LONGEST_TURN = 1e3
# A motor that does not start is shown for so long, in s.
_STANDING = 0.1
# Pieces of a run that are in memory and in a file: a slip of the keyboard asks for more.
MOST_PIECES = 400_000


@dataclass(frozen=True)
class Stall:
    """Where a motor stalls.

    Parameters
    ----------
    time : float
        In s.
    crank_angle : float
        In rad.
    torque : float
        That the motor gives the crank at rest, in N m.
    needed : float
        On the crank to hold the linkage there, in N m.
    """

    time: float
    crank_angle: float
    torque: float
    needed: float


@dataclass(frozen=True, eq=False)
class MotorRun(Drive):
    """Motion of the rigid linkage under a motor: a drive as any other law of motion.

    Of :func:`flexmech.motor_run`.

    Parameters
    ----------
    drive : MotorDrive
    equation : ShaftEquation
        Of the linkage's shaft under the motor.
    time : ndarray, shape (m,)
        Of the integration in s, the first zero.
    values : ndarray, shape (n, m)
        Crank angle and speed, and the other unknowns, there.
    rates : ndarray, shape (n, m)
        Their time derivatives.
    second_rates : ndarray, shape (n, m)
        The time derivatives of these.
    duration : float
        In s; the last time is some beyond, but for a motor that stalls.
    stall : Stall, optional
        Of a motor that stalls before the end.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> motor = flexmech.TorqueMotor((0.0, 20.0), (1.5, 0.0), inertia=5e-3)
    >>> run = flexmech.motor_run(mechanism, flexmech.MotorDrive(motor))
    >>> round(run.settled.fluctuation, 3), run.stall is None
    (0.08, True)
    """

    drive: MotorDrive
    equation: ShaftEquation
    time: FloatArray
    values: FloatArray
    rates: FloatArray
    second_rates: FloatArray
    duration: float
    stall: Stall | None = None

    @property
    def start_angle(self) -> float:  # type: ignore[override]
        """Crank angle at time zero in rad."""
        return float(self.values[0, 0])

    @property
    def speed(self) -> float:  # type: ignore[override]
        """Crank speed in rad/s at the last time; zero after a stall."""
        return 0.0 if self.stall is not None else float(self.values[1, -1])

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Pieces with the angle, speed, acceleration and jerk of the solution at their ends."""
        if self.stall is not None and self.stall.time == 0:
            return PiecewiseMotion((), 0.0, self.start_angle, 0.0)
        known = (*self.values[:2], self.rates[1], self.second_rates[1])
        return hermite_motion(self.time, known, self.speed)

    @property
    def words(self) -> str:
        """The motor, for titles."""
        return self.drive.words

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file: that of the motor."""
        return self.drive.to_table()

    @property
    def turns_on(self) -> bool:
        """No: its speed is not constant after the end."""
        return False

    @property
    def is_constant(self) -> bool:
        """No: not even of a motor that does not start, whose torque is told."""
        return False

    @property
    def corners(self) -> FloatArray:
        """Times in s of its start and its end; between them it is smooth."""
        return np.array([0.0, self.time[-1]])

    @property
    def cycle_time(self) -> float:
        """Time of the last turn in s, so that cycles make the run; of less than a turn all."""
        end = float(self.crank_angle(self.duration))
        turned = abs(end - self.start_angle)
        if turned <= 2 * np.pi:
            return self.duration
        way = np.abs(self.values[0] - self.start_angle)
        last = self.duration - float(np.interp(turned - 2 * np.pi, way, self.time))
        return self.duration / max(1, round(self.duration / last))

    def run_time(self, revolutions: float) -> float:
        """Duration of the run in s.

        Parameters
        ----------
        revolutions : float
            Of no account: the run is one of so many already.
        """
        return self.duration

    def known_until(self, time: float) -> MotorRun:
        """The same run, whose motion is known until a time in s at least, or to a stall before.

        The forces of elastic links are filtered, which looks ahead.
        """
        if self.stall is not None or time <= self.time[-1]:
            return self
        further = _Integration(self.equation, self.drive, self.time, self.values)
        further.follow(time)
        return further.result(self.duration)

    def states(self, time: ArrayLike) -> FloatArray:
        """States of the drive train at times in s, (k, ...)."""
        at = np.clip(np.asarray(time, dtype=float), 0.0, self.time[-1])
        if len(self.values) == 2:
            return np.zeros((0, *at.shape))
        return np.asarray(self._states_in_pieces(at))

    def rotor_speed(self, time: ArrayLike) -> FloatArray:
        """Speed of the rotor over the gear ratio in rad/s at times in s; shape (...) -> (...)."""
        return self.equation.train.rotor_speed(self.crank_speed(time), self.states(time))

    def motor_output(self, time: ArrayLike) -> MotorOutput:
        """What the motor gives at times in s; shape (...) -> (...)."""
        return self.equation.train.motor_output(self.crank_speed(time), self.states(time))

    def crank_torque(self, time: ArrayLike) -> FloatArray:
        """Torque on the crank in N m, (...): of the coupling, or of gear and motor."""
        moved = self.crank_angle(time), self.crank_speed(time)
        return self.equation.train.on_crank(*moved, self.states(time))[0]

    @cached_property
    def settled(self) -> SettledMotion | None:
        """The motion that repeats itself from turn to turn; None where there is none."""
        if self.stall is not None or self.speed == 0.0:
            return None
        return settled_motion(self.equation, self.values[:, -1])

    @cached_property
    def _states_in_pieces(self) -> Any:
        from scipy.interpolate import PPoly

        known, span = (self.values[2:], self.rates[2:], self.second_rates[2:]), np.diff(self.time)
        coefficients = hermite_coefficients(
            span, [own[:, :-1] for own in known], [own[:, 1:] for own in known]
        )
        powers = np.arange(len(coefficients))[:, None, None]
        scaled = (coefficients / span**powers)[::-1]
        found = PPoly(np.moveaxis(scaled, 1, 2), self.time)
        return lambda at: np.moveaxis(found(at), -1, 0)


class _Found(Protocol):
    """What an integration of SciPy gives."""

    t: FloatArray
    y: FloatArray
    t_events: Any
    success: bool
    message: str


def solved_run(
    equation: ShaftEquation, drive: MotorDrive, revolutions: float | None = None
) -> MotorRun:
    """Motion of a shaft under a motor.

    Parameters
    ----------
    equation : ShaftEquation
    drive : MotorDrive
    revolutions : float, optional
        Turns after which the run ends where the drive states no time; until it settles if left
        out.

    Returns
    -------
    MotorRun

    Raises
    ------
    InputError
        If nothing has any inertia, or the run is too long.
    ComputationError
        If the integration fails; names the time and the crank angle.
    """
    equation.check_inertia()
    start = equation.start(drive.start_angle)
    if not equation.starts(drive.start_angle):
        return _standing(equation, drive, start)
    return _Integration(equation, drive, np.zeros(1), start[:, None]).run(revolutions)


def _standing(equation: ShaftEquation, drive: MotorDrive, start: FloatArray) -> MotorRun:
    """A motor that cannot move the linkage from where it stands."""
    time = np.array([0.0, drive.time or _STANDING])
    stall = _stall(equation, 0.0, start)
    values = np.column_stack([start, start])
    still = np.zeros_like(values)
    return MotorRun(drive, equation, time, values, still, still, float(time[1]), stall)


def _stall(equation: ShaftEquation, time: float, values: FloatArray) -> Stall:
    angle = float(values[0])
    given = equation.train.standing_torque
    return Stall(time, angle, given, float(equation.load.needed(angle, 0.0, time)))


def second_rates(
    equation: TurningShaft, time: FloatArray, values: FloatArray, rates: FloatArray
) -> FloatArray:
    """Time derivatives of the rates along a motion, (n, m), by differences over parts of steps.

    Parameters
    ----------
    equation : ShaftEquation or TwistedShaft
    time : ndarray, shape (m,)
        In s, increasing.
    values, rates : ndarray, shape (n, m)
    """
    step = _DIFFERENCE * np.minimum(np.diff(time, prepend=-np.inf), np.diff(time, append=np.inf))
    ahead = equation.rates(time + step, values + step * rates)
    back = equation.rates(time - step, values - step * rates)
    return np.asarray((ahead - back) / (2 * step))


class _Integration:
    """Integration until the end, a stall or the settled motion.

    Parameters
    ----------
    equation : ShaftEquation
    drive : MotorDrive
    time : ndarray, shape (m,)
        Until which the motion is known, in s; of a start from rest zero.
    values : ndarray, shape (n, m)
        At these times.
    """

    def __init__(
        self, equation: ShaftEquation, drive: MotorDrive, time: FloatArray, values: FloatArray
    ) -> None:
        self._equation, self._drive, self._way = equation, drive, equation.train.way
        # Of a coupling the rotor stalls; the crank may stand still as it swings against it.
        self._speed = 3 if equation.train.is_coupled else 1
        self._time, self._values = [time], [values]

    def run(self, revolutions: float | None) -> MotorRun:
        """The run; see :func:`solved_run`."""
        duration = self._until_end(revolutions)
        if duration is not None:
            # A stall beyond the end is none.
            self.follow(duration * (1 + _BEYOND))
        return self.result(duration)

    def follow(self, until: float) -> None:
        """Integrate on until a time in s; a stall before it ends the motion."""
        self._advance(until, np.inf)

    def result(self, duration: float | None) -> MotorRun:
        """The run of a duration in s, or until the stall where there is none."""
        time, values = np.concatenate(self._time), np.concatenate(self._values, axis=1)
        if len(time) > MOST_PIECES:
            raise InputError(
                f"the run of {time[-1]:.4g} s has more than {MOST_PIECES} pieces; ask for a "
                "shorter time or fewer revolutions"
            )
        stall = None
        if duration is None:
            duration = float(time[-1])
            stall = _stall(self._equation, duration, values[:, -1])
        rates = self._equation.rates(time, values)
        second = second_rates(self._equation, time, values, rates)
        return MotorRun(self._drive, self._equation, time, values, rates, second, duration, stall)

    def _until_end(self, revolutions: float | None) -> float | None:
        """Integrate; returns the duration, or None of a motor that stalls."""
        if (time := self._drive.time) is not None:
            return time if self._advance(time, np.inf) else None
        if revolutions is not None:
            return float(self._time[-1][-1]) if self._advance(np.inf, revolutions) else None
        last, spent = np.inf, 0.0
        for _ in range(_MOST_TURNS):
            if not self._advance(np.inf, 1.0):
                return None
            now = float(self._time[-1][-1])
            turn, spent = now - spent, now
            if abs(turn - last) <= _REPEATS * turn:
                break
            last = turn
        return spent

    def _advance(self, until: float, turns: float) -> bool:
        """Integrate on until a time or by some turns; returns whether the crank still turns."""
        from scipy.integrate import solve_ivp

        equation, way = self._equation, self._way
        begin, start = float(self._time[-1][-1]), self._values[-1][:, -1]
        goal = start[0] + way * 2 * np.pi * turns

        def standstill(time: float, values: FloatArray) -> float:
            return float(way * values[self._speed])

        def turned(time: float, values: FloatArray) -> float:
            return float(way * (values[0] - goal)) if np.isfinite(turns) else -1.0

        standstill.terminal, standstill.direction = True, -1.0  # type: ignore[attr-defined]
        turned.terminal, turned.direction = True, 1.0  # type: ignore[attr-defined]
        span = (begin, until if np.isfinite(until) else begin + _LONGEST_TURN * turns)
        found: _Found = solve_ivp(
            equation.rates,
            span,
            start,
            method="DOP853",
            rtol=_TOLERANCE,
            atol=equation.tolerances(_TOLERANCE),
            events=(standstill, turned),
        )
        if not found.success:
            at = np.degrees(float(found.y[0, -1]))
            raise ComputationError(
                f"the motion under the motor cannot be followed beyond {found.t[-1]:.6g} s, crank "
                f"angle {at:.6g} deg: {found.message}; check the motor's inductance and the "
                "coupling, whose times may be far shorter than the run"
            )
        self._time.append(found.t[1:])
        self._values.append(found.y[:, 1:])
        # A crank that creeps stands.
        return bool(np.isfinite(until) or len(found.t_events[1])) and not len(found.t_events[0])
