"""What a run of the linkage is asked to be."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flexmech import choices
from flexmech.analyses.aspects.shaking import checked_point
from flexmech.analyses.crank_speeds import RAD_S, asked_speeds, in_unit, one_rad_per_s
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.crank_values import GREATEST
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment
from flexmech.linkages import ConstantSpeed, Drive, MotorDrive, MotorRun
from flexmech.linkages.drives.shaped import check_shapeable
from flexmech.mechanism import Mechanism, motor_run, settled_run
from flexmech.validation import (
    POSITIVE,
    Bounds,
    check_choice,
    check_count,
    check_flag,
    check_instance,
    check_number,
)

# More samples or steps than this are taken for a slip of the keyboard: a run would take hours.
MOST_SAMPLES = 2_000_000
MOST_STEPS = 50_000_000
NO_PERIODIC_START = (
    "a periodic start needs a prescribed shaft: under the torque that drives the rigid linkage a "
    "free one keeps no mean speed; choose start rigid or equilibrium"
)
FREE_SHAFT_GOES_ON = (
    "a shaper needs a shaft that stops with its law, and a free one turns on; choose shaft "
    "prescribed"
)


@dataclass(frozen=True)
class Shaping:
    """An input shaper that a law of motion is given, to be run beside the plain law.

    Parameters
    ----------
    kind : {"zv", "zvd", "ei"}
        See :func:`flexmech.input_shaper`.
    modes : tuple of int, optional
        Modes of the linkage where it stops, counted from 1, for which it is shaped, one after the
        other. Left out: those that ring by more than a tenth of what rings most after the plain
        law.
    frequencies : {"end", "path"}
        Natural frequencies for which it is shaped: where the crank stops, or those along its path.
    tolerated : float, optional
        Residual vibration of EI at the frequency itself, over that of the plain law; a twentieth
        if left out.

    Raises
    ------
    InputError
        If a value is impossible.

    Examples
    --------
    >>> flexmech.Shaping("zvd", modes=(1, 2), frequencies="path").words
    'ZVD shaper along the path'
    """

    kind: choices.ShaperName
    modes: tuple[int, ...] | None = None
    frequencies: choices.ShapedFor = "end"
    tolerated: float | None = None

    def __post_init__(self) -> None:
        check_choice(self.kind, choices.SHAPERS, "shaper")
        check_choice(self.frequencies, choices.SHAPED_FOR, "shaped_for")
        if self.tolerated is not None:
            check_number(self.tolerated, "tolerated vibration", "", Bounds(above=0.0, below=1.0))
            if self.kind != "ei":
                raise InputError(
                    f"a tolerated vibration belongs to the shaper ei, and not to {self.kind}; "
                    "leave it out, or take ei"
                )
        if self.modes is not None:
            if not self.modes or len(set(self.modes)) < len(self.modes):
                raise InputError("shaped modes must be one or more, each once, as 1,2")
            for mode in self.modes:
                check_count(mode, "shaped mode", most=choices.MOST_MODES)

    @property
    def words(self) -> str:
        """The shaper, and that it goes by the path."""
        along = " along the path" if self.frequencies == "path" else ""
        return f"{self.kind.upper()} shaper{along}"


@dataclass(frozen=True)
class ResponseRequest:
    """A run at constant crank speed, up to it, or by a law of motion.

    Parameters
    ----------
    speed : float, Drive or MotorDrive, optional
        Crank speed in ``speed_unit``, negative turns backwards; or a drive, which is in rad/s; or a
        motor, whose shaft is free. Left out: the mechanism's drive, or the greatest speed at which
        it operates.
    revolutions : float
        Turns at the final speed, after the run-up if there is one; under a motor all turns, where
        it states no time. A run by a law that stops, or by a table, lasts as long as these.
    samples : int
        Samples a turn at the final speed; of a law or table those of a move with its dwell.
    start : {"rigid", "equilibrium", "periodic"}
        Undeformed links with the rigid motion's velocities; links bent as the loads bend
        them quasi-statically (engines that simulate: at the nonlinear equilibrium); or on the
        periodic orbit of the linear equations, under a motor on its settled motion.
    step : float, optional
        Time step in s; chosen from ``modes`` and checked by halving where it is left out.
    integrator : {"trapezoidal", "generalized-alpha"}
        Integrator of engines that simulate; the others integrate by
        :func:`flexmech.solvers.linear_run`.
    prestress : {"none", "axial", "equilibrium"}
        Prestress of engines that do not simulate. ``none`` and ``axial`` are linear equations;
        ``equilibrium`` lets links stretch by the square of their slopes, or, where they are
        bent without load, is linear about the quasi-static equilibrium.
    modes : int
        The highest natural frequency of interest, counted from 1, sets the time step, the
        component modes and the spectra.
    shaft : {"prescribed", "free"}, optional
        Whether the shaft turns as prescribed; or carries, over time, the torque that drives the
        rigid linkage so, and answers with its own rotation. As the engines have it where it is
        left out.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which results speak of it. Left out: rad/s.
    run_up_time : float
        Duration in s of a smooth run-up to the speed, see :class:`flexmech.ConstantSpeed`.
    moment_point : tuple of float, optional
        About which the shaking moment is taken, in ground axes in m; the shaft's axis if left out.
    shaping : Shaping, optional
        An input shaper for a law that stops, whose run is told beside that of the plain law.
    check_mesh : bool
        Run again with twice the elements.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the mechanism runs in; dry by default.
    progress : callable, optional
        Called with a label, the steps done and the steps to do.

    Raises
    ------
    InputError
        If a value is impossible, a drive is given with a unit or a run-up beside it, or a periodic
        start is asked for with a run-up or a free shaft.

    Examples
    --------
    >>> request = flexmech.ResponseRequest(1500.0, 2, start="periodic", speed_unit="rpm")
    >>> round(request.duration, 3)
    0.08
    """

    speed: float | Drive | MotorDrive | None = None
    revolutions: float = 4.0
    samples: int = 720
    start: choices.Start = "rigid"
    step: float | None = None
    integrator: choices.Integrator = "trapezoidal"
    prestress: choices.Prestress = "equilibrium"
    modes: int = choices.MODES
    shaft: choices.ShaftChoice | None = field(default=None, repr=False)
    speed_unit: str | None = field(default=None, repr=False)
    run_up_time: float = field(default=0.0, repr=False)
    moment_point: tuple[float, float] | None = field(default=None, repr=False)
    shaping: Shaping | None = field(default=None, repr=False)
    check_mesh: bool = field(default=False, repr=False)
    environment: Environment | None = field(default=None, repr=False)
    progress: LabelledProgress | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "moment_point", checked_point(self.moment_point))
        by_drive = isinstance(self.speed, Drive | MotorDrive)
        if by_drive and (self.speed_unit or self.run_up_time):
            raise InputError(
                f"a {type(self.speed).__name__} is in rad/s and has its own run-up; leave "
                "speed_unit and run_up_time out, or give the speed as a number"
            )
        check_flag(self.check_mesh, "check_mesh")
        check_number(self.revolutions, "revolutions", "", POSITIVE)
        check_count(self.samples, "samples", 8, "a revolution")
        check_count(self.modes, "modes", most=choices.MOST_MODES)
        check_choice(self.start, choices.STARTS, "start")
        check_choice(self.integrator, choices.INTEGRATORS, "integrator")
        check_choice(self.prestress, choices.PRESTRESS_LEVELS, "prestress")
        if self.shaft is not None:
            check_choice(self.shaft, choices.SHAFTS, "shaft")
        if self.start == "periodic" and self.shaft == "free":
            raise InputError(NO_PERIODIC_START)
        if isinstance(self.speed, MotorDrive | MotorRun):
            self._check_motor()
        elif self.start == "periodic" and self.speed is not None and not self.drive.is_constant:
            raise InputError(
                "a periodic start needs a constant crank speed: leave out the run-up, or give the "
                "speed instead of a law"
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
                f"the run would take {samples:.3g} samples, more than {MOST_SAMPLES}; ask for "
                "fewer revolutions or samples"
            )
        if samples < 1:
            raise InputError(
                f"the run of {self.duration:g} s is shorter than the {self.sample_interval:g} s "
                "between two samples; ask for more revolutions or samples"
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
                f"a step of {step:g} s makes more than {MOST_STEPS} steps of a run of "
                f"{self.duration:g} s; choose a longer one, or leave it out"
            )

    @property
    def ends_with_a_law(self) -> bool:
        """Whether a law of motion tells when the run ends, and not the revolutions asked for."""
        return isinstance(self.speed, Drive) and not self.speed.turns_on

    @cached_property
    def drive(self) -> Drive:
        """Motion of the crank, in rad/s."""
        if isinstance(self.speed, Drive):
            return self.speed
        if self.speed is None:
            raise InputError("speed is left out; give one, as flexmech.ResponseRequest(20.0)")
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
