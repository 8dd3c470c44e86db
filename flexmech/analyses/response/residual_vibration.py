"""What rings after a crank has stopped: envelopes, amplitudes of modes, and what is said of them.

A run of the rest tells the envelope of each link's deflection, and by the natural modes of the
standing linkage how far each mode rings. The state at the stop tells the same without the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.response.agreement import best_known, errors_of, quantities_of
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.plan import (
    STEPS_PER_PERIOD,
    planned,
    undamped,
    vibrating_engine,
)
from flexmech.analyses.response.request import FREE_SHAFT_GOES_ON, ResponseRequest
from flexmech.analyses.response.start import linear_start
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray
from flexmech.choices import Start
from flexmech.dynamical_systems import VibrationState
from flexmech.errors import InputError
from flexmech.linkages import Drive
from flexmech.mechanics import Engine
from flexmech.mechanics.running import (
    DrivenLinkage,
    LinkState,
    Trajectory,
    static_balance,
    stretches_in_runs,
)
from flexmech.solvers import end_state
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
        Time of the history in s, from zero on.
    values : ndarray, shape (N,)
    waves : ndarray of complex, shape (m,)
        Amplitudes at time zero; not a number of a wave that is not known.
    decay, angular_frequency : ndarray, shape (m,)
        In 1/s and rad/s.
    period : float
        Period of the slowest wave, in s; a shorter history counts whole.

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
        Frequency of the undamped linkage in Hz.
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
        """Damped frequency of each mode in rad/s, (m,); zero for one that does not vibrate."""
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
            Trajectory of the engine.
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


# Steps in a period of the highest frequency of interest, by the method of fourth order, where links
# stretch: twice as many change an amplitude by less than 1e-4 of the greatest.
_STEPS_WHERE_LINKS_STRETCH = 20


def amplitudes_after_stop(engine: Engine, drive: Drive, modes: int) -> FloatArray:
    """Amplitude of each mode in each link's deflection after a law, by the state at the stop.

    The equations of motion in link frames are run until the stop, from undeformed links; from
    the equilibrium of links that are bent without load.

    Parameters
    ----------
    engine : Engine
    drive : Drive
        A law that stops.
    modes : int
        Natural modes of the standing linkage.

    Returns
    -------
    ndarray, shape (n_links, modes)
        In m.

    Raises
    ------
    InputError
        If the crank does not stop, or stops with a blow.
    ComputationError
        If the run diverges.
    """
    if drive.speed or drive.is_constant:
        raise InputError(
            f"nothing rings after a stop where the crank goes on turning ({drive.words}); give a "
            'law in [drive], as law = "cycloid" with travel, time and dwell'
        )
    if engine.shaft == "free":
        raise InputError(FREE_SHAFT_GOES_ON)
    if drive.law.blow is not None:
        raise InputError(
            "the law ends with a blow, which the equations in link frames do not hold; take a "
            'table with ends = "rest"'
        )
    engine = engine.fit_for(modes)
    start: Start = "equilibrium" if engine.mechanism.is_free_strained else "rigid"
    request = ResponseRequest(drive, modes=modes, start=start)
    stretches = stretches_in_runs(engine, request.prestress)
    linkage = DrivenLinkage(engine, drive, request.prestress, modes=modes, stretches=stretches)
    per_period = _STEPS_WHERE_LINKS_STRETCH if stretches else STEPS_PER_PERIOD
    highest = planned([engine], request).highest
    steps = max(1, math.ceil(drive.law_time * highest * per_period))
    begin = linear_start(linkage, request, drive.law_time / steps)
    end = end_state(linkage, begin.position, begin.velocity, drive.law_time, steps)
    at_rest = _at_rest(linkage, drive.law_time)
    return np.abs(StandingModes.of(engine, request).of_state(end, at_rest))


def _at_rest(linkage: DrivenLinkage, time: float) -> LinkState:
    """Where links come to rest under their loads, by the equations of the run."""
    equations = linkage.quasi_static_equations(np.array([time]))
    if linkage.stretch is None:
        still = equations.quasi_static(constrained=linkage.shaft_coordinates)
    else:
        still = static_balance(linkage, np.zeros(linkage.size), time)[None]
    nothing = np.zeros_like(still)
    return linkage.link_state(equations, VibrationState(still, nothing, nothing))


def residual_values(
    engine: Engine, refined: Trajectory, request: ResponseRequest, refinement: int
) -> Values:
    """The vibration that is left after a stop: edges of each deflection, amplitude of each mode.

    Parameters
    ----------
    engine : Engine
    refined : Trajectory
        At the refined samples.
    request : ResponseRequest
    refinement : int
        Refined samples for each one asked for.

    Returns
    -------
    dict
        Empty where nothing stops: a free shaft does not stop with the law.
    """
    if request.drive.is_constant or refined.shaft is not None or not rests(request):
        return {}
    begin, sampled = request.drive.law_time, refined.time[::refinement]
    after, shown = refined.time >= begin, sampled >= begin
    time, at = refined.time[after] - begin, sampled[shown] - begin
    # At the stop and at the end of the rest besides the samples that are kept.
    at = np.concatenate([time[:1], at, time[-1:]])
    bent = deflections(engine, refined.displacement)[after]
    modes = StandingModes.of(engine, request)
    waves = modes.waves(refined, begin)
    period = 1 / float(modes.frequency[0])
    of_links = [
        edges(at, time, own, wave, modes.decay, modes.angular_frequency, period)
        for own, wave in zip(bent.T, waves, strict=True)
    ]
    lower, upper = np.moveaxis(np.array(of_links), 0, -1)
    amplitude = (upper - lower) / 2
    envelope, middle = np.full((2, len(sampled), bent.shape[1]), np.nan)
    envelope[shown], middle[shown] = amplitude[1:-1], (upper + lower)[1:-1] / 2
    return {
        "residual_envelope": envelope,
        "residual_middle": middle,
        "residual_amplitude": amplitude[0],
        "residual_amplitude_at_end": amplitude[-1],
        "standing_frequency": modes.frequency,
        "standing_damping_ratio": modes.damping_ratio,
        "modal_amplitude": np.abs(waves),
        "mode": np.arange(1, len(modes.frequency) + 1),
    }


_NAMES = ("residual_amplitude", "residual_amplitude_at_end")
_MM = 1e3


def _errors(data: xr.Dataset) -> xr.DataArray:
    """Error of a residual amplitude in m, over (engine, link): that of the deflections."""
    return errors_of(data)["deflection"] * data["peak_deflection"]


def residual_numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Residual amplitude of each link after the stop and at the end of the rest, peak power.

    Of the engine whose deflections have the smaller errors; the difference of two engines is an
    error too.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.

    Returns
    -------
    tuple of Quantity
        None of a run at constant speed.
    """
    if "peak_driving_power" not in data:
        return ()
    known, power = errors_of(data), data["peak_driving_power"]
    place = best_known(known["deflection"])
    own = known["peak_driving_torque"] * power
    found = quantities_of(power, own, place, "peak_driving_power", "W", 1.0)
    if _NAMES[0] not in data:
        return tuple(found)
    bent = {"link": data["peak_deflection"].max("engine") > 0}
    for name in _NAMES:
        found += quantities_of(data[name][bent], _errors(data)[bent], place, name, "mm", _MM)
    return tuple(found)


def residual_aspect(data: xr.Dataset) -> Aspect:
    """The power that a law of motion takes, and what rings after the stop.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.

    Returns
    -------
    Aspect
        Nothing of a run at constant speed; no answer where that of a shaped law has it.
    """
    if "driving_power" not in data:
        return Aspect()
    numbers = residual_numbers(data)
    answer = () if "shaped_residual_amplitude" in data else _answer(data, numbers)
    return Aspect(answer, tuple(_lines(data)), numbers=numbers)


def _answer(data: xr.Dataset, found: tuple[Quantity, ...]) -> tuple[str, ...]:
    """How far the link that rings most does after the stop; nothing where nothing stops."""
    ringing = [one for one in found if one.name == _NAMES[0]]
    if not ringing:
        return ()
    most = max(ringing, key=lambda one: one.value)
    left = next(one for one in found if one.name == _NAMES[1] and one.of == most.of)
    rest = float(data["time"][-1]) - float(data.attrs["run_up_time"])
    return (f"After the stop the {most.of} rings by {most}, after {rest:.3g} s of rest by {left}.",)


def _lines(data: xr.Dataset) -> list[str]:
    """The power that a law takes, and what rings after the stop."""
    engines = [str(name) for name in data["engine"].values]
    powers = ", ".join(
        f"{rounded(float(one), 0.0, 5)} W ({name})"
        for one, name in zip(data["peak_driving_power"].values, engines, strict=True)
    )
    lines = [f"peak driving power: {powers}"]
    if _NAMES[0] not in data:
        if not data.attrs.get("crank_speed_at_end", 1.0) and "shaft_rotation" not in data:
            lines.append("residual vibration: not computed without a dwell; give one in the drive")
        return lines
    for name in engines:
        own_values = data.sel(engine=name)
        texts = [
            f"{link} {rounded(_MM * float(first), 0.0, 4)} to {rounded(_MM * float(last), 0.0, 4)}"
            for link, first, last in zip(
                data["link"].values, *(own_values[one].values for one in _NAMES), strict=True
            )
            if first > 0
        ]
        lines.append(
            f"residual vibration from the stop to the end of the rest: {', '.join(texts)} mm "
            f"({name})"
        )
        lines.append(f"modes after the stop: {_mode_texts(own_values)} ({name})")
    return lines


def _mode_texts(data: xr.Dataset) -> str:
    """Frequency of each mode of the standing linkage, and how much of it each link shows."""
    bent = data["link"].values[data["peak_deflection"].values > 0]
    texts = []
    for mode in data["mode"].values:
        one = data.sel(mode=mode)
        frequency = f"{float(one['standing_frequency']):.5g} Hz"
        amplitude = one["modal_amplitude"].sel(link=bent)
        if float(one["standing_damping_ratio"]) >= 1:
            texts.append(f"{frequency} damped too heavily to vibrate")
        elif amplitude.isnull().any():
            texts.append(f"{frequency} not seen in less than a period of rest")
        else:
            shown = ", ".join(
                f"{link} {rounded(_MM * float(value), 0.0, 3)}"
                for link, value in zip(bent, amplitude.values, strict=True)
            )
            texts.append(f"{frequency} {shown} mm")
    return "; ".join(texts)
