"""Equations of the shaft of a rigid linkage that a motor turns, as a system of first order."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motors.drive_train import DriveTrain


class ShaftLoad(ABC):
    """What a rigid linkage asks of its shaft."""

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


@dataclass(frozen=True, eq=False)
class TurnSeries:
    """A function of an angle that repeats itself from turn to turn, as a Fourier series.

    It is the real part of ``sum_n c_n exp(i n angle)``, and has all derivatives: an integration of
    high order along it takes long steps.

    Parameters
    ----------
    coefficients : ndarray of complex, shape (harmonics + 1,)
        That of the mean first.
    """

    coefficients: ComplexArray

    @classmethod
    def of(cls, angle: FloatArray, values: FloatArray, harmonics: int) -> Self:
        """The series of a function that is known at some angles.

        Parameters
        ----------
        angle : ndarray, shape (m,)
            Increasing, over less than a turn, in rad; far closer than the harmonics need.
        values : ndarray, shape (m,)
        harmonics : int

        Returns
        -------
        TurnSeries
        """
        from scipy.interpolate import CubicSpline

        whole, closed = np.append(angle, angle[0] + 2 * np.pi), np.append(values, values[0])
        spline = CubicSpline(whole, closed, bc_type="periodic", extrapolate="periodic")
        count = len(angle)
        found = np.fft.rfft(spline(2 * np.pi / count * np.arange(count))) / count
        found[1:] *= 2.0
        return cls(found[: harmonics + 1])

    def __call__(self, angle: ArrayLike, order: int = 0) -> FloatArray:
        """Values, or those of a derivative by the angle, at angles in rad; (...) -> (...)."""
        number = np.arange(len(self.coefficients))
        waves = np.exp(1j * number * np.asarray(angle, dtype=float)[..., None])
        return np.asarray((waves @ (self.coefficients * (1j * number) ** order)).real)


@dataclass(frozen=True, eq=False)
class ShaftEquation:
    """Crank angle and speed, and the states of what turns the crank.

    Parameters
    ----------
    load : ShaftLoad
    shaft_inertia : float
        Of the shaft that drives the crank, in kg m^2.
    train : DriveTrain
    added : TurnSeries, optional
        Torque needed besides over the crank angle, in N m.
    """

    load: ShaftLoad
    shaft_inertia: float
    train: DriveTrain
    added: TurnSeries | None = None

    def start(self, angle: float) -> FloatArray:
        """Values (n,) at rest at a crank angle in rad; see :meth:`DriveTrain.start`."""
        needed = float(self.load.needed(angle, 0.0, 0.0))
        return np.array([angle, 0.0, *self.train.start(angle, needed)])

    def starts(self, angle: float) -> bool:
        """Whether the motor moves the linkage from rest at a crank angle in rad."""
        given = self.train.standing_torque
        return bool(self.train.way * (given - float(self.load.needed(angle, 0.0, 0.0))) > 0)

    def inertia(self, angle: ArrayLike) -> FloatArray:
        """Of all that turns rigidly with the crank in kg m^2 at crank angles in rad; (...)."""
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
        own, needed = self.load.parts(angle, speed, time)
        if self.added is not None:
            needed = needed + self.added(angle)
        given, changes = self.train.on_crank(angle, speed, values[2:])
        acceleration = (given - needed) / (own + self._rigid_inertia)
        return np.concatenate([np.stack([speed, acceleration]), changes])

    def tolerances(self, relative: float) -> FloatArray:
        """Absolute tolerances (n,) of an integration with a relative one."""
        # In rad and rad/s; current and command are of order one or greater where they matter.
        return np.full(2 + self.train.state_count, 0.1 * relative)

    @property
    def _rigid_inertia(self) -> float:
        """Of all that turns with the crank besides the linkage."""
        return self.shaft_inertia + self.train.rigid_inertia


@dataclass(frozen=True, eq=False)
class TwistedShaft:
    """A crank that follows a rotor, of which it lags behind by a twist that goes over its angle.

    Its values are those of a shaft with a coupling.

    Parameters
    ----------
    rotor : ShaftEquation
        Of the rotor without the coupling, whose load is all that the coupling carries.
    train : DriveTrain
        With the coupling.
    twist : TurnSeries
        In rad over the rotor's angle.
    """

    rotor: ShaftEquation
    train: DriveTrain
    twist: TurnSeries

    def values(self, rotor: FloatArray) -> FloatArray:
        """Values (n + 2, m) by those of the rotor (n, m): angle, speed, and the motor's states."""
        angle, speed = rotor[:2]
        followed = angle - self.twist(angle), speed * (1.0 - self.twist(angle, 1))
        return np.concatenate([np.stack(followed), rotor])

    def rates(self, time: ArrayLike, values: FloatArray) -> FloatArray:
        """Time derivatives of the values, (n, ...) at times (...)."""
        rates = self.rotor.rates(time, values[2:])
        angle, speed = values[2:4]
        accelerated = rates[1] * (1.0 - self.twist(angle, 1)) - speed**2 * self.twist(angle, 2)
        return np.concatenate([np.stack([values[1], accelerated]), rates])
