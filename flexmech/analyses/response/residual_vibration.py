"""What rings after a crank has stopped: the envelope of each link's deflection.

Natural modes of the linkage where its crank has stopped, and how far each of them rings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.plan import undamped, vibrating_engine
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine
from flexmech.mechanics.running import LinkState, Trajectory
from flexmech.solvers.eigenproblem import solve_modes

# A rest of fewer samples shows no vibration.
LEAST_SAMPLES = 8
# Places in a period of the highest mode at which an envelope is sought: the greatest of so many
# values of a wave is at most 0.2 % below its amplitude.
_PLACES = 48


def rests(request: ResponseRequest) -> bool:
    """Whether the run goes on for a while after the crank has stopped."""
    drive = request.drive
    after = request.duration - drive.law_time
    return not drive.speed and after >= LEAST_SAMPLES * request.sample_interval


def edges(
    at: FloatArray,
    time: FloatArray,
    values: FloatArray,
    waves: NDArray[np.complex128],
    decay: FloatArray,
    angular_frequency: FloatArray,
    period: float,
) -> tuple[FloatArray, FloatArray]:
    """Least and greatest value of a history within a period that follows, were it not to decay.

    What is known of a history is the sum of its decaying waves, each of which keeps the amplitude
    that it has at the time; what else the history holds is taken as it is. A decaying wave about a
    state of rest thus stays between the state plus and minus its amplitude, and touches both. Where
    less than a period follows, the last period counts.

    Parameters
    ----------
    at : ndarray, shape (n,)
        Where the edges are wanted, in s; between the first and the last time.
    time : ndarray, shape (N,)
        Of the history in s, from zero on.
    values : ndarray, shape (N,)
    waves : ndarray of complex, shape (m,)
        Amplitudes at time zero; not a number of a wave that is not known.
    decay, angular_frequency : ndarray, shape (m,)
        In 1/s and rad/s.
    period : float
        Of the slowest wave, in s; of a shorter history all counts.

    Returns
    -------
    lower, upper : ndarray, shape (n,)

    Examples
    --------
    >>> time = np.linspace(0.0, 1.0, 1001)
    >>> history = 5.0 + np.exp((2j * np.pi * 50 - 2.0) * time).real
    >>> wave = np.array([1.0 + 0j]), np.array([2.0]), np.array([2 * np.pi * 50])
    >>> lower, upper = edges(time[[0, 500]], time, history, *wave, 0.02)
    >>> ((upper - lower) / 2).round(3), ((upper + lower) / 2).round(3)
    (array([1.   , 0.368]), array([5., 5.]))
    """
    known = np.isfinite(waves)
    amplitude = np.where(known, waves, 0.0)
    turning = np.exp(np.multiply.outer(time, 1j * angular_frequency - decay))
    besides = values - (turning @ amplitude).real
    period = min(period, float(time[-1]))
    begin = np.minimum(at, time[-1] - period)
    rates = np.multiply.outer(begin, 1j * angular_frequency) - np.multiply.outer(at, decay)
    kept = amplitude * np.exp(rates)
    cycles = period * float(angular_frequency[known].max(initial=0.0)) / (2 * np.pi)
    lower = upper = np.interp(at, time, values)
    for shift in np.linspace(0.0, period, max(_PLACES, int(np.ceil(_PLACES * cycles))) + 1):
        wave = (kept @ np.exp(1j * angular_frequency * shift)).real
        value = np.interp(begin + shift, time, besides) + wave
        lower, upper = np.minimum(lower, value), np.maximum(upper, value)
    return lower, upper


# Modal coordinates are fitted over so many periods: fewer tell a constant from a wave badly, and of
# more a phase is lost where the frequency of a run is not quite that of its modes.
_PERIODS = 2.0
# In kg^(1/2) m: of a mode that bends no link by as much as its length, for a linear reading.
_SMALL = 1e-6


@dataclass(frozen=True)
class StandingModes:
    """Natural modes of the linkage where its crank has stopped, each with its damping.

    Parameters
    ----------
    frequency : ndarray, shape (m,)
        Of the undamped linkage in Hz.
    damping_ratio : ndarray, shape (m,)
        By the damping of the linkage in each undamped mode. A mode with a ratio of 1 or more does
        not vibrate, and its amplitude is zero.
    weights : list of ndarray, shape (n_link, m)
        Mass times shape of each link of the engine: by them its coordinates become modal ones.
    bending : ndarray, shape (m, n_links)
        Deflection of each link at its probe by a unit of the modal coordinate.
    frame_weights : ndarray, shape (3, m)
        The same for the coordinates of a frame on springs; zero of one that stands.
    """

    frequency: FloatArray
    damping_ratio: FloatArray
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
        standing = vibrating_engine(engine)
        free = undamped(standing)
        angle = request.drive.crank_angle(request.drive.law_time)
        system, damped = (
            one.linear_system(angle, prestress=one.prestress_at_rest, rotation_terms=False)
            for one in (free, standing)
        )
        modes = solve_modes(system, min(request.modes, system.size))
        shapes = [q[0] for q in system.unreduced_links(modes.vectors)]
        weights, of_frame = system.modal_weights(modes.vectors, free.links)
        small = deflections(free, [_SMALL * q.T for q in shapes])
        vectors, frequency = modes.vectors[0], modes.frequency[0]
        damping = np.einsum("nm,nk,km->m", vectors, damped.damping[0], vectors)
        ratio = damping / (4 * np.pi * frequency)
        return cls(frequency, ratio, weights, small / _SMALL, of_frame)

    @property
    def decay(self) -> FloatArray:
        """Rate in 1/s at which the amplitude of each mode decays, (m,)."""
        return 2 * np.pi * self.frequency * self.damping_ratio

    @property
    def angular_frequency(self) -> FloatArray:
        """Of each damped mode in rad/s, (m,); zero of one that does not vibrate."""
        left = np.maximum(1 - self.damping_ratio**2, 0.0)
        return np.asarray(2 * np.pi * self.frequency * np.sqrt(left))

    def of_state(self, state: LinkState, at_rest: LinkState) -> NDArray[np.complex128]:
        """Complex amplitude of each mode in each link's deflection, from the state at the stop.

        It tells how far the mode goes on to vibrate, without a run of the rest.

        Parameters
        ----------
        state, at_rest : LinkState
            Of the engine's links, and of a frame on springs; the last is where they come to rest
            under their loads.

        Returns
        -------
        ndarray of complex, shape (n_links, m)
            In m, of the time since that state.
        """
        weights = [*self.weights, self.frame_weights]
        moved = [*state.displacement, state.moved.displacement[0]]
        rest = [*at_rest.displacement, at_rest.moved.displacement[0]]
        moved = [q - still for q, still in zip(moved, rest, strict=True)]
        rate = [*state.rate, state.moved.rate[0]]
        position, velocity = (
            np.sum([q @ weight for q, weight in zip(each, weights, strict=True)], axis=0)
            for each in (moved, rate)
        )
        turning = self.angular_frequency
        vibrates = turning > 0
        quarter = np.zeros_like(position)
        np.divide(velocity + self.decay * position, turning, out=quarter, where=vibrates)
        return np.asarray(self.bending.T * (position - 1j * quarter) * vibrates)

    def waves(self, trajectory: Trajectory, begin: float) -> NDArray[np.complex128]:
        """Complex amplitude of each mode in the deflection of each link at the stop.

        The modal coordinates of the run are projected by the mass, and a constant and a wave of the
        mode's frequency and decay are fitted to each over two periods.

        Parameters
        ----------
        trajectory : Trajectory
            Of the engine.
        begin : float
            When the crank stops, in s.

        Returns
        -------
        ndarray of complex, shape (n_links, m)
            In m, of the time that ``begin`` is zero of; not a number where the rest is shorter than
            a period.
        """
        after = trajectory.time >= begin
        time = trajectory.time[after] - begin
        moved = zip(trajectory.displacement, self.weights, strict=True)
        modal = np.sum([q[after] @ weight for q, weight in moved], axis=0)
        if trajectory.frame is not None:
            modal = modal + trajectory.frame.displacement[after] @ self.frame_weights
        found = np.full(len(self.frequency), np.nan, dtype=complex)
        for number, (frequency, decay, turning) in enumerate(
            zip(self.frequency, self.decay, self.angular_frequency, strict=True)
        ):
            if time[-1] * frequency < 1:
                continue
            if not turning:
                found[number] = 0.0
                continue
            some = time * frequency <= _PERIODS
            wave = np.exp((1j * turning - decay) * time[some])
            columns = np.column_stack([np.ones(len(wave)), wave.real, -wave.imag])
            _, real, imaginary = np.linalg.lstsq(columns, modal[some, number])[0]
            found[number] = complex(real, imaginary)
        return np.asarray(self.bending.T * found)
