"""Joint forces and driving torque of a run: samples and peaks of what a band lets through."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.dynamical_systems import ON_A_STEP, LowPass, linear_interpolation, sample_intervals
from flexmech.types import FloatArray


class ForceRecord:
    """Takes joint forces and torque step by step; keeps their samples and their peaks.

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
        self._sample_time = sample_time
        self._step = step
        self._filter = None if band is None else LowPass(band, step, weights)
        # Later steps are there for the filter alone.
        self._steps = max(1, int(np.ceil(sample_time[-1] / step - ON_A_STEP)))
        self._samples: list[FloatArray] = []
        self._sampled = 0
        self._taken = 0
        self._last: FloatArray | None = None
        self._peak: FloatArray = np.zeros(1)

    @property
    def steps(self) -> int:
        """Time steps of a run from zero until all that is kept is known."""
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

    def finish(self) -> None:
        """There are no more steps."""
        if self._filter is not None:
            self._take(self._filter.finish())

    @property
    def joint_force(self) -> FloatArray:
        """At the samples, (N, n_joints, 2)."""
        values = np.concatenate(self._samples)[:, :-1]
        return values.reshape(len(values), -1, 2)

    @property
    def driving_torque(self) -> FloatArray:
        """At the samples, (N,)."""
        return np.concatenate(self._samples)[:, -1]

    @property
    def peak_joint_force(self) -> FloatArray:
        """Greatest size at any step until the last sample, (n_joints,)."""
        return self._peak[:-1]

    @property
    def peak_driving_torque(self) -> float:
        """Greatest size at any step until the last sample."""
        return float(self._peak[-1])

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
        reach = time[-1] + ON_A_STEP * self._step
        stop = int(np.searchsorted(self._sample_time, reach, side="right"))
        at = self._sample_time[self._sampled : stop]
        self._sampled = stop
        self._samples.append(linear_interpolation(values, *sample_intervals(time, at)))
