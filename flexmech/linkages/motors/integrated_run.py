"""Integration of the rigid linkage under a motor, and of the drive train along a known motion.

The crank angle of the rigid linkage is its one unknown. With the inertia J of the linkage reduced
to the crank, which depends on the crank angle::

    (J(theta) + J_shaft) theta'' + h(theta, theta', t) = torque on the crank

where h contains J'(theta) theta'^2 / 2 and what weight, springs and loads need (Uicker, Pennock &
Shigley, *Theory of Machines and Mechanisms*, 4th ed. 2011, ch. 16, the equivalent inertia). The
equations are integrated by an explicit Runge-Kutta method of eighth order (Hairer, Norsett &
Wanner, *Solving Ordinary Differential Equations I*, 1993, DOP853) between the corners of the motor.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError, InputError
from flexmech.linkages.motors.motor import DriveTrain, MotorDrive
from flexmech.linkages.motors.motor_run import (
    MOST_PIECES,
    MotorRun,
    ShaftEquation,
    Stall,
    second_rates,
)

_TOLERANCE = 1e-11
# How far a run is known beyond its end, of its time, so that its end is no corner.
_BEYOND = 0.02
# Turns after which a motor that does not settle is left alone, and the part by which the time of
# a turn still changes where it has settled.
_MOST_TURNS, _REPEATS = 200, 1e-3
# In s: a turn that takes longer is none.
_LONGEST_TURN = 1e3
# A motor that does not start is shown for so long, in s.
_STANDING = 0.1


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


def known_until(run: MotorRun, time: float) -> MotorRun:
    """The same run, whose motion is known until a time at least, or to a stall before.

    The forces of elastic links are filtered, which looks ahead.

    Parameters
    ----------
    run : MotorRun
    time : float
        In s.

    Returns
    -------
    MotorRun
        Run of the same duration.

    Raises
    ------
    ComputationError
        If the integration fails; names the time and the crank angle.
    """
    if run.stall is not None or time <= run.time[-1]:
        return run
    further = _Integration(run.equation, run.drive, run.time, run.values)
    further.follow(time)
    return further.result(run.duration)


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
        # With a coupling the rotor stalls; the crank may stand still as it swings against it.
        self._speed = 3 if equation.train.is_coupled else 1
        self._time, self._values = [time], [values]

    def run(self, revolutions: float | None) -> MotorRun:
        """The run; see :func:`solved_run`."""
        self._fall_back()
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

    def _fall_back(self) -> None:
        """Integrate until the rotor stands again that a small first current lets turn back."""
        start = self._values[0][:, 0]
        if self._way * self._equation.rates(0.0, start)[self._speed] >= 0:
            return

        def turns_on(time: float, values: FloatArray) -> float:
            return float(self._way * values[self._speed])

        def fallen(time: float, values: FloatArray) -> float:
            return float(self._way * (values[0] - start[0])) + np.pi

        turns_on.terminal, turns_on.direction = True, 1.0  # type: ignore[attr-defined]
        fallen.terminal, fallen.direction = True, -1.0  # type: ignore[attr-defined]
        solution = self._solved(self._drive.time or _LONGEST_TURN, (turns_on, fallen))
        if len(solution.t_events[1]):
            raise InputError(
                "drive: motor: with its initial_current the crank falls back by half a turn before "
                "the motor holds it; state a greater one, or leave initial_current out, which is "
                "then the current that holds the crank"
            )
        self._keep(solution)

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
        way = self._way
        begin, start = float(self._time[-1][-1]), self._values[-1][:, -1]
        goal = start[0] + way * 2 * np.pi * turns

        def standstill(time: float, values: FloatArray) -> float:
            return float(way * values[self._speed])

        def turned(time: float, values: FloatArray) -> float:
            return float(way * (values[0] - goal)) if np.isfinite(turns) else -1.0

        standstill.terminal, standstill.direction = True, -1.0  # type: ignore[attr-defined]
        turned.terminal, turned.direction = True, 1.0  # type: ignore[attr-defined]
        end = until if np.isfinite(until) else begin + _LONGEST_TURN * turns
        solution = self._solved(end, (standstill, turned))
        self._keep(solution)
        # A crank that creeps stands.
        return bool(np.isfinite(until) or len(solution.t_events[1])) and not len(
            solution.t_events[0]
        )

    def _solved(self, until: float, events: tuple[Any, ...]) -> Any:
        """The motion from the last time until another in s, or a terminal event."""
        from scipy.integrate import solve_ivp

        solution = solve_ivp(
            self._equation.rates,
            (float(self._time[-1][-1]), until),
            self._values[-1][:, -1],
            method="DOP853",
            rtol=_TOLERANCE,
            # In rad and rad/s; current and command are of order one or greater where they matter.
            atol=0.1 * _TOLERANCE,
            events=events,
        )
        if not solution.success:
            at = np.degrees(float(solution.y[0, -1]))
            raise ComputationError(
                f"the motion under the motor cannot be followed beyond {solution.t[-1]:.6g} s, "
                f"crank angle {at:.6g} deg: {solution.message}; check the motor's inductance and "
                "the coupling, whose times may be far shorter than the run"
            )
        return solution

    def _keep(self, solution: Any) -> None:
        # An event at the start leaves a step without a length.
        later = solution.t > self._time[-1][-1]
        if later.any():
            self._time.append(solution.t[later])
            self._values.append(solution.y[:, later])


# Tolerance of the residual between the nodes, relative: values are off by 3e-8 of the
# greatest then, also of controls at their limits, far below what ends the passes of a run.
_ALONG_TOLERANCE = 1e-5
# For each time that is given: more are needed where a control meets its limits. Work alone.
_MOST_NODES = 50


def states_along(
    train: DriveTrain, time: FloatArray, angle: FloatArray, speed: FloatArray, start: FloatArray
) -> FloatArray:
    """States of a drive train whose crank moves as known.

    Parameters
    ----------
    train : DriveTrain
    time : ndarray, shape (m,)
        Increasing, in s.
    angle, speed : ndarray, shape (m,)
        Crank angle in rad and crank speed in rad/s; cubic splines between.
    start : ndarray, shape (k,)
        At the first time.

    Returns
    -------
    ndarray, shape (k, m)

    Raises
    ------
    ComputationError
        If the integration fails; names the time.
    """
    from scipy.interpolate import CubicSpline

    if not train.state_count:
        return np.zeros((0, len(time)))
    known = CubicSpline(time, np.stack([angle, speed], axis=1))

    def rates(at: FloatArray, states: FloatArray) -> FloatArray:
        place, turning = known(at).T
        return train.on_crank(place, turning, states)[1]

    return _integrated(rates, time, start)


def yielded_along(
    train: DriveTrain,
    time: FloatArray,
    angle: FloatArray,
    speed: FloatArray,
    applied: FloatArray,
    inertia: FloatArray,
    start: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """How a crank with an inertia moves away from a motion whose torque is not quite the train's.

    Parameters
    ----------
    train : DriveTrain
    time : ndarray, shape (m,)
        Increasing, in s.
    angle, speed, applied, inertia : ndarray, shape (m,)
        Crank angle in rad, crank speed in rad/s, torque on the crank in N m, and inertia there in
        kg m^2.
    start : ndarray, shape (k,)
        States of the train at the first time.

    Returns
    -------
    angle, speed : ndarray, shape (m,)
        To be added to those of the motion.

    Raises
    ------
    ComputationError
        If the integration fails; names the time.
    """
    from scipy.interpolate import CubicSpline

    known = CubicSpline(time, np.stack([angle, speed, applied, inertia], axis=1))

    def rates(at: FloatArray, values: FloatArray) -> FloatArray:
        place, was, given, inertia_there = known(at).T
        torque, changes = train.on_crank(place + values[0], was + values[1], values[2:])
        return np.concatenate([np.stack([values[1], (torque - given) / inertia_there]), changes])

    solution = _integrated(rates, time, np.concatenate([np.zeros(2), start]))
    return solution[0], solution[1]


def _integrated(
    rates: Callable[[FloatArray, FloatArray], FloatArray], time: FloatArray, start: FloatArray
) -> FloatArray:
    """Values (n, m) at times (m,), all at once: by collocation of fourth order.

    The method of Kierzenka & Shampine 2001 for boundary values, all of which are at the start: what
    is known between the times is a spline of theirs, at whose knots a method that takes one step
    after the other would have to stop.
    """
    from scipy.integrate import solve_bvp

    solution: Any = solve_bvp(
        rates,
        lambda first, _: first - start,
        time,
        np.repeat(start[:, None], len(time), axis=1),
        tol=_ALONG_TOLERANCE,
        max_nodes=_MOST_NODES * len(time),
    )
    if solution.status:
        raise ComputationError(
            f"motor and coupling cannot be followed in the run of {time[-1]:.6g} s: "
            f"{solution.message} Check the motor's inductance and the coupling, whose times may be "
            "far shorter than the run"
        )
    return np.asarray(solution.sol(time))
