"""Motion of the rigid linkage under a motor: its equation, settled turns, and runs as drives.

The settled motion repeats itself from turn to turn and is found directly. The crank angle is the
independent variable: after a turn of it all other unknowns are as before. That is a boundary value
problem, solved by collocation of fourth order (Kierzenka & Shampine, "A BVP solver based on
residual control and the MATLAB PSE", *ACM Trans. Math. Softw.* 27, 2001).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.change_points import TURN
from flexmech.linkages.drives.drive import Drive, PiecewiseMotion
from flexmech.linkages.motors.motor import DriveTrain, MotorDrive, MotorOutput
from flexmech.model_text import TomlTable

if TYPE_CHECKING:
    from flexmech.dynamical_systems.fourier import FourierSeries


class ShaftLoad(ABC):
    """Torque and inertia that a rigid linkage asks of its shaft."""

    @property
    @abstractmethod
    def over_time(self) -> bool:
        """Whether a load goes over time, so that no turn is like another."""

    @abstractmethod
    def parts(
        self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Both of :meth:`inertia` and :meth:`needed` at crank angles, speeds and times; (...).

        Parameters
        ----------
        angle, speed, time : array_like, shape (...)
            In rad, rad/s and s.
        """

    def inertia(self, angle: ArrayLike) -> FloatArray:
        """Inertia reduced to the crank in kg m^2 at crank angles in rad; (...) -> (...)."""
        return self.parts(angle, 0.0, 0.0)[0]

    def needed(self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike) -> FloatArray:
        """Torque without acceleration in N m at crank angles, speeds and times; (...).

        Parameters
        ----------
        angle, speed, time : array_like, shape (...)
            In rad, rad/s and s.
        """
        return self.parts(angle, speed, time)[1]


def turn_series(angle: FloatArray, values: FloatArray, harmonics: int) -> FourierSeries:
    """Fourier series of a function of an angle that repeats itself from turn to turn.

    It has all derivatives: an integration of high order along it takes long steps.

    Parameters
    ----------
    angle : ndarray, shape (m,)
        Increasing, over less than a turn, in rad; far closer than the harmonics need.
    values : ndarray, shape (m,)
    harmonics : int

    Returns
    -------
    FourierSeries
        Over turns of the angle.
    """
    from scipy.interpolate import CubicSpline

    from flexmech.dynamical_systems.fourier import FourierSeries

    whole, closed = np.append(angle, angle[0] + TURN), np.append(values, values[0])
    spline = CubicSpline(whole, closed, bc_type="periodic", extrapolate="periodic")
    series = FourierSeries.through(spline(TURN / len(angle) * np.arange(len(angle))))
    return FourierSeries(series.coefficients[: harmonics + 1])


@dataclass(frozen=True, eq=False)
class ShaftEquation:
    """Crank angle and speed, and the states of what turns the crank.

    Parameters
    ----------
    load : ShaftLoad
    shaft_inertia : float
        Shaft inertia of the shaft that drives the crank, in kg m^2.
    train : DriveTrain
    added : FourierSeries, optional
        Torque needed besides in N m, over turns of the crank.
    """

    load: ShaftLoad
    shaft_inertia: float
    train: DriveTrain
    added: FourierSeries | None = None

    def start(self, angle: float) -> FloatArray:
        """Values (n,) at rest at a crank angle in rad; see :meth:`DriveTrain.start`."""
        needed = float(self.load.needed(angle, 0.0, 0.0))
        return np.array([angle, 0.0, *self.train.start(angle, needed)])

    def starts(self, angle: float) -> bool:
        """Whether the motor moves the linkage from rest at a crank angle in rad."""
        given = self.train.standing_torque
        return bool(self.train.way * (given - float(self.load.needed(angle, 0.0, 0.0))) > 0)

    def inertia(self, angle: ArrayLike) -> FloatArray:
        """Inertia that rotates with the crank, in kg m^2, at crank angles in rad; (...)."""
        return self.load.inertia(angle) + self._rigid_inertia

    def check_inertia(self) -> None:
        """Refuse a shaft without any inertia.

        Raises
        ------
        InputError
        """
        around = np.radians(np.arange(0.0, 360.0, 5.0))
        if not float(self.inertia(around).min()) > 0:
            raise InputError(
                "drive: neither the linkage nor its shaft nor the motor has any inertia, so that "
                "the motor would start at once; state [shaft] inertia or that of the motor"
            )

    def rates(self, time: ArrayLike, values: FloatArray) -> FloatArray:
        """Time derivatives of the values, (n, ...) at times (...)."""
        angle, speed = values[:2]
        load_inertia, needed = self.load.parts(angle, speed, time)
        if self.added is not None:
            needed = needed + self.added.at(angle / TURN)
        given, changes = self.train.on_crank(angle, speed, values[2:])
        acceleration = (given - needed) / (load_inertia + self._rigid_inertia)
        return np.concatenate([np.stack([speed, acceleration]), changes])

    @property
    def _rigid_inertia(self) -> float:
        """Inertia of all that turns with the crank besides the linkage."""
        return self.shaft_inertia + self.train.rigid_inertia


@dataclass(frozen=True, eq=False)
class TwistedShaft:
    """A crank that follows a rotor, of which it lags behind by a twist that goes over its angle.

    Its values are those of a shaft with a coupling.

    Parameters
    ----------
    rotor : ShaftEquation
        Equation of the rotor without the coupling, whose load is all that the coupling carries.
    train : DriveTrain
        With the coupling.
    twist : FourierSeries
        In rad, over turns of the rotor.
    """

    rotor: ShaftEquation
    train: DriveTrain
    twist: FourierSeries

    def values(self, rotor: FloatArray) -> FloatArray:
        """Values (n + 2, m) by those of the rotor (n, m): angle, speed, and the motor's states."""
        angle, speed = rotor[:2]
        followed = angle - self._twist(angle), speed * (1.0 - self._twist(angle, 1))
        return np.concatenate([np.stack(followed), rotor])

    def rates(self, time: ArrayLike, values: FloatArray) -> FloatArray:
        """Time derivatives of the values, (n, ...) at times (...)."""
        rates = self.rotor.rates(time, values[2:])
        angle, speed = values[2:4]
        accelerated = rates[1] * (1.0 - self._twist(angle, 1)) - speed**2 * self._twist(angle, 2)
        return np.concatenate([np.stack([values[1], accelerated]), rates])

    def _twist(self, angle: FloatArray, order: int = 0) -> FloatArray:
        """Twist, or a derivative of it by the rotor's angle."""
        series = self.twist
        for _ in range(order):
            series = series.rate()
        return series.at(angle / TURN) / TURN**order


# Angles turned through at which the motion is sampled.
_TURN: FloatArray = np.linspace(0.0, 2 * np.pi, 721)
# Tolerance of the residual between the nodes, relative: mean speeds are within 1e-9 of those by
# steps of 1e-11.
_TOLERANCE = 1e-7
# Work alone.
_MOST_NODES = 10_000
# Over the speed near which it is sought: a motor whose torque does not fall knows no bound.
_FAST = 1e3
# Most doublings of the speed from which the settled one is sought.
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
        """Speed of the crank in rad/s, (m,)."""
        return np.asarray(self.values[1])

    @cached_property
    def output(self) -> MotorOutput:
        """Output of the motor, arrays of shape (m,)."""
        return self.equation.train.motor_output(self.values[1], self.values[2:])

    @property
    def power(self) -> FloatArray:
        """Power of the motor in W, (m,)."""
        train = self.equation.train
        turning = train.rotor_speed(self.values[1], self.values[2:])
        return self.output.torque * train.motor.gear_ratio * turning

    @property
    def mean_speed(self) -> float:
        """Mean speed of the crank in rad/s: a turn over its time."""
        turn = float(self.crank_angle[-1] - self.crank_angle[0])
        return turn / float(self.time[-1])

    @property
    def fluctuation(self) -> float:
        """Coefficient of speed fluctuation: greatest less least speed over the mean."""
        return speed_range(self.time, self.speed) / abs(self.mean_speed)

    @property
    def mean_power(self) -> float:
        """Mean power of the motor in W."""
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
    # For a piece of constant speed SciPy gives its begin, and not a number for the rest of it.
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
        turn_values = turn.repeated(start)
        if turn_values is not None and np.abs(turn_values[0]).max() <= bound:
            return SettledMotion(
                equation, turn_values[-1], turn.values(turn.angles, turn_values[:-1])
            )
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
        states = values[1:].copy()
        if self._equation.train.is_coupled:
            states[1] -= values[0]
        return states

    def values(self, angle: FloatArray | float, states: FloatArray) -> FloatArray:
        """Values (n, ...) of unknowns (n - 1, ...) at crank angles (...)."""
        values = np.concatenate([np.broadcast_to(angle, states.shape[1:])[None], states])
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
            solution: Any = solve_bvp(
                self._rates,
                lambda first, last: np.append(last[:-1] - first[:-1], first[-1]),
                _TURN,
                start,
                tol=_TOLERANCE,
                max_nodes=_MOST_NODES,
            )
        if solution.status or not np.all(self._way * solution.y[0] > 0):
            return None
        return np.asarray(solution.sol(_TURN))

    @property
    def angles(self) -> FloatArray:
        """Crank angles of the turn in rad, (m,)."""
        return np.asarray(self._angle + self._way * _TURN)

    def _rates(self, turned: FloatArray, states: FloatArray) -> FloatArray:
        """By the angle turned through (k,): of the unknowns (n - 1, k), and last of the time."""
        angle = self._angle + self._way * turned
        rates = self._equation.rates(0.0, self.values(angle, states[:-1]))
        if self._equation.train.is_coupled:
            rates[2] -= rates[0]
        by_time = np.concatenate([rates[1:], np.ones((1, states.shape[1]))])
        return np.asarray(self._way * by_time / states[0])


# Part of the mean speed by which a run may end off the settled motion.
_SETTLED = 1e-2
# Part of the shorter step beside an instant, over which rates are differentiated.
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

    :func:`flexmech.motor_run` returns it.

    Parameters
    ----------
    drive : MotorDrive
    equation : ShaftEquation
        Equation of the linkage's shaft under the motor.
    time : ndarray, shape (m,)
        Time of the integration in s, the first zero.
    values : ndarray, shape (n, m)
        Crank angle and speed, and the other unknowns, there.
    rates : ndarray, shape (n, m)
        Their time derivatives.
    second_rates : ndarray, shape (n, m)
        The time derivatives of these.
    duration : float
        In s; the last time is some beyond, but for a motor that stalls.
    stall : Stall, optional
        Place of the stall, where a motor stalls before the end.

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
        """No: a motor that does not start still has a torque."""
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
            Not used: the run is one of so many already.
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
        """Output of the motor at times in s; shape (...) -> (...)."""
        return self.equation.train.motor_output(self.crank_speed(time), self.states(time))

    def rotor_torque(self, time: ArrayLike) -> FloatArray:
        """Rate of the rotor's angular momentum in N m at times in s; shape (...) -> (...)."""
        motor = self.drive.motor
        if self.equation.train.is_coupled:
            at = np.clip(np.asarray(time, dtype=float), 0.0, self.time[-1])
            acceleration = self._state_motions[1].speed(at)
        else:
            acceleration = self.crank_acceleration(time)
        return motor.inertia * motor.gear_ratio * acceleration

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
        """Spline with values and derivatives (m,) at the times of the integration."""
        starts, ends = ([row[rows] for row in known] for rows in (slice(-1), slice(1, None)))
        return PiecewiseMotion.hermite(self.time, starts, ends, float(known[0][-1]), end_speed)


@dataclass(frozen=True, eq=False)
class SettledRun(MotorRun):
    """Turns of a motion that repeats itself, from some crank angle on: a drive as any other.

    :func:`repeated` returns it.

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
        """Settled motion of the rigid linkage."""
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
