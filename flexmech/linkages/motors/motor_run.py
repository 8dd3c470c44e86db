"""Motion of the rigid linkage under a motor, as a drive: a run from rest, or settled turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.pieces import PiecewiseMotion
from flexmech.linkages.motors.drive_train import MotorOutput
from flexmech.linkages.motors.motor_drive import MotorDrive
from flexmech.linkages.motors.settled import SettledMotion, settled_motion
from flexmech.linkages.motors.shaft_equation import ShaftEquation, TwistedShaft
from flexmech.model_text import TomlTable

# Of the mean speed, by which a run may end off the settled motion.
_SETTLED = 1e-2
# Of the shorter step beside an instant, over which rates are differentiated.
_DIFFERENCE = 1e-3
# Pieces of a run that are in memory and in a file: a slip of the keyboard asks for more.
MOST_PIECES = 400_000
# Turns that are known at least: what is made of one looks beyond its end.
_LEAST_TURNS = 2


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
            return PiecewiseMotion.steady(self.start_angle, 0.0)
        known = (*self.values[:2], self.rates[1], self.second_rates[1])
        return self._between(known, self.speed)

    @property
    def words(self) -> str:
        """The motor, for titles."""
        return self.drive.words

    @property
    def speed_unit(self) -> str:
        """Unit in which results speak of crank speeds: that of the motor's control."""
        return self.drive.speed_unit

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

    def states(self, time: ArrayLike) -> FloatArray:
        """States of the drive train at times in s, (k, ...)."""
        at = np.clip(np.asarray(time, dtype=float), 0.0, self.time[-1])
        known = [motion.angle(at) for motion in self._state_motions]
        return np.reshape(known, (len(known), *at.shape))

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
    def has_settled(self) -> bool:
        """Whether the crank turns at the end as in the settled motion, within 1 % of its speed."""
        settled = self.settled
        if settled is None:
            return False
        apart = abs(self.values[1, -1] - settled.speed[0])
        return bool(apart <= _SETTLED * abs(settled.mean_speed))

    @cached_property
    def _state_motions(self) -> list[PiecewiseMotion]:
        """Each state of the drive train over time."""
        rows = zip(self.values[2:], self.rates[2:], self.second_rates[2:], strict=True)
        return [self._between(row, 0.0) for row in rows]

    def _between(self, known: Sequence[FloatArray], end_speed: float) -> PiecewiseMotion:
        """What has values and derivatives (m,) at the times of the integration."""
        starts, ends = ([row[part] for row in known] for part in (slice(-1), slice(1, None)))
        return PiecewiseMotion.hermite(self.time, starts, ends, float(known[0][-1]), end_speed)


@dataclass(frozen=True, eq=False)
class SettledRun(MotorRun):
    """Turns of a motion that repeats itself, from some crank angle on: a drive as any other.

    Of :func:`repeated`.

    Parameters
    ----------
    drive, equation, time, values, rates, second_rates, duration, stall : object
        As of :class:`MotorRun`; it has no stall.
    turn : SettledMotion
        The turn that is repeated.
    rigid : SettledMotion
        That of the rigid linkage.
    """

    turn: SettledMotion = field(kw_only=True)
    rigid: SettledMotion = field(kw_only=True)

    @property
    def repeats(self) -> bool:
        """Yes."""
        return True

    @cached_property
    def settled(self) -> SettledMotion | None:
        """That of the rigid linkage."""
        return self.rigid

    @cached_property
    def has_settled(self) -> bool:
        """Yes."""
        return True

    @property
    def revolution_time(self) -> float:
        """Time of a turn in s."""
        return float(self.turn.time[-1])

    @property
    def cycle_time(self) -> float:
        """Time of a turn in s."""
        return self.revolution_time


def second_rates(
    equation: ShaftEquation | TwistedShaft, time: FloatArray, values: FloatArray, rates: FloatArray
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


def repeated(
    turn: SettledMotion, rigid: SettledMotion, drive: MotorDrive, revolutions: float
) -> SettledRun:
    """A run on a settled motion.

    Parameters
    ----------
    turn : SettledMotion
    rigid : SettledMotion
        That of the rigid linkage, by the equation of its shaft.
    drive : MotorDrive
        Whose time, if it states one, is that of the run.
    revolutions : float
        Turns of the run otherwise.

    Returns
    -------
    SettledRun

    Raises
    ------
    InputError
        If the run is too long.
    """
    once = float(turn.time[-1])
    duration = drive.time if drive.time is not None else revolutions * once
    count = max(_LEAST_TURNS, int(np.ceil(duration / once)) + 1)
    if count * len(turn.time) > MOST_PIECES:
        raise InputError(
            f"the run of {duration:.4g} s has more than {MOST_PIECES} pieces; ask for a shorter "
            "time or fewer revolutions"
        )
    # Angles go on from turn to turn, of the crank and of a rotor on a coupling.
    grows = np.zeros((len(turn.values), 1))
    grows[turn.equation.train.angles] = turn.values[0, -1] - turn.values[0, 0]
    parts = [turn.values[:, :-1] + number * grows for number in range(count)]
    time = [turn.time[:-1] + number * once for number in range(count)]
    whole = np.concatenate([*time, [count * once]])
    values = np.concatenate([*parts, turn.values[:, :1] + count * grows], axis=1)
    rates = turn.equation.rates(whole, values)
    second = second_rates(turn.equation, whole, values, rates)
    equation = rigid.equation
    assert isinstance(equation, ShaftEquation)
    motion = whole, values, rates, second, duration
    return SettledRun(drive, equation, *motion, turn=turn, rigid=rigid)
