"""A run on the settled motion under a motor: every turn as the one before."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motors.drive_train import DriveTrain
from flexmech.linkages.motors.motor_drive import MotorDrive
from flexmech.linkages.motors.motor_run import MOST_PIECES, MotorRun, second_rates
from flexmech.linkages.motors.settled import SettledMotion
from flexmech.linkages.motors.shaft_equation import ShaftEquation
from flexmech.linkages.motors.turn_series import TurnSeries

# Turns that are known at least: what is made of one looks beyond its end.
_LEAST_TURNS = 2


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
