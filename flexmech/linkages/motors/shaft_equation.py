"""Equations of the shaft of a rigid linkage that a motor turns, as a system of first order."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motors.drive_train import DriveTrain
from flexmech.linkages.motors.turn_series import TurnSeries


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
class AddedTorque(ShaftLoad):
    """A load of the shaft, and one more torque that goes over the crank angle.

    Parameters
    ----------
    load : ShaftLoad
        The other one.
    torque : TurnSeries
        Needed besides over the crank angle, in N m.
    """

    load: ShaftLoad
    torque: TurnSeries

    @property
    def over_time(self) -> bool:
        """As the load."""
        return self.load.over_time

    def parts(
        self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """As the load, and the other torque."""
        inertia, needed = self.load.parts(angle, speed, time)
        return inertia, needed + self.torque(angle)


@dataclass(frozen=True, eq=False)
class ShaftEquation:
    """Crank angle and speed, and the states of what turns the crank.

    Parameters
    ----------
    load : ShaftLoad
    shaft_inertia : float
        Of the shaft that drives the crank, in kg m^2.
    train : DriveTrain
    """

    load: ShaftLoad
    shaft_inertia: float
    train: DriveTrain

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
        given, changes = self.train.on_crank(angle, speed, values[2:])
        acceleration = (given - needed) / (own + self._rigid_inertia)
        return np.concatenate([np.stack([speed, acceleration]), changes])

    def crank_torque(self, values: FloatArray) -> FloatArray:
        """Torque on the crank in N m, (...), of values (n, ...)."""
        return self.train.on_crank(values[0], values[1], values[2:])[0]

    def tolerances(self, relative: float) -> FloatArray:
        """Absolute tolerances (n,) of an integration with a relative one."""
        # In rad and rad/s; current and command are of order one or greater where they matter.
        return np.full(2 + self.train.state_count, 0.1 * relative)

    @property
    def _rigid_inertia(self) -> float:
        """Of all that turns with the crank besides the linkage."""
        return self.shaft_inertia + self.train.rigid_inertia
