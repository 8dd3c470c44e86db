"""What rings after a crank has stopped: envelope of each link, and amplitude of each mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.analyses.response.measurements import deflections_of
from flexmech.analyses.response.plan import undamped, vibrating_engine
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine
from flexmech.time_domain import Trajectory

# A rest of fewer samples shows no vibration.
LEAST_SAMPLES = 8
# Modal coordinates are fitted over so many periods: fewer tell a constant from a wave badly, and of
# more the vibration has decayed.
_PERIODS = 2.0
# In kg^(1/2) m: of a mode that bends no link by as much as its length, for a linear reading.
_SMALL = 1e-6


def rests(request: ResponseRequest) -> bool:
    """Whether the run goes on for a while after the crank has stopped."""
    drive = request.drive
    after = request.duration - drive.law_time
    return not drive.speed and after >= LEAST_SAMPLES * request.sample_interval


@dataclass(frozen=True)
class StandingModes:
    """Undamped natural modes of the linkage where its crank has stopped.

    Parameters
    ----------
    frequency : ndarray, shape (m,)
        In Hz.
    weights : list of ndarray, shape (n_link, m)
        Mass times shape of each link of the engine: by them its coordinates become modal ones.
    bending : ndarray, shape (m, n_links)
        Deflection of each link at its probe by a unit of the modal coordinate.
    frame_weights : ndarray, shape (3, m)
        The same for the coordinates of a frame on springs; zero of one that stands.
    """

    frequency: FloatArray
    weights: list[FloatArray]
    bending: FloatArray
    frame_weights: FloatArray

    @classmethod
    def of(cls, engine: Engine, request: ResponseRequest) -> Self:
        """Modes at the crank angle at which a law stops.

        Parameters
        ----------
        engine : Engine
        request : ResponseRequest

        Returns
        -------
        StandingModes

        Raises
        ------
        ComputationError
            If the linkage has no equilibrium there, or does not vibrate about it.
        """
        free = undamped(vibrating_engine(engine))
        angle = request.drive.crank_angle(request.drive.law_time)
        system = free.linear_system(angle, prestress=free.prestress_at_rest, rotation_terms=False)
        modes = solve_modes(system, min(request.modes, system.size))
        shapes = [q[0] for q in system.unreduced_links(modes.vectors)]
        weights, of_frame = system.modal_weights(modes.vectors, free.links)
        small = deflections_of(free, [_SMALL * q.T for q in shapes])
        return cls(modes.frequency[0], weights, small / _SMALL, of_frame)

    def of_state(
        self,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
        at_rest: Sequence[FloatArray],
    ) -> FloatArray:
        """Amplitude of each mode in the deflection of each link, from its state at the stop.

        It tells how far the mode goes on to vibrate, without a run of the rest.

        Parameters
        ----------
        displacement, rate, at_rest : sequence of ndarray, shape (n_link,)
            Of each link of the engine, in its frame, in m and m/s; the last is where it comes to
            rest under its loads.

        Returns
        -------
        ndarray, shape (n_links, m)
            In m.
        """
        moved = [q - rest for q, rest in zip(displacement, at_rest, strict=True)]
        position, velocity = (
            np.sum([q @ weight for q, weight in zip(each, self.weights, strict=True)], axis=0)
            for each in (moved, rate)
        )
        found = np.hypot(position, velocity / (2 * np.pi * self.frequency))
        return np.asarray(np.abs(self.bending.T) * found)

    def amplitudes(self, trajectory: Trajectory, begin: float) -> FloatArray:
        """Amplitude of each mode in the deflection of each link after the stop.

        The modal coordinates of the run are projected by the mass, and a constant and a wave of the
        mode's frequency are fitted to each over two periods.

        Parameters
        ----------
        trajectory : Trajectory
            Of the engine.
        begin : float
            When the crank stops, in s.

        Returns
        -------
        ndarray, shape (n_links, m)
            In m; not a number where the rest is shorter than a period.
        """
        after = trajectory.time >= begin
        time = trajectory.time[after] - begin
        moved = zip(trajectory.displacement, self.weights, strict=True)
        modal = np.sum([q[after] @ weight for q, weight in moved], axis=0)
        if trajectory.frame is not None:
            modal = modal + trajectory.frame.displacement[after] @ self.frame_weights
        found = np.full(len(self.frequency), np.nan)
        for number, frequency in enumerate(self.frequency):
            if time[-1] * frequency < 1:
                continue
            some = time * frequency <= _PERIODS
            phase = 2 * np.pi * frequency * time[some]
            waves = np.column_stack([np.ones(len(phase)), np.cos(phase), np.sin(phase)])
            fitted = np.linalg.lstsq(waves, modal[some, number])[0]
            found[number] = np.hypot(*fitted[1:])
        return np.asarray(np.abs(self.bending.T) * found)


def envelope(values: FloatArray, width: int) -> FloatArray:
    """Half of what each history goes through within the samples that follow.

    It needs no state of rest about which the history vibrates. Where fewer samples follow, the last
    ones count.

    Parameters
    ----------
    values : ndarray, shape (N, k)
    width : int
        Samples.

    Returns
    -------
    ndarray, shape (N, k)

    Examples
    --------
    >>> time = np.linspace(0.0, 1.0, 1001)
    >>> decaying = 5.0 + np.exp(-time) * np.cos(2 * np.pi * 50 * time)
    >>> envelope(decaying[:, None], 21)[[0, 500], 0].round(1)
    array([1. , 0.6])
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    width = min(width, len(values))
    shift = -(width // 2)
    highest = maximum_filter1d(values, width, axis=0, origin=shift)
    lowest = minimum_filter1d(values, width, axis=0, origin=shift)
    whole_of = np.asarray(highest - lowest) / 2
    last = len(values) - width
    whole_of[last:] = whole_of[last]
    return whole_of
