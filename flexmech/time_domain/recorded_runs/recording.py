"""From blocks of time steps to evenly sampled histories and an energy balance.

Both engines hand over their steps block by block, so that the memory of a long run is that
of its samples. Energies are summed over every step; histories are kept at the samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.integrate

from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems import (
    ON_A_STEP,
    LowPass,
    hermite_interpolation,
    linear_interpolation,
    parabolic_work,
    sample_intervals,
)
from flexmech.dynamical_systems.lobatto import WEIGHTS
from flexmech.time_domain.recorded_runs.states import (
    EnergyHistory,
    FrameMotion,
    ShaftMotion,
    Trajectory,
)


@dataclass(frozen=True)
class StepBlock:
    """Consecutive time steps; the first one repeats the last step of the block before.

    Parameters
    ----------
    time : ndarray, shape (m,)
        In s.
    crank_speed : ndarray, shape (m,)
        Of the shaft as it turns, also where it is free.
    displacement, rate : list of ndarray, shape (m, n_link)
        Each link's coordinates in the frame of its rigid motion, less those of the
        undeformed link, and their time derivatives in that frame.
    joint_force : ndarray, shape (m, n_joints, 2)
        On the held or following link, ground axes, in the order of the topology's joints.
    driving_torque : ndarray, shape (m,)
        Of the shaft on the clamped link about the shaft's axis.
    kinetic_energy, strain_energy, gravity_energy : ndarray, shape (m,)
    dissipation_power : ndarray, shape (m,)
        What damping takes out of the links, positive.
    prestress_power : ndarray, shape (m,)
        What a prescribed, changing prestress puts into a linear model; zero in a
        nonlinear one.
    shaft : ShaftMotion, optional
        Of a shaft that is free. Its inertia is part of the kinetic energy, and the frames
        are those of the rigid linkage at the angle that it has.
    frame : FrameMotion, optional
        Of a frame on springs. Its energies are part of those above, and the frames of the links
        are those of the rigid motion on a frame that stands.
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
            [np.concatenate(own) for own in zip(*parts, strict=True)]
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
        cubic = [hermite_interpolation(block.time, *own, before, fraction) for own in moving]
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
        Of the samples: increasing, inside the run.
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
        Of the filter's integral: see :class:`LowPass`.
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
