"""Prescribed motion of the crank: one form with angle, speed and acceleration at a time."""

from __future__ import annotations

import abc
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.drives.pieces import PiecewiseMotion, first_greatest
from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import RigidMotion
from flexmech.model_text import TomlTable, fields_table
from flexmech.units import ANGLE, ANGULAR_SPEED, TIME
from flexmech.validation import NOT_NEGATIVE, check_number

# Samples of a law, and the fewest of each of its pieces.
_SAMPLES, _OF_A_PIECE = 240, 4
# Of a turn: every five degrees.
_OF_A_TURN = 73


class Drive(abc.ABC):
    """Prescribed angle of the crank over time: a law of motion, then a constant speed.

    A crank that is to stop has the final speed zero. All drives are evaluated in one form, pieces
    of polynomials and sines, by both engines and by the kinematics.

    Attributes
    ----------
    start_angle : float
        Crank angle at time zero in rad.
    speed : float
        Final crank speed in rad/s, from :attr:`law_time` on.

    Examples
    --------
    >>> drive = flexmech.ConstantSpeed(20.0)
    >>> isinstance(drive, flexmech.Drive), float(drive.crank_angle(0.1))
    (True, 2.0)
    """

    start_angle: float
    speed: float

    @property
    @abc.abstractmethod
    def law(self) -> PiecewiseMotion:
        """The motion in pieces."""

    @property
    @abc.abstractmethod
    def words(self) -> str:
        """What the drive does, for titles."""

    @abc.abstractmethod
    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""

    @property
    def law_time(self) -> float:
        """Time in s from which on the crank turns at its final speed."""
        return self.law.end

    @property
    def speed_unit(self) -> str:
        """Unit in which results speak of crank speeds."""
        return ANGULAR_SPEED.unit

    @property
    def is_constant(self) -> bool:
        """Whether the crank turns at its final speed, or stands, from the start."""
        return self.law.is_steady

    @property
    def repeats(self) -> bool:
        """Whether the crank moves in every turn as in the one before."""
        return self.is_constant

    @property
    def turns_on(self) -> bool:
        """Whether a run goes on at the final speed after the law, turn by turn."""
        return self.speed != 0

    @property
    def revolution_time(self) -> float:
        """Time of a revolution at the final speed in s; infinite of a crank that stops."""
        return 2 * np.pi / abs(self.speed) if self.speed else np.inf

    @property
    def cycle_time(self) -> float:
        """Time in s over which samples are counted: of a turn at the final speed, or of a move."""
        return self.revolution_time

    def run_time(self, revolutions: float) -> float:
        """Duration in s of a run: the law, and turns at the final speed after it.

        Parameters
        ----------
        revolutions : float
            Of no account where the crank stops: such a run lasts as long as the law.

        Returns
        -------
        float
        """
        return self.law_time + (revolutions * self.revolution_time if self.speed else 0.0)

    def stretched(self, factor: float) -> Drive:
        """The same law over another time, with the same dwells.

        Parameters
        ----------
        factor : float
            By which every move takes longer.

        Returns
        -------
        Drive

        Raises
        ------
        InputError
            If the drive has no moves.
        """
        raise InputError(
            f"times of a move need a law that stops, and the crank goes on turning ({self.words}); "
            'give a law in [drive], as law = "cycloid" with travel, time and dwell'
        )

    def crank_angle(self, time: ArrayLike) -> FloatArray:
        """Crank angle in rad at times in s; shape (...) -> (...)."""
        return self.law.angle(time)

    def crank_speed(self, time: ArrayLike) -> FloatArray:
        """Crank speed in rad/s at times in s; shape (...) -> (...)."""
        return self.law.speed(time)

    def crank_acceleration(self, time: ArrayLike) -> FloatArray:
        """Crank acceleration in rad/s^2 at times in s; shape (...) -> (...)."""
        return self.law.acceleration(time)

    def motion(self, linkage: Linkage, time: ArrayLike) -> RigidMotion:
        """Rigid motion of a linkage with this drive, at times in s of shape (m,)."""
        return linkage.motion(
            self.crank_angle(time), self.crank_speed(time), self.crank_acceleration(time)
        )

    @property
    def passing_times(self) -> FloatArray:
        """Times in s at which the crank passes all that it passes, (m,).

        Within every piece of the law, and over a turn at the final speed.
        """
        knots = self.law.knots
        count = max(_OF_A_PIECE, _SAMPLES // max(1, len(knots) - 1))
        parts = np.arange(count) / count
        inside = (knots[:-1, None] + np.diff(knots)[:, None] * parts).reshape(-1)
        if not self.turns_on:
            return np.append(inside, self.law_time)
        turn = self.law_time + self.revolution_time * np.linspace(0.0, 1.0, _OF_A_TURN)
        return np.append(inside, turn)

    @property
    def corners(self) -> FloatArray:
        """Times in s, the first and the last of the law among them, at which its jerk may jump."""
        return self.law.knots

    @property
    def greatest_speed(self) -> float:
        """The greatest crank speed in rad/s, with its sign; that of rest where it never moves."""
        speeds = self.crank_speed(self.passing_times)
        return float(speeds[first_greatest(speeds)])

    def passed_angles(self, count: int) -> FloatArray:
        """Crank angles that the crank passes, evenly spaced and of one turn at most.

        Parameters
        ----------
        count : int
            At most, of a whole turn.

        Returns
        -------
        ndarray, shape (count,)
            In rad, the end of a whole turn left out.
        """
        angles = self.crank_angle(self.passing_times)
        low, high = float(angles.min()), float(angles.max())
        if self.turns_on or high - low >= 2 * np.pi:
            turn = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
            return np.asarray(self.start_angle + turn)
        return np.linspace(low, high, count)


@dataclass(frozen=True)
class ConstantSpeed(Drive):
    """Constant speed after an optional cycloidal run-up.

    During the run-up of duration ``T`` the speed is
    ``speed * (t / T - sin(2 pi t / T) / (2 pi))``, whose acceleration starts and ends at
    zero (Simo & Vu-Quoc 1986, the spin-up maneuver).

    Parameters
    ----------
    speed : float
        Final crank speed in rad/s; negative turns backwards.
    run_up_time : float
        Duration of the run-up in s; zero turns at the final speed from the start.
    start_angle : float
        Crank angle at time zero in rad.

    Raises
    ------
    InputError
        If the speed is zero or not finite, or the run-up time is negative.

    Examples
    --------
    >>> drive = flexmech.ConstantSpeed(speed=20.0, run_up_time=0.5)
    >>> drive.crank_speed([0.0, 0.25, 0.5]).round(9)
    array([ 0., 10., 20.])
    """

    speed: float
    run_up_time: float = 0.0
    start_angle: float = 0.0

    def __post_init__(self) -> None:
        check_number(self.speed, "crank speed", "rad/s")
        # At the least numbers a turn takes longer than numbers tell.
        if not np.isfinite(self.revolution_time):
            raise InputError(
                f"crank speed must be a number other than zero, got {self.speed:g} rad/s; give a "
                "speed at which the crank turns"
            )
        check_number(self.run_up_time, "run-up time", "s", NOT_NEGATIVE)
        check_number(self.start_angle, "start angle", "rad")

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""
        dimensions = {"speed": ANGULAR_SPEED, "run_up_time": TIME, "start_angle": ANGLE}
        return fields_table(self, dimensions)

    @cached_property
    def law(self) -> PiecewiseMotion:
        """The run-up; no pieces of a constant speed."""
        begin, total = float(self.start_angle), float(self.run_up_time)
        if not total:
            return PiecewiseMotion.steady(begin, float(self.speed))
        extent, turn = self.speed * total, 2 * np.pi
        # The second integral of 1 - cos(2 pi tau).
        rising = np.array([[begin - extent / turn**2, 0.0, extent / 2]])
        sine = np.array([[[extent / turn**2, turn, np.pi / 2]]])
        end = begin + extent / 2
        return PiecewiseMotion(np.array([0.0, total]), rising, sine, end, float(self.speed))

    @property
    def words(self) -> str:
        """The final speed, and the run-up."""
        after = f" after a run-up of {self.run_up_time:.3g} s" if self.run_up_time else ""
        return f"{self.speed:.10g} rad/s{after}"


@dataclass(frozen=True)
class LockedCrank(Drive):
    """A crank whose shaft is fixed at an angle.

    Parameters
    ----------
    angle : float
        In rad.

    Raises
    ------
    InputError
        If it is no number.
    """

    angle: float
    speed: ClassVar[float] = 0.0  # type: ignore[misc]

    def __post_init__(self) -> None:
        check_number(self.angle, "angle of a locked crank", "rad")

    @property
    def start_angle(self) -> float:  # type: ignore[override]
        """The angle in rad."""
        return self.angle

    def to_table(self) -> TomlTable:
        """None: a model file has a crank that turns."""
        return {}

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Rest."""
        return PiecewiseMotion.steady(float(self.angle), 0.0)

    @property
    def words(self) -> str:
        """Where the crank is fixed."""
        return f"crank fixed at {np.degrees(self.angle):.4g} deg"
