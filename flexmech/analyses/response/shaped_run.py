"""A run by the shaped law beside that by the plain one, and the chart over the time of a move.

Residual vibration over the time of a move, between the times that are run.

What the start of a law and its other corners excite reaches the stop with a phase that goes with
the time of the move, so that the amplitude of a mode of frequency f rises and falls within 1/f of
that time. Its complex amplitude has phases between none and ``2 pi f T`` alone: with half of it
taken off, it is smooth over a third of a period, and a cubic spline tells it between the times
(sampling of a band, R. N. Bracewell, *The Fourier Transform and Its Applications*, 3rd ed. 2000,
ch. 10).

Residual vibration against the time of a move: plain and shaped laws, each of many times.

The state of the links at the stop tells how far each mode of the standing linkage rings on. The
equations of motion in link frames are run to it at every time; an engine that simulates at some of
them, to check.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.response.agreement import errors_of
from flexmech.analyses.response.dataset import build_dataset
from flexmech.analyses.response.plan import STEPS_PER_PERIOD, RunPlan, planned
from flexmech.analyses.response.request import FREE_SHAFT_GOES_ON, ResponseRequest
from flexmech.analyses.response.residual_vibration import StandingModes
from flexmech.analyses.response.run import run_engine
from flexmech.analyses.response.shaping import (
    LawShaper,
    check_rest,
    ringing_modes,
    shaper_attributes,
    shaper_variables,
)
from flexmech.analyses.response.start import (
    equilibria_at,
    frame_at_rest,
    linear_start,
    simulation_start,
)
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.dynamical_systems import VibrationState
from flexmech.errors import InputError
from flexmech.linkages import Drive, LawDrive, ShapedDrive
from flexmech.mechanics import Engine
from flexmech.mechanics.running import DrivenLinkage, LinkState, static_balance, stretches_in_runs
from flexmech.solvers import end_state, simulator

# Times of the move in a period of a mode, by which its amplitude is known between them: of an arm
# after a cycloid within 1 % of the greatest.
TIMES_PER_PERIOD = 3.0
# Points of a curve in a period of the highest mode: its valleys are seen.
_POINTS_PER_PERIOD = 24
# Fewer times make no spline.
_LEAST_TIMES = 4


def are_resolved(times: FloatArray, frequency: FloatArray) -> NDArray[np.bool_]:
    """Whether the times of a move are near enough to each other for each mode.

    Parameters
    ----------
    times : ndarray, shape (n,)
        In s, increasing.
    frequency : ndarray, shape (m,)
        In Hz.

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    if len(times) < _LEAST_TIMES:
        return np.zeros(len(frequency), dtype=bool)
    apart = float(np.diff(times).max())
    return np.asarray(frequency * apart * TIMES_PER_PERIOD <= 1 + 1e-9)


def curve_variables(
    times: FloatArray,
    whole: FloatArray,
    amplitude: NDArray[np.complex128],
    frequency: FloatArray,
) -> xr.Dataset:
    """Amplitudes over the time of a move as curves, of the modes that its times resolve.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Of the move in s, increasing.
    whole : ndarray, shape (n_laws, n)
        Time until the stop in s, a shaper's included.
    amplitude : ndarray of complex, shape (n_laws, n, n_links, m)
        In m.
    frequency : ndarray, shape (m,)
        In Hz.

    Returns
    -------
    xarray.Dataset
        ``move_curve`` over (law, curve_move_time, link, curve_mode) in m, and
        ``curve_whole_time`` over (law, curve_move_time) in s; empty where no mode is resolved.
    """
    from scipy.interpolate import CubicSpline

    modes = np.flatnonzero(are_resolved(times, frequency))
    if not modes.size:
        return xr.Dataset()
    count = _POINTS_PER_PERIOD * float(np.ptp(times)) * float(frequency[modes].max())
    places = np.union1d(times, np.linspace(times[0], times[-1], int(np.ceil(count)) + 1))
    half_phase = np.exp(-1j * np.pi * np.multiply.outer(times, frequency[modes]))
    spline = CubicSpline(times, amplitude[..., modes] * half_phase[None, :, None], axis=1)
    over = ("law", "curve_move_time", "link", "curve_mode")
    return xr.Dataset(
        {
            "move_curve": (over, np.abs(spline(places))),
            "curve_whole_time": (
                ("law", "curve_move_time"),
                np.stack([np.interp(places, times, own) for own in whole]),
            ),
        },
        coords={"curve_move_time": places, "curve_mode": modes + 1},
    )


# Left out, the times of a move go from half the law's own to twice of it, evenly.
_RANGE, _COUNT = (0.5, 2.0), 61
# Fewest of them, and steps of all runs together beyond which there are fewer. Time alone.
_FEWEST, _MOST_STEPS = 13, 250_000
# Steps in a period of the highest frequency of interest, by the method of fourth order, where links
# stretch: twice as many change an amplitude by less than 1e-4 of the greatest.
_STEPS_WHERE_LINKS_STRETCH = 20
# A mode that rings less than this part of what rings most is not drawn.
RINGING_PART = 0.01
# Of them an engine that simulates runs so many of each law, the first and the last among them, and
# fewer where all its runs would take more steps. Time alone.
_SIMULATED, _MOST_SIMULATED_STEPS = 5, 30_000


def moves_of(request: ResponseRequest, highest: float) -> FloatArray:
    """Times of a move, the dwell not counted, in s; (n,).

    Parameters
    ----------
    request : ResponseRequest
    highest : float
        Highest natural frequency of interest in Hz: of many steps there are fewer times.

    Returns
    -------
    ndarray
        Empty where no chart is asked for, and where a law ends with a blow, which the equations in
        link frames do not hold.
    """
    if request.move_times is not None:
        return np.unique(request.move_times)
    if request.shaping is None or request.drive.law.blow is not None:
        return np.zeros(0)
    count = int(np.clip(_most_runs(request, highest), _FEWEST, _COUNT))
    return move_time(request.drive) * np.linspace(*_RANGE, count)


def _most_runs(request: ResponseRequest, highest: float) -> float:
    """Moves that take no more than the most steps, by the plain and by the shaped law."""
    return _MOST_STEPS / (2 * request.drive.law_time * highest * _STEPS_WHERE_LINKS_STRETCH)


def _between(
    times: FloatArray,
    amplitude: NDArray[np.complex128],
    frequency: FloatArray,
    request: ResponseRequest,
    highest: float,
) -> FloatArray:
    """Times between even ones, by which every mode that rings is resolved if steps allow it."""
    peaks = np.abs(amplitude).max(axis=(1, 2))
    ringing = frequency[(peaks >= RINGING_PART * peaks.max(axis=1, keepdims=True)).any(axis=0)]
    apart = times[1] - times[0]
    parts = np.ceil(np.maximum(apart * ringing * TIMES_PER_PERIOD - 1e-9, 1.0))
    most = max(1.0, np.floor(_most_runs(request, highest) / len(times)))
    allowed = parts[parts <= most]
    count = int(allowed.max()) if allowed.size else 1
    shares = np.arange(1, count) / count
    return np.asarray((times[:-1, None] + apart * shares).reshape(-1))


def move_time(drive: Drive) -> float:
    """Time of one move of a law in s, without dwell.

    Parameters
    ----------
    drive : Drive
        A law that stops.
    """
    while isinstance(drive, ShapedDrive):
        drive = drive.drive
    return drive.time if isinstance(drive, LawDrive) else float(np.diff(drive.corners)[0])


def move_variables(
    engines: Sequence[Engine],
    request: ResponseRequest,
    plan: RunPlan,
    shaper: LawShaper | None,
    report: LabelledProgress,
) -> xr.Dataset:
    """Amplitude of each mode after the stop, over the time of a move.

    Parameters
    ----------
    engines : sequence of Engine
        The first one's equations in link frames are run at all times; those that simulate at some.
    request : ResponseRequest
    plan : RunPlan
        Whose highest frequency sets the steps.
    shaper : LawShaper, optional
        For which the law is shaped besides.
    report : callable
        Called with a label, the moves done and the moves to do.

    Returns
    -------
    xarray.Dataset
        Empty where no times are asked for. ``move_amplitude`` over (law, move_time, link, mode) in
        m, ``whole_move_time`` over (law, move_time) in s with the shaper's delay, and curves
        (:func:`~flexmech.analyses.response.shaped_run.curve_variables`); of engines that simulate
        ``simulated_move_amplitude`` over (simulating_engine, law, simulated_move_time, link, mode).

    Raises
    ------
    ComputationError
        If a run diverges.
    """
    times = moves_of(request, plan.highest)
    if not times.size:
        return xr.Dataset()
    moving = _InLinkFrames(engines[0], request, plan)

    def run(at: FloatArray) -> tuple[list[list[Drive]], NDArray[np.complex128]]:
        rows = _drives(request, at, shaper)
        return rows, _all(rows, moving.amplitudes, report, "residual vibration")

    drives, found = run(times)
    if request.move_times is None:
        between = _between(times, found, moving.frequency, request, plan.highest)
        if between.size:
            more, further = run(between)
            order = np.argsort(np.concatenate([times, between]))
            times = np.concatenate([times, between])[order]
            found = np.concatenate([found, further], axis=1)[:, order]
            both = zip(drives, more, strict=True)
            drives = [[(row + added)[place] for place in order] for row, added in both]
    names = ["plain"] if shaper is None or request.shaping is None else ["plain", "shaped"]
    dims = ("law", "move_time", "link", "mode")
    whole = np.array([[drive.law_time for drive in row] for row in drives])
    dataset = xr.Dataset(
        {
            "move_amplitude": (dims, np.abs(found)),
            "whole_move_time": (("law", "move_time"), whole),
            "move_frequency": ("mode", moving.frequency),
        },
        coords={"law": names, "move_time": times, "mode": np.arange(1, found.shape[-1] + 1)},
        attrs={"own_move_time": move_time(request.drive)},
    ).merge(curve_variables(times, whole, found, moving.frequency), combine_attrs="override")
    simulating = [engine for engine in engines if engine.simulates]
    if not simulating:
        return dataset
    steps = len(names) * float(np.mean(whole)) * plan.highest * STEPS_PER_PERIOD
    count = int(np.clip(_MOST_SIMULATED_STEPS / steps, 2, _SIMULATED))
    some = np.unique(np.linspace(0, len(times) - 1, count).round().astype(int))
    rows = [[row[number] for number in some] for row in drives]
    simulators = [engine.name for engine in simulating]
    values = [
        np.abs(_all(rows, _Simulated(engine, request, plan).amplitudes, report, f"stops, {name}"))
        for name, engine in zip(simulators, simulating, strict=True)
    ]
    over = ("simulating_engine", "law", "simulated_move_time", "link", "mode")
    return dataset.assign(simulated_move_amplitude=(over, np.stack(values))).assign_coords(
        simulating_engine=simulators, simulated_move_time=times[some]
    )


def _drives(
    request: ResponseRequest, times: FloatArray, shaper: LawShaper | None
) -> list[list[Drive]]:
    """The plain law over each time; and the shaped one."""
    own = move_time(request.drive)
    plain = [request.drive.stretched(float(time) / own) for time in times]
    return [plain] if shaper is None else [plain, [shaper.shaped(drive) for drive in plain]]


def _all(
    drives: list[list[Drive]],
    amplitudes: Callable[[Drive], NDArray[np.complex128]],
    report: LabelledProgress,
    label: str,
) -> NDArray[np.complex128]:
    """Complex amplitudes (n_laws, n, n_links, m) of all drives."""
    total, found = sum(map(len, drives)), list[list[NDArray[np.complex128]]]()
    for row in drives:
        of_law = list[NDArray[np.complex128]]()
        for drive in row:
            of_law.append(amplitudes(drive))
            report(label, len(found) * len(row) + len(of_law), total)
        found.append(of_law)
    return np.array(found)


class _Stops:
    """Runs of an engine that end with the law, and the modes of what stands then."""

    def __init__(self, engine: Engine, request: ResponseRequest, plan: RunPlan) -> None:
        self._engine, self._request = engine, request
        self._modes = StandingModes.of(engine, request)
        self._highest = plan.highest

    @property
    def frequency(self) -> FloatArray:
        """Of the modes in Hz, (m,)."""
        return self._modes.frequency

    def _steps(self, drive: Drive, per_period: int = STEPS_PER_PERIOD) -> int:
        return max(1, math.ceil(drive.law_time * self._highest * per_period))


class _InLinkFrames(_Stops):
    """By the equations of motion in link frames, as a run that is not simulated."""

    def amplitudes(self, drive: Drive) -> NDArray[np.complex128]:
        """Amplitudes (n_links, m) in m after a law."""
        prestress = self._request.prestress
        stretches = stretches_in_runs(self._engine, prestress)
        linkage = DrivenLinkage(
            self._engine,
            drive,
            prestress,
            modes=self._request.modes,
            stretches=stretches,
        )
        per_period = _STEPS_WHERE_LINKS_STRETCH if stretches else STEPS_PER_PERIOD
        steps = self._steps(drive, per_period)
        request = replace(self._request, speed=drive, step=None)
        state = linear_start(linkage, request, drive.law_time / steps)
        end = end_state(linkage, state.position, state.velocity, drive.law_time, steps)
        return self._modes.of_state(end, _at_rest(linkage, drive.law_time))


def _at_rest(linkage: DrivenLinkage, time: float) -> LinkState:
    """Where links come to rest under their loads, by the equations of the run."""
    equations = linkage.quasi_static_equations(np.array([time]))
    if linkage.stretch is None:
        still = equations.quasi_static(constrained=linkage.shaft_coordinates)
    else:
        still = static_balance(linkage, np.zeros(linkage.size), time)[None]
    nothing = np.zeros_like(still)
    return linkage.link_state(equations, VibrationState(still, nothing, nothing))


class _Simulated(_Stops):
    """By an engine that simulates."""

    def amplitudes(self, drive: Drive) -> NDArray[np.complex128]:
        """Amplitudes (n_links, m) in m after a law."""
        engine, end = self._engine, drive.law_time
        step = end / self._steps(drive)
        start = simulation_start(engine, replace(self._request, speed=drive, step=None), step)
        run = simulator(engine).simulate(
            drive, start, np.array([0.0, end]), step, integrator=self._request.integrator
        )
        still = equilibria_at(engine, drive, np.array([end]))
        at_rest = LinkState.rigid(engine.links)
        if still is not None:
            at_rest = LinkState([q[0] for q in still], at_rest.rate)
        at_rest = replace(at_rest, frame=frame_at_rest(engine, drive, end))
        end_of_run = run[-1:]
        displacement, rate = end_of_run.displacement, end_of_run.rate
        last = LinkState([q[0] for q in displacement], [v[0] for v in rate], end_of_run.frame)
        return self._modes.of_state(last, at_rest)


# Of the shaped run what is told beside the plain one.
_KEPT = (
    "deflection",
    "driving_torque",
    "driving_power",
    "crank_angle",
    "crank_speed_over_time",
    "crank_acceleration",
    "residual_envelope",
    "residual_amplitude",
    "residual_amplitude_at_end",
    "modal_amplitude",
    "peak_deflection",
    "peak_driving_torque",
    "peak_driving_power",
    "energy_error",
)


def check_stops(engines: Sequence[Engine], request: ResponseRequest) -> None:
    """Refuse a shaper and times of a move for what does not stop, before anything is computed.

    Parameters
    ----------
    engines : sequence of Engine
    request : ResponseRequest

    Raises
    ------
    InputError
    """
    if request.shaping is None and request.move_times is None:
        return
    if any(engine.shaft == "free" for engine in engines):
        raise InputError(FREE_SHAFT_GOES_ON)
    if request.move_times is not None and request.drive.law.blow is not None:
        raise InputError(
            "the law ends with a blow, which the equations that run the times of a move do not "
            'hold; leave --move-times out, or take a table with ends = "rest"'
        )
    if request.shaping is not None:
        check_rest(request)


def with_shaped_law(
    plain: xr.Dataset,
    engines: Sequence[Engine],
    request: ResponseRequest,
    plan: RunPlan,
    report: LabelledProgress,
) -> xr.Dataset:
    """Add the run by the shaped law, and the residual vibration over the time of a move.

    Parameters
    ----------
    plain : xarray.Dataset
        Of the run by the plain law.
    engines : sequence of Engine
        The first one's modes are those that the law is shaped for.
    request : ResponseRequest
    plan : RunPlan
        Of the plain run.
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    xarray.Dataset
        The same where neither is asked for.

    Raises
    ------
    InputError
        If no mode is seen to ring, or the linkage lacks one that is asked for.
    ComputationError
        If a run fails.
    """
    shaping, shaper, found = request.shaping, None, plain
    if shaping is not None:
        modes = shaping.modes or ringing_modes(plain)
        shaper = LawShaper.of(engines[0], request, shaping, modes)
        drive = shaper.shaped(request.drive)
        own = replace(request, speed=drive, shaping=None, move_times=None)
        own_plan = planned(engines, own)

        def told(label: str, done: int, total: int) -> None:
            report(f"{label}, shaped", done, total)

        runs = [run_engine(engine, own, own_plan, told) for engine in engines]
        found = found.merge(_beside(build_dataset(runs, own, own_plan)), compat="override")
        found = found.merge(shaper_variables(shaper), compat="override")
        found = found.assign_attrs(shaper_attributes(shaper, shaping, drive))
    moves = move_variables(engines, request, plan, shaper, report)
    return found.merge(moves, compat="override", combine_attrs="override").assign_attrs(moves.attrs)


def _beside(shaped: xr.Dataset) -> xr.Dataset:
    """What is told of the shaped run, under names and a time of its own."""
    kept = shaped.reset_coords()[[*_KEPT]]
    kept["residual_error"] = errors_of(shaped)["deflection"] * shaped["peak_deflection"]
    renamed = {str(name): f"shaped_{name}" for name in kept.data_vars}
    return kept.rename(renamed | {"time": "shaped_time"}).drop_attrs()
