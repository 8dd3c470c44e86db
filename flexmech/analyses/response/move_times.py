"""Residual vibration against the time of a move: plain and shaped laws, each of many times.

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

from flexmech.analyses.response.move_curves import TIMES_PER_PERIOD, curve_variables
from flexmech.analyses.response.plan import STEPS_PER_PERIOD, RunPlan
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.shaping import LawShaper
from flexmech.analyses.response.standing_modes import StandingModes
from flexmech.analyses.response.start import (
    equilibria_at,
    frame_at_rest,
    linear_start,
    simulation_start,
)
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import Engine
from flexmech.linkages import Drive, LawDrive, ShapedDrive
from flexmech.time_domain import (
    DrivenLinkage,
    LinkState,
    end_state,
    simulator,
    static_balance,
    stretches_in_runs,
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
        (:func:`~flexmech.analyses.response.move_curves.curve_variables`); of engines that simulate
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
            with_energy=False,
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
