"""Request of kinematics."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike

import numpy as np

from flexmech.analyses.aspects.shaking import checked_point
from flexmech.analyses.crank_speeds import RAD_S, one_rad_per_s
from flexmech.analyses.options import EVERY_DEGREE, KinematicsOptions
from flexmech.analyses.requests import in_radians
from flexmech.errors import InputError, naming
from flexmech.linkages import Drive, MotorDrive
from flexmech.mechanism import Mechanism, motor_run
from flexmech.modelfile import CatalogueMotor, motor_catalogue
from flexmech.validation import check_count, check_number, checked_tuple

# Elements of a link whose mass is lumped: with so many the inertia force is the distributed one to
# six digits.
_MOST_LUMPS = 1000


class KinematicsRequest(KinematicsOptions):
    """Checked request of kinematics.

    Parameters as for :class:`flexmech.analyses.options.KinematicsOptions`.

    Raises
    ------
    InputError
        If a drive is given beside angles or acceleration; or these are no numbers, angles do
        not increase, or a number of elements is below one or beyond 1000.

    Examples
    --------
    >>> KinematicsRequest(20.0, lumped=(1, 4, 4)).crank_angles.shape
    (361,)
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        angles = in_radians("crank_angles", self.crank_angles)
        if angles.ndim != 1 or not angles.size or np.any(np.diff(angles) <= 0):
            raise InputError(
                f"crank_angles must be one or more in increasing order, got shape {angles.shape}"
            )
        object.__setattr__(self, "crank_angles", angles)
        check_number(self.crank_acceleration, "crank_acceleration", "rad/s^2")
        if isinstance(self.speed, Drive | MotorDrive):
            self._check_drive(self.speed)
        elif self.speed is not None:
            one_rad_per_s(self.speed, self.speed_unit, "speed")
        if self.lumped is not None:
            remedy = "give the elements of each link, as (1, 4, 4)"
            counts = checked_tuple(self.lumped, object, "lumped", remedy)
            for count in counts:
                check_count(count, "lumped: each number of elements")
                if count > _MOST_LUMPS:
                    raise InputError(
                        f"lumped: {count} elements of a link are beyond {_MOST_LUMPS}; leave "
                        "--lumped out for distributed mass, their limit"
                    )
            object.__setattr__(self, "lumped", counts)
        if self.motors is not None:
            self._check_motors()

    def _check_motors(self) -> None:
        """Read a catalogue that is named; refuse one where nothing runs by itself."""
        motors = self.motors or ()
        if isinstance(motors, str | PathLike):
            with naming("motors"):
                motors = motor_catalogue(motors)
        remedy = "give what flexmech.modelfile.motor_catalogue returns, or the path of a CSV file"
        motors = checked_tuple(motors, CatalogueMotor, "motors", remedy)
        if not motors:
            raise InputError(f"motors: there is none; {remedy}")
        object.__setattr__(self, "motors", motors)
        if self.crank_acceleration or len(self.crank_angles) == 1:
            raise InputError(
                "motors: a motor is judged over one run; leave crank_acceleration out, and ask for "
                "two crank angles or more"
            )

    def _check_drive(self, drive: Drive | MotorDrive) -> None:
        usual = EVERY_DEGREE()
        own = self.crank_angles.shape == usual.shape and np.allclose(self.crank_angles, usual)
        of_its_own = self.crank_acceleration or not own
        if self.speed_unit or (of_its_own and not drive.is_constant):
            raise InputError(
                "speed: a law of motion has its own angles, acceleration and unit; leave these "
                "out, or give a speed in place of the law"
            )

    @property
    def catalogue(self) -> tuple[CatalogueMotor, ...]:
        """Motors to choose from, which were read."""
        motors = self.motors or ()
        assert isinstance(motors, tuple)
        return motors

    @property
    def drive(self) -> Drive | MotorDrive | None:
        """The law of motion or the motor; None where a speed is asked for."""
        return self.speed if isinstance(self.speed, Drive | MotorDrive) else None

    @property
    def law(self) -> Drive | None:
        """The drive, where it is more than a constant speed."""
        return self.speed if isinstance(self.speed, Drive) and not self.speed.is_constant else None

    def of(self, mechanism: Mechanism) -> KinematicsRequest:
        """The request with the mechanism's own drive where no speed is asked for.

        A motor becomes the motion that it gives the linkage of the mechanism.
        """
        if self.speed is None and self.speed_unit is None and mechanism.drive is not None:
            return replace(self, speed=mechanism.drive).of(mechanism)
        if isinstance(self.speed, MotorDrive):
            return replace(self, speed=motor_run(mechanism, self.speed))
        return self

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: as asked for, or the greatest at which a mechanism operates."""
        if isinstance(self.speed, Drive):
            return self.speed.greatest_speed
        if self.speed is None or isinstance(self.speed, MotorDrive):
            return float(max(mechanism.operating_speeds, key=abs, default=0.0))
        return one_rad_per_s(self.speed, self.speed_unit, "speed")

    def shown_unit(self, mechanism: Mechanism) -> str:
        """Unit in which the result for a mechanism speaks of crank speeds."""
        if self.drive is not None:
            return self.drive.speed_unit
        own = RAD_S if self.speed is not None else mechanism.speed_unit
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
