"""What a run of the linkage is asked to be."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from flexmech.analyses.aspects.shaking import checked_point
from flexmech.analyses.crank_speeds import RAD_S, asked_speeds, in_unit, one_rad_per_s
from flexmech.analyses.options import ResponseOptions
from flexmech.arrays import FloatArray
from flexmech.crank_values import GREATEST
from flexmech.errors import InputError
from flexmech.linkages import ConstantSpeed, Drive, MotorDrive, MotorRun
from flexmech.linkages.drives.shaped import Shaping, check_shapeable
from flexmech.mechanism import Mechanism, motor_run, settled_run
from flexmech.validation import (
    POSITIVE,
    check_instance,
    check_number,
)

# More samples or steps than this are taken for a slip of the keyboard: a run would take hours.
MOST_SAMPLES = 2_000_000
MOST_STEPS = 50_000_000
NO_PERIODIC_START = (
    "start: a periodic start needs a prescribed shaft: under the torque that drives the rigid "
    "linkage a free one keeps no mean speed; choose start rigid or equilibrium"
)
FREE_SHAFT_GOES_ON = (
    "shaping: a shaper needs a shaft that stops with its law, and a free one turns on; choose "
    "shaft prescribed"
)


class ResponseRequest(ResponseOptions):
    """A run at constant crank speed, up to it, or by a law of motion, checked.

    Parameters as for :class:`flexmech.analyses.options.ResponseOptions`.

    Raises
    ------
    InputError
        If a value is impossible, a drive is given with a unit or a run-up beside it, or a periodic
        start is asked for with a run-up or a free shaft.

    Examples
    --------
    >>> request = flexmech.analyses.ResponseRequest(1500.0, 2, start="periodic", speed_unit="rpm")
    >>> round(request.duration, 3)
    0.08
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        by_drive = isinstance(self.speed, Drive | MotorDrive)
        if by_drive and (self.speed_unit or self.run_up_time):
            raise InputError(
                f"a {type(self.speed).__name__} is in rad/s and has its own run-up; leave "
                "speed_unit and run_up_time out, or give the speed as a number"
            )
        check_number(self.revolutions, "revolutions", "", POSITIVE)
        if self.start == "periodic" and self.shaft == "free":
            raise InputError(NO_PERIODIC_START)
        if isinstance(self.speed, MotorDrive | MotorRun):
            self._check_motor()
        elif self.start == "periodic" and self.speed is not None and not self.drive.is_constant:
            raise InputError(
                "start, run_up_time: a periodic start needs a constant crank speed; leave out the "
                "run-up, or give the speed instead of a law"
            )
        if self.step is not None:
            check_number(self.step, "step", "s", POSITIVE)
        self._check_shaping()
        if self.speed is not None and not isinstance(self.speed, MotorDrive):
            self._check_duration()

    def _check_motor(self) -> None:
        if self.shaft == "prescribed":
            raise InputError(
                "shaft prescribed: a motor turns a free shaft; leave the shaft out, or give a "
                "speed in place of the motor"
            )

    def _check_shaping(self) -> None:
        """Refuse a shaper for what does not stop."""
        if self.shaping is None:
            return
        check_instance(self.shaping, Shaping, "shaping", "give a flexmech.Shaping")
        if self.shaft == "free" or isinstance(self.speed, MotorDrive | MotorRun):
            raise InputError(FREE_SHAFT_GOES_ON)
        if self.speed is not None:
            check_shapeable(self.drive)

    def _check_duration(self) -> None:
        samples = self.duration / self.sample_interval
        if samples > MOST_SAMPLES:
            raise InputError(
                f"revolutions, samples, run_up_time: the run would take {samples:.3g} samples, "
                f"more than {MOST_SAMPLES}; ask for fewer revolutions or samples"
            )
        if samples < 1:
            raise InputError(
                f"revolutions, samples: the run of {self.duration:g} s is shorter than the "
                f"{self.sample_interval:g} s between two samples; ask for more revolutions or "
                "samples"
            )
        if self.step is not None:
            self._check_length_of_step(self.step)

    def _check_length_of_step(self, step: float) -> None:
        if step > self.duration:
            raise InputError(
                f"step {step:g} s is longer than the run of {self.duration:g} s; choose a "
                "shorter one, or leave it out"
            )
        if self.duration / step > MOST_STEPS:
            raise InputError(
                f"step {step:g} s makes more than {MOST_STEPS} steps of a run of "
                f"{self.duration:g} s; choose a longer one, or leave it out"
            )

    @cached_property
    def drive(self) -> Drive:
        """Motion of the crank, in rad/s."""
        if isinstance(self.speed, Drive):
            return self.speed
        if self.speed is None:
            raise InputError("speed is left out; give one, as speed=20.0")
        if isinstance(self.speed, MotorDrive):
            raise InputError(
                "how a motor turns the crank follows from the linkage; take the request of a "
                "mechanism, as request.of(mechanism)"
            )
        return ConstantSpeed(one_rad_per_s(self.speed, self.speed_unit, "speed"), self.run_up_time)

    def of(self, mechanism: Mechanism) -> ResponseRequest:
        """The request with a mechanism's own drive or speed, where none is asked for.

        Of a motor with the motion that it gives the rigid linkage of the mechanism.
        """
        if isinstance(self.speed, MotorDrive):
            if self.start == "periodic":
                return replace(self, speed=settled_run(mechanism, self.speed, self.revolutions))
            return replace(self, speed=motor_run(mechanism, self.speed, self.revolutions))
        if self.speed is not None:
            return self
        if mechanism.drive is not None and self.speed_unit is None:
            return replace(self, speed=mechanism.drive).of(mechanism)
        speeds, shown = asked_speeds(None, self.speed_unit, mechanism, GREATEST)
        return replace(self, speed=float(in_unit(speeds, shown)[0]), speed_unit=shown)

    @property
    def shown_unit(self) -> str:
        """Unit in which results speak of crank speeds."""
        if isinstance(self.speed, (Drive, MotorDrive)):
            return self.speed.speed_unit
        return self.speed_unit or RAD_S

    @property
    def duration(self) -> float:
        """Law and turns together in s."""
        return self.drive.run_time(self.revolutions)

    @property
    def sample_interval(self) -> float:
        """Time between samples in s."""
        return self.drive.cycle_time / self.samples

    def sample_time(self, refinement: int = 1) -> FloatArray:
        """Times of the samples in s, with ``refinement`` intervals for each one; (N,)."""
        interval = self.sample_interval / refinement
        count = int(self.duration / interval + 1e-6) + 1
        return np.asarray(interval * np.arange(count), dtype=float)
