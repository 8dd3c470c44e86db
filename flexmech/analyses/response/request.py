"""What a run of the linkage is asked to be."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech import choices
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import CrankDrive
from flexmech.validation import POSITIVE, check_choice, check_count, check_instance, check_number

# More samples or steps than this are taken for a slip of the keyboard: a run would take hours.
MOST_SAMPLES = 2_000_000
MOST_STEPS = 50_000_000
NO_PERIODIC_START = (
    "a periodic start needs a prescribed shaft: under the torque that drives the rigid linkage a "
    "free one keeps no mean speed; choose start rigid or equilibrium"
)


@dataclass(frozen=True)
class ResponseRequest:
    """A run at constant crank speed, or up to it.

    Parameters
    ----------
    drive : CrankDrive
    revolutions : float
        Turns at the final speed, after the run-up if there is one.
    samples : int
        Samples a turn at the final speed.
    start : {"rigid", "equilibrium", "periodic"}
        Undeformed links with the rigid motion's velocities; links bent as the loads bend
        them quasi-statically (engines that simulate: at the nonlinear equilibrium); or on the
        periodic orbit of the linear equations.
    step : float, optional
        Time step in s; chosen from ``modes`` and checked by halving where it is left out.
    integrator : {"trapezoidal", "generalized-alpha"}
        Of engines that simulate; the others integrate by
        :func:`flexmech.time_domain.linear_run`.
    prestress : {"none", "axial", "equilibrium"}
        Of engines that do not simulate. ``none`` and ``axial`` are linear equations;
        ``equilibrium`` lets links stretch by the square of their slopes, or, where they are
        bent without load, is linear about the quasi-static equilibrium.
    modes : int
        The highest natural frequency of interest, counted from 1, sets the time step, the
        component modes and the spectra.
    shaft : {"prescribed", "free"}, optional
        Whether the shaft turns as prescribed; or carries, over time, the torque that drives the
        rigid linkage so, and answers with its own rotation. As the engines have it where it is
        left out.
    speed_unit : str
        In which results speak of crank speeds, such as ``"rpm"``.

    Raises
    ------
    InputError
        If a value is impossible, or a periodic start is asked for with a run-up or a free shaft.

    Examples
    --------
    >>> drive = flexmech.CrankDrive(20.0)
    >>> request = flexmech.ResponseRequest(drive, revolutions=2, start="periodic")
    >>> round(request.duration, 3)
    0.628
    """

    drive: CrankDrive
    revolutions: float = 4.0
    samples: int = 720
    start: choices.Start = "rigid"
    step: float | None = None
    integrator: choices.Integrator = "trapezoidal"
    prestress: choices.Prestress = "equilibrium"
    modes: int = choices.MODES
    shaft: choices.ShaftChoice | None = field(default=None, repr=False)
    speed_unit: str = field(default="rad/s", repr=False)

    def __post_init__(self) -> None:
        check_instance(
            self.drive, CrankDrive, "drive", "write flexmech.CrankDrive(20.0) for 20 rad/s"
        )
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
        if self.start == "periodic" and not self.drive.is_constant:
            raise InputError("a periodic start needs a constant crank speed: leave out the run-up")
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
            check_number(self.step, "step", "s", POSITIVE)
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
    def duration(self) -> float:
        """Run-up and turns together in s."""
        return self.drive.run_up_time + self.revolutions * self.drive.revolution_time

    @property
    def sample_interval(self) -> float:
        """Time between samples in s."""
        return self.drive.revolution_time / self.samples

    def sample_time(self, refinement: int = 1) -> FloatArray:
        """Times of the samples in s, with ``refinement`` intervals for each one; (N,)."""
        interval = self.sample_interval / refinement
        count = int(self.duration / interval + 1e-6) + 1
        return np.asarray(interval * np.arange(count), dtype=float)
