"""What kinematics is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from flexmech.analyses.aspects.shaking import checked_point
from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.requests import in_radians
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import Drive, MotorDrive
from flexmech.mechanism import Mechanism, motor_run
from flexmech.validation import check_count, check_instance, check_number, checked_tuple

# Elements of a link whose mass is lumped: with so many the inertia force is the distributed one to
# six digits.
_MOST_LUMPS = 1000


@dataclass(frozen=True)
class KinematicsRequest:
    """Crank angles, speed and acceleration, and how masses are lumped for a comparison.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        In rad, increasing; a turn in steps of one degree if left out.
    crank_speed : float, optional
        In ``speed_unit``; may be zero or negative. Left out: the greatest speed at which the
        mechanism operates, zero if it names none.
    lumped : sequence of int, optional
        For each link in order the number of elements whose mass is halved onto their ends, or
        one number for all; Kumar & Chandrakar's Figure 1.5 has (1, 4, 4).
    speed_unit : str, optional
        Unit of the crank speed, such as ``"rpm"``, in which it is printed and drawn. Left out:
        rad/s, and the unit of the model file for the mechanism's speed.
    crank_acceleration : float, optional
        In rad/s^2, alpha2 of Kumar & Chandrakar's eqs. 1.35 to 1.40. At each crank angle
        the crank has the speed and this acceleration: these are states, and not one run through
        all angles.
    moment_point : tuple of float, optional
        About which the shaking moment is taken, in ground axes in m; the shaft's axis if left out.
    drive : Drive or MotorDrive, optional
        A law of motion, or a motor, in place of angles, speed and acceleration: all is over time
        then.

    Raises
    ------
    InputError
        If a drive is given beside angles, speed or acceleration; or these are no numbers, angles do
        not increase, or a number of elements is below one or beyond 1000.

    Examples
    --------
    >>> flexmech.KinematicsRequest(crank_speed=20.0, lumped=(1, 4, 4)).crank_angles.shape
    (361,)
    """

    crank_angles: FloatArray = field(default_factory=lambda: np.radians(np.arange(361.0)))
    crank_speed: float | None = None
    lumped: Sequence[int] | None = None
    speed_unit: str | None = None
    crank_acceleration: float = 0.0
    moment_point: tuple[float, float] | None = None
    drive: Drive | MotorDrive | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        angles = in_radians("crank_angles", self.crank_angles)
        if angles.ndim != 1 or not angles.size or np.any(np.diff(angles) <= 0):
            raise InputError(
                f"crank_angles must be one or more in increasing order, got shape {angles.shape}"
            )
        object.__setattr__(self, "crank_angles", angles)
        if self.crank_speed is not None:
            one_rad_per_s(self.crank_speed, self.speed_unit)
        check_number(self.crank_acceleration, "crank_acceleration", "rad/s^2")
        if self.drive is not None:
            self._check_drive(self.drive)
        if self.lumped is not None:
            remedy = "give the elements of each link, as (1, 4, 4)"
            counts = checked_tuple(self.lumped, object, "lumped", remedy)
            for count in counts:
                check_count(count, "lumped: each number of elements")
                if count > _MOST_LUMPS:
                    raise InputError(
                        f"lumped: {count} elements of a link are beyond {_MOST_LUMPS}; the "
                        "distributed mass is what they tend to"
                    )
            object.__setattr__(self, "lumped", counts)

    def _check_drive(self, drive: Drive | MotorDrive) -> None:
        if not isinstance(drive, MotorDrive):
            check_instance(drive, Drive, "drive", "give a flexmech.LawDrive or another drive")
        others = self.crank_speed is not None or self.crank_acceleration
        usual = np.radians(np.arange(361.0))
        own = self.crank_angles.shape == usual.shape and np.allclose(self.crank_angles, usual)
        if others or not (own or drive.is_constant):
            raise InputError(
                "drive: a law of motion has its own angles, speed and acceleration; leave these "
                "out, or leave the drive out"
            )

    @property
    def law(self) -> Drive | None:
        """The drive, where it is more than a constant speed."""
        if not isinstance(self.drive, Drive) or self.drive.is_constant:
            return None
        return self.drive

    def of(self, mechanism: Mechanism) -> KinematicsRequest:
        """The request with the motion that a motor gives the linkage of a mechanism."""
        if not isinstance(self.drive, MotorDrive):
            return self
        return replace(self, drive=motor_run(mechanism, self.drive))

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: as asked for, or the greatest at which a mechanism operates."""
        if self.crank_speed is not None:
            return one_rad_per_s(self.crank_speed, self.speed_unit)
        if isinstance(self.drive, Drive):
            return self.drive.greatest_speed
        return float(max(mechanism.operating_speeds, key=abs, default=0.0))

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        if self.drive is not None:
            return self.drive.speed_unit
        own = RAD_S if self.crank_speed is not None else mechanism.speed_unit
        return self.speed_unit or own

    def lumped_of(self, mechanism: Mechanism) -> tuple[int, ...] | None:
        """Number of elements of each link of a mechanism; None where masses stay distributed.

        Parameters
        ----------
        mechanism : Mechanism

        Returns
        -------
        tuple of int or None

        Raises
        ------
        InputError
            If there are not as many numbers as links.
        """
        links = mechanism.linkage.topology.link_names
        if self.lumped is None:
            return None
        if len(self.lumped) == 1:
            return tuple(self.lumped) * len(links)
        if len(self.lumped) != len(links):
            raise InputError(
                f"lumped: {len(self.lumped)} numbers of elements for {len(links)} links; give one "
                f"for all, or one for each of {', '.join(links)}"
            )
        return tuple(self.lumped)
