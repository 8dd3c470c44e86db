"""What a run in time starts from, and what is recorded of it: histories and an energy balance.

Both engines hand over their steps block by block, so that the memory of a long run is that
of its samples. Energies are summed over every step; histories are kept at the samples.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Self

import numpy as np
import scipy.integrate

from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import LINK_DIRECTIONS, LinkDirection
from flexmech.dynamical_systems import (
    ON_A_STEP,
    HalfSinePulse,
    LowPass,
    hermite_interpolation,
    linear_interpolation,
    parabolic_work,
    sample_intervals,
)
from flexmech.dynamical_systems.lobatto import WEIGHTS
from flexmech.errors import ComputationError
from flexmech.linkages import Drive
from flexmech.mechanics import LinkModel, LinkPoint
from flexmech.mechanism import Mechanism
from flexmech.validation import check_choice, check_instance

# A shaft that is ahead or behind by more than this, in rad, no longer turns the linkage through
# the positions for which its torque is made.
RUN_AWAY = np.pi / 2
# Positions whose inverse dynamics are in memory at a time. Memory alone: some kB each.
BATCH = 4096


@dataclass(frozen=True)
class FrameMotion:
    """Motion of a frame on springs at m instants.

    Parameters
    ----------
    displacement : ndarray, shape (m, 3)
        Displacement of its centre of mass along x and y in m, and its rotation in rad.
    rate : ndarray, shape (m, 3)
        Its time derivative.
    """

    displacement: FloatArray
    rate: FloatArray


@dataclass(frozen=True)
class LinkState:
    """Elastic state of all links at an instant, in the frames of their rigid motion.

    Parameters
    ----------
    displacement, rate : list of ndarray, shape (n_link,)
        Each link's coordinates less those of the undeformed link, and their time
        derivatives in that frame.
    frame : FrameMotion, optional
        Frame of a frame on springs, arrays of shape (1, 3); it stands as it is drawn if left out.
    """

    displacement: list[FloatArray]
    rate: list[FloatArray]
    frame: FrameMotion | None = None

    @property
    def moved(self) -> FrameMotion:
        """Motion of the frame at the instant."""
        return self.frame or FrameMotion(np.zeros((1, 3)), np.zeros((1, 3)))

    @classmethod
    def rigid(cls, links: Sequence[LinkModel]) -> Self:
        """Undeformed links that move with the velocities of the rigid motion."""
        return cls([np.zeros(link.size) for link in links], [np.zeros(link.size) for link in links])


@dataclass(frozen=True)
class Impact:
    """A pulse on a point of a link, in the axes of the link's rigid frame.

    Parameters
    ----------
    point : LinkPoint
    direction : {"transverse", "axial"}
        Across the link's frame or along it; the force turns with the frame.
    pulse : HalfSinePulse

    Raises
    ------
    InputError
        If one is no such thing.
    """

    point: LinkPoint
    direction: LinkDirection
    pulse: HalfSinePulse

    def __post_init__(self) -> None:
        check_instance(self.point, LinkPoint, "point of an impact", "give a flexmech.LinkPoint")
        check_choice(self.direction, LINK_DIRECTIONS, "direction of an impact")
        check_instance(self.pulse, HalfSinePulse, "pulse of an impact", "give a HalfSinePulse")


@dataclass(frozen=True)
class ShaftMotion:
    """Rotation of a free shaft against its prescribed angle at m instants.

    Parameters
    ----------
    rotation : ndarray, shape (m,)
        In rad, positive ahead.
    rate : ndarray, shape (m,)
        Its time derivative in rad/s: by how much the crank speed is off the prescribed one.
    """

    rotation: FloatArray
    rate: FloatArray

    def refuse_runaway(self, drive: Drive, time: FloatArray) -> None:
        """Refuse a shaft that has left its prescribed angle.

        Parameters
        ----------
        drive : Drive
        time : ndarray, shape (m,)
            Time of the instants, in s.

        Raises
        ------
        ComputationError
            Names the time and the crank angle.
        """
        away = ~(np.abs(self.rotation) <= RUN_AWAY)
        if not away.any():
            return
        first = int(np.argmax(away))
        at = float(time[first])
        side = "behind" if self.rotation[first] < 0 else "ahead of"
        raise ComputationError(
            f"the free shaft runs away: at time {at:.6g} s it is more than "
            f"{np.degrees(RUN_AWAY):.0f} deg {side} its prescribed crank angle, "
            f"{np.degrees(float(drive.crank_angle(at))):.6g} deg, and the torque that drives the "
            "rigid linkage at the prescribed motion no longer fits where it stands; run fewer "
            "revolutions, give the shaft more inertia, lower the crank speed, or use shaft "
            "'prescribed'"
        )


def rigid_torque(mechanism: Mechanism, drive: Drive, time: FloatArray) -> FloatArray:
    """Torque on the shaft for the prescribed motion of the rigid linkage and the shaft.

    Inverse dynamics under everything that acts on the linkage, and the shaft's own inertia times
    its acceleration in a run-up.

    Parameters
    ----------
    mechanism : Mechanism
    drive : Drive
    time : ndarray, shape (m,)
        In s.

    Returns
    -------
    ndarray, shape (m,)
        In N m.

    Raises
    ------
    InputError
        If the connections do not determine the forces, or a spring has no direction.
    """
    torque = np.empty(len(time))
    for first in range(0, len(time), BATCH):
        batch = time[first : first + BATCH]
        motion = drive.motion(mechanism.linkage, batch)
        torque[first : first + BATCH] = mechanism.inverse_dynamics(motion, batch).driving_torque
    return torque + mechanism.shaft_inertia * drive.crank_acceleration(time)


@dataclass(frozen=True)
class EnergyHistory:
    """Energies at the samples in J, each of shape (N,).

    Parameters
    ----------
    kinetic, strain, gravity : ndarray, shape (N,)
    dissipated, drive_work, prestress_work : ndarray, shape (N,)
        Since the start of the run.
    """

    kinetic: FloatArray
    strain: FloatArray
    gravity: FloatArray
    dissipated: FloatArray
    drive_work: FloatArray
    prestress_work: FloatArray

    @property
    def imbalance(self) -> FloatArray:
        """Energy that nothing accounts for, (N,)."""
        stored = self.kinetic + self.strain + self.gravity
        work = self.drive_work - self.dissipated + self.prestress_work
        return np.asarray(stored - stored[0] - work)


# What a run has at each sample.
HISTORIES = (
    "time",
    "displacement",
    "rate",
    "joint_force",
    "driving_torque",
    "energy",
    "shaft",
    "frame",
)


@dataclass(frozen=True)
class Trajectory:
    """A run of the linkage at N samples.

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    displacement, rate : list of ndarray, shape (N, n_link)
        As in :class:`flexmech.mechanics.running.StepBlock`.
    joint_force : ndarray, shape (N, n_joints, 2)
    driving_torque : ndarray, shape (N,)
        Both as far as the band of the recorder lets them through.
    peak_joint_force : ndarray, shape (n_joints,)
    peak_driving_torque : float
        Greatest size of these at any step.
    energy : EnergyHistory
    energy_error : float
        Greatest ``|work of drive and changing prestress - change of kinetic, strain and gravity
        energy - dissipated|`` over all steps, relative to the peak kinetic energy.
    step : float
        Time step in s.
    shaft : ShaftMotion, optional
        Shaft of a shaft that is free.
    frame : FrameMotion, optional
        Frame of a frame on springs.
    """

    time: FloatArray
    displacement: list[FloatArray]
    rate: list[FloatArray]
    joint_force: FloatArray
    driving_torque: FloatArray
    peak_joint_force: FloatArray
    peak_driving_torque: float
    energy: EnergyHistory
    energy_error: float
    step: float
    shaft: ShaftMotion | None = None
    frame: FrameMotion | None = None

    def __getitem__(self, where: slice) -> Trajectory:
        """The same run at some of the samples."""
        taken = {name: _changed(lambda x: x[where], getattr(self, name)) for name in HISTORIES}
        return replace(self, **taken)

    def extrapolated(self, coarser: Trajectory, order: int) -> Trajectory:
        """Limit of vanishing steps, by a run with greater ones (Richardson).

        Parameters
        ----------
        coarser : Trajectory
            At the same samples.
        order : int
            Order of the method's error.

        Returns
        -------
        Trajectory
            With this run's step. Its energies balance as they do at the samples.
        """
        gain = 1 / ((coarser.step / self.step) ** order - 1)
        limit: Trajectory = _changed(lambda x, y: x + gain * (x - y), self, coarser)
        energy = limit.energy
        error = float(np.abs(energy.imbalance).max() / energy.kinetic.max())
        return replace(limit, energy_error=error, step=self.step)


def _changed(function: Callable[..., Any], *values: Any) -> Any:
    """What a function makes of every array and number of like records and lists; None of none."""
    first: Any = values[0]
    if isinstance(first, list):
        return [_changed(function, *items) for items in zip(*values, strict=True)]
    if is_dataclass(first) and not isinstance(first, type):
        names = [field.name for field in fields(first)]
        changed = (_changed(function, *(getattr(x, name) for x in values)) for name in names)
        return type(first)(*changed)
    return None if first is None else function(*values)


@dataclass(frozen=True)
class StepBlock:
    """Consecutive time steps; the first one repeats the last step of the block before.

    Parameters
    ----------
    time : ndarray, shape (m,)
        In s.
    crank_speed : ndarray, shape (m,)
        Crank speed of the shaft as it turns, also where it is free.
    displacement, rate : list of ndarray, shape (m, n_link)
        Each link's coordinates in the frame of its rigid motion, less those of the
        undeformed link, and their time derivatives in that frame.
    joint_force : ndarray, shape (m, n_joints, 2)
        On the held or following link, ground axes, in the order of the topology's joints.
    driving_torque : ndarray, shape (m,)
        Torque of the shaft on the clamped link about the shaft's axis.
    kinetic_energy, strain_energy, gravity_energy : ndarray, shape (m,)
    dissipation_power : ndarray, shape (m,)
        What damping takes out of the links, positive.
    prestress_power : ndarray, shape (m,)
        What a prescribed, changing prestress puts into a linear model; zero in a
        nonlinear one.
    shaft : ShaftMotion, optional
        Shaft of a shaft that is free. Its inertia is part of the kinetic energy, and the frames
        are those of the rigid linkage at the angle that it has.
    frame : FrameMotion, optional
        Frame of a frame on springs. Its energies are part of those above, and the frames of the
        links are those of the rigid motion on a frame that stands.
    """

    time: FloatArray
    crank_speed: FloatArray
    displacement: list[FloatArray]
    rate: list[FloatArray]
    joint_force: FloatArray
    driving_torque: FloatArray
    kinetic_energy: FloatArray
    strain_energy: FloatArray
    gravity_energy: FloatArray
    dissipation_power: FloatArray
    prestress_power: FloatArray
    shaft: ShaftMotion | None = None
    frame: FrameMotion | None = None


class Recorder:
    """Collects the samples of a run from blocks of time steps.

    Parameters
    ----------
    sample_time : ndarray, shape (N,)
        Increasing, inside the run.
    step : float
        Time step in s.
    band : float, optional
        Frequency in Hz up to which joint forces and torque are kept; the work of the torque
        counts all frequencies.
    stride : int
        Steps of a method's own step: 1 of the trapezoidal rule, 2 of Lobatto's. Powers are
        integrated as the method integrates, and energies balance at the ends of its steps.
    """

    def __init__(
        self, sample_time: FloatArray, step: float, band: float | None = None, stride: int = 1
    ) -> None:
        self.step, self._samples = step, SampleTimes(sample_time, step)
        self._stride = stride
        self._forces = ForceRecord(sample_time, step, band, (1.0,) if stride == 1 else WEIGHTS)
        # Places and rates of links, of a free shaft and of a frame on springs; energies.
        self._parts: list[tuple[list[FloatArray], list[FloatArray], list[FloatArray]]] = []
        self._has_shaft = self._has_frame = False
        self._work = np.zeros(3)  # dissipated, drive, prestress
        self._balance_start: float | None = None
        self._worst = 0.0
        self._peak = 0.0

    @property
    def steps(self) -> int:
        """Time steps of a run from zero until all that is kept is known.

        A filter of the forces needs some beyond the last sample.
        """
        return self._forces.steps

    def add(self, block: StepBlock) -> None:
        """Add the next steps."""
        powers = np.stack(
            [
                block.dissipation_power,
                block.driving_torque * block.crank_speed,
                block.prestress_power,
            ]
        )
        if self._stride == 1:
            done = scipy.integrate.cumulative_trapezoid(powers, block.time, initial=0.0)
        else:
            done = parabolic_work(self.step, powers)
        work = self._work[:, None] + done
        self._work = work[:, -1]
        new = slice(0 if self._balance_start is None else 1, None)
        self._forces.add(block.joint_force[new], block.driving_torque[new])
        stored = block.kinetic_energy + block.strain_energy + block.gravity_energy
        if self._balance_start is None:
            self._balance_start = float(stored[0])
        gap = stored - self._balance_start - work[1] + work[0] - work[2]
        self._worst = max(self._worst, float(np.abs(gap[:: self._stride]).max()))
        self._peak = max(self._peak, float(block.kinetic_energy.max()))
        self._sample(block, work)

    def finish(self) -> Trajectory:
        """The samples of all blocks."""
        places, rates, energies = (
            [np.concatenate(blocks) for blocks in zip(*parts, strict=True)]
            for parts in zip(*self._parts, strict=True)
        )
        frame = FrameMotion(places.pop(), rates.pop()) if self._has_frame else None
        shaft = None
        if self._has_shaft:
            shaft = ShaftMotion(places.pop()[:, 0], rates.pop()[:, 0])
        joint_force, driving_torque, peaks = self._forces.finish()
        return Trajectory(
            time=self._samples.time[: self._samples.taken],
            displacement=places,
            rate=rates,
            joint_force=joint_force,
            driving_torque=driving_torque,
            peak_joint_force=peaks[:-1],
            peak_driving_torque=float(peaks[-1]),
            energy=EnergyHistory(*energies[0].T),
            energy_error=self._worst / self._peak,
            step=self.step,
            shaft=shaft,
            frame=frame,
        )

    def _sample(self, block: StepBlock, work: FloatArray) -> None:
        before, fraction = self._samples.within(block.time)
        moving = list(zip(block.displacement, block.rate, strict=True))
        self._has_shaft, self._has_frame = block.shaft is not None, block.frame is not None
        if block.shaft is not None:
            moving.append((block.shaft.rotation[:, None], block.shaft.rate[:, None]))
        if block.frame is not None:
            moving.append((block.frame.displacement, block.frame.rate))
        cubic = [hermite_interpolation(block.time, *ends, before, fraction) for ends in moving]
        stored = block.kinetic_energy, block.strain_energy, block.gravity_energy
        energy = np.stack([*stored, *work], axis=1)
        self._parts.append(
            (
                [value for value, _ in cubic],
                [slope for _, slope in cubic],
                [linear_interpolation(energy, before, fraction)],
            )
        )


class SampleTimes:
    """Samples of a run, taken as its steps come.

    Parameters
    ----------
    time : ndarray, shape (N,)
        Time of the samples: increasing, inside the run.
    step : float
        Time step in s.

    Attributes
    ----------
    taken : int
        Number of samples until now.
    """

    def __init__(self, time: FloatArray, step: float) -> None:
        self.time, self._slack, self.taken = time, ON_A_STEP * step, 0

    def within(self, time: FloatArray) -> tuple[IntArray, FloatArray]:
        """The next samples up to the last of times of steps, as :func:`sample_intervals`."""
        stop = int(np.searchsorted(self.time, time[-1] + self._slack, side="right"))
        at, self.taken = self.time[self.taken : stop], stop
        return sample_intervals(time, at)


class ForceRecord:
    """Collects samples and peaks of joint forces and torque, step by step.

    Parameters
    ----------
    sample_time : ndarray, shape (N,)
        Increasing, inside the run.
    step : float
        Time step in s.
    band : float, optional
        Frequency in Hz up to which forces count; all frequencies where it is left out.
    weights : sequence of float
        Weights of the filter's integral: see :class:`LowPass`.
    """

    def __init__(
        self,
        sample_time: FloatArray,
        step: float,
        band: float | None,
        weights: Sequence[float] = (1.0,),
    ) -> None:
        self._times, self._step = SampleTimes(sample_time, step), step
        self._filter = None if band is None else LowPass(band, step, weights)
        # Later steps are there for the filter alone.
        self._steps = max(1, int(np.ceil(sample_time[-1] / step - ON_A_STEP)))
        self._samples: list[FloatArray] = []
        self._taken = 0
        self._last: FloatArray | None = None
        self._peak: FloatArray = np.zeros(1)

    @property
    def steps(self) -> int:
        """Number of time steps of a run until all samples are known."""
        return self._steps + (0 if self._filter is None else self._filter.half)

    def add(self, joint_force: FloatArray, driving_torque: FloatArray) -> None:
        """Take the next steps.

        Parameters
        ----------
        joint_force : ndarray, shape (m, n_joints, 2)
        driving_torque : ndarray, shape (m,)
        """
        values = np.concatenate(
            [joint_force.reshape(len(joint_force), -1), driving_torque[:, None]], axis=1
        )
        self._take(values if self._filter is None else self._filter.add(values))

    def finish(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """End the record after the last step.

        Returns
        -------
        ndarray, shape (N, n_joints, 2)
            Joint forces at the samples in N.
        ndarray, shape (N,)
            Driving torque at the samples in N m.
        ndarray, shape (n_joints + 1,)
            Greatest sizes of these at any step until the last sample.
        """
        if self._filter is not None:
            self._take(self._filter.finish())
        values = np.concatenate(self._samples)
        return values[:, :-1].reshape(len(values), -1, 2), values[:, -1], self._peak

    def _take(self, values: FloatArray) -> None:
        before = 0 if self._last is None else self._taken + 1
        values = values[: max(0, self._steps + 1 - before)]
        if not len(values):
            return
        size = np.concatenate(
            [
                np.hypot(values[:, :-1:2], values[:, 1:-1:2]).max(axis=0),
                np.abs(values[:, -1:]).max(axis=0),
            ]
        )
        self._peak = np.maximum(self._peak, size)
        if self._last is not None:
            values = np.concatenate([self._last, values])
        time = self._step * np.arange(self._taken, self._taken + len(values), dtype=float)
        self._taken += len(values) - 1
        self._last = values[-1:]
        if len(values) < 2:
            return
        self._samples.append(linear_interpolation(values, *self._times.within(time)))
