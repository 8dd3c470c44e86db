"""Prescribed crank motion: constant speed, at once or after a smooth run-up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import RigidMotion
from flexmech.validation import NOT_NEGATIVE, check_number


@dataclass(frozen=True)
class CrankDrive:
    """Prescribed crank angle: constant speed after an optional cycloidal run-up.

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
    >>> drive = flexmech.CrankDrive(speed=20.0, run_up_time=0.5)
    >>> drive.crank_speed([0.0, 0.25, 0.5])
    array([ 0., 10., 20.])
    """

    speed: float
    run_up_time: float = 0.0
    start_angle: float = 0.0

    def __post_init__(self) -> None:
        check_number(self.speed, "crank speed", "rad/s")
        if self.speed == 0:
            raise InputError("crank speed must be a number other than zero, got 0 rad/s")
        check_number(self.run_up_time, "run-up time", "s", NOT_NEGATIVE)
        check_number(self.start_angle, "start angle", "rad")

    @property
    def revolution_time(self) -> float:
        """Time of a revolution at the final speed in s."""
        return 2 * np.pi / abs(self.speed)

    @property
    def is_constant(self) -> bool:
        """Whether the crank turns at its final speed from the start."""
        return self.run_up_time == 0

    def crank_angle(self, time: ArrayLike) -> FloatArray:
        """Crank angle in rad at times in s; shape (...) -> (...)."""
        t = np.asarray(time, dtype=float)
        total = self.run_up_time
        if not total:
            return np.asarray(self.start_angle + self.speed * t)
        inside = np.minimum(t, total)
        phase = 2 * np.pi * inside / total
        rising = inside**2 / (2 * total) - total * (1 - np.cos(phase)) / (2 * np.pi) ** 2
        after = np.maximum(t - total, 0.0)
        return np.asarray(self.start_angle + self.speed * (rising + after))

    def crank_speed(self, time: ArrayLike) -> FloatArray:
        """Crank speed in rad/s at times in s; shape (...) -> (...)."""
        t = np.asarray(time, dtype=float)
        total = self.run_up_time
        if not total:
            return np.full_like(t, self.speed)
        part = np.minimum(t, total) / total
        return np.asarray(self.speed * (part - np.sin(2 * np.pi * part) / (2 * np.pi)))

    def crank_acceleration(self, time: ArrayLike) -> FloatArray:
        """Crank acceleration in rad/s^2 at times in s; shape (...) -> (...)."""
        t = np.asarray(time, dtype=float)
        total = self.run_up_time
        if not total:
            return np.zeros_like(t)
        part = np.minimum(t, total) / total
        return np.asarray(self.speed / total * (1 - np.cos(2 * np.pi * part)))

    def motion(self, linkage: Linkage, time: ArrayLike) -> RigidMotion:
        """Rigid motion of a linkage with this drive, at times in s of shape (m,)."""
        return linkage.motion(
            self.crank_angle(time), self.crank_speed(time), self.crank_acceleration(time)
        )


@dataclass(frozen=True)
class LockedCrank:
    """A crank whose shaft is fixed at an angle.

    Parameters
    ----------
    angle : float
        In rad.

    Attributes
    ----------
    speed, run_up_time : float
        Zero: what a driven crank would have.

    Raises
    ------
    InputError
        If it is no number.
    """

    angle: float
    speed: ClassVar[float] = 0.0
    run_up_time: ClassVar[float] = 0.0
    is_constant: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_number(self.angle, "angle of a locked crank", "rad")

    def crank_angle(self, time: ArrayLike) -> FloatArray:
        """Crank angle in rad at times in s; shape (...) -> (...)."""
        return np.full_like(np.asarray(time, dtype=float), self.angle)

    def motion(self, linkage: Linkage, time: ArrayLike) -> RigidMotion:
        """Rigid linkage at rest, at times in s of shape (m,)."""
        return linkage.motion(self.crank_angle(time))
