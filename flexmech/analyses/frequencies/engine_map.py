"""Natural frequencies of one engine over a map: tracked modes, with their errors.

What pictures show beside the map: points between its crank angles, and mode shapes asked for.

Between two crank angles of the map a line is straight, which shows where a frequency bends. There
the eigenvalues are solved for in between, halving steps until a straight line is as good as the
curve to the eye: every point of a line is a solution, none is interpolated.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.datasets import rigid_positions
from flexmech.analyses.frequencies.discretisation import (
    HIGHEST_ORDER,
    check_angle_indices,
    damping_error,
    lumping_error,
    mesh_error,
    on_compared_mesh,
)
from flexmech.analyses.frequencies.extremes import MOST_STEP, extremes_between, known_error
from flexmech.analyses.frequencies.flutter import flutter, may_flutter
from flexmech.analyses.frequencies.frequency_map import frequencies_along, systems_at
from flexmech.analyses.frequencies.modal_damping import StrainEnergyDamping
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.arrays import FloatArray, IntArray, LabelledProgress
from flexmech.mechanics import Engine
from flexmech.solvers.eigenproblem import solve_modes
from flexmech.solvers.formulation import Systems
from flexmech.solvers.reduction import ModeErrors, converged_along
from flexmech.solvers.tracking import Positions, Tracker, same_shapes

# Distance of a line from its curve that is seen, over the range of the curve; a range is at
# least this part of the frequency, as in the pictures.
SEEN, LEAST_RANGE = 4e-3, 4e-3
# Each leaves a quarter of the distance of a line from its curve: after three it is a 64th.
MOST_ROUNDS = 3

Solve = Callable[[FloatArray], FloatArray]


def drawn_between(
    systems: Sequence[Systems], request: FrequencyRequest, found: xr.Dataset
) -> xr.Dataset:
    """Frequencies between the crank angles of a map where its lines bend.

    Parameters
    ----------
    systems : sequence of Systems
        Systems of each crank speed.
    request : FrequencyRequest
        Its ``smooth`` may name the crank angles.
    found : xarray.Dataset
        The map of the same engine, over (crank_speed, crank_angle, mode).

    Returns
    -------
    xarray.Dataset
        ``frequency_between`` and ``branch_between`` over (crank_speed, between_angle, mode); a
        branch is 0 where the modes change it within the step. Empty if no line bends.
    """
    order = ("crank_speed", "crank_angle", "mode")
    frequency, branch = (
        found[name].transpose(*order).values for name in ("frequency", "branch_of_mode")
    )
    speeds = request.crank_speeds.tolist()

    def solve(angles: FloatArray) -> FloatArray:
        pairs = zip(systems, speeds, strict=True)
        return np.stack([frequencies_along(one, angles, speed) for one, speed in pairs])

    if isinstance(request.smooth, bool):
        angles, values = bent_angles(
            solve, request.crank_angles, frequency, full_turn=request.full_turn
        )
    else:
        angles = np.asarray(request.smooth, dtype=float)
        values = solve(angles) if len(angles) else np.zeros((len(speeds), 0, frequency.shape[-1]))
    if not len(angles):
        return xr.Dataset()
    after = np.searchsorted(request.crank_angles, angles).clip(1, len(request.crank_angles) - 1)
    before = branch[:, after - 1]
    stays = before == branch[:, after]
    over = ("crank_speed", "between_angle", "mode")
    return xr.Dataset(
        {
            "frequency_between": (over, values),
            "branch_between": (over, np.where(stays, before, 0).astype(np.int64)),
        },
        coords={"between_angle": angles},
    )


def bent_angles(
    solve: Solve, angles: FloatArray, frequency: FloatArray, *, full_turn: bool
) -> tuple[FloatArray, FloatArray]:
    """Crank angles at which lines through a grid must be refined, and the frequencies there.

    Parameters
    ----------
    solve : callable
        Frequencies (S, n, m) at crank angles (n,).
    angles : ndarray, shape (A,)
        Increasing, rad.
    frequency : ndarray, shape (S, A, m)
        At these angles, in Hz.
    full_turn : bool
        Whether the last angle leads back to the first.

    Returns
    -------
    ndarray, shape (n,)
        Increasing.
    ndarray, shape (S, n, m)
    """
    added, values = np.zeros(0), np.zeros((len(frequency), 0, frequency.shape[-1]))
    if len(angles) < 3:
        return added, values
    size = np.ptp(frequency, axis=(0, 1))
    seen = SEEN * np.maximum(size, LEAST_RANGE * frequency.mean(axis=(0, 1)))
    bent = _bent(angles, frequency, seen, full_turn=full_turn)
    low, high = angles[:-1][bent], angles[1:][bent]
    at_low, at_high = frequency[:, :-1][:, bent], frequency[:, 1:][:, bent]
    for _ in range(MOST_ROUNDS):
        if not len(low):
            break
        middle = (low + high) / 2
        there = solve(middle)
        added, values = np.append(added, middle), np.concatenate([values, there], axis=1)
        off = np.abs(there - (at_low + at_high) / 2)
        again = (off > seen).any(axis=(0, 2))
        low, high = (
            np.concatenate(pair)
            for pair in ((low[again], middle[again]), (middle[again], high[again]))
        )
        parts = at_low[:, again], there[:, again], at_high[:, again]
        at_low, at_high = np.concatenate(parts[:2], axis=1), np.concatenate(parts[1:], axis=1)
    order = np.argsort(added)
    return added[order], values[:, order]


def _bent(
    angles: FloatArray, frequency: FloatArray, seen: FloatArray, *, full_turn: bool
) -> NDArray[np.bool_]:
    """Intervals in which a line through the grid is off the curve as one sees; shape (A - 1,)."""
    step = np.diff(angles)
    slope = np.diff(frequency, axis=1) / step[:, None]
    bend = np.abs(np.diff(slope, axis=1)) / ((step[1:] + step[:-1]) / 2)[:, None]
    # At the ends the bend of the neighbour, or over a full turn that across its beginning.
    first, last = bend[:, :1], bend[:, -1:]
    if full_turn and np.isclose(angles[-1] - angles[0], 2 * np.pi):
        across = np.abs(slope[:, :1] - slope[:, -1:]) / ((step[0] + step[-1]) / 2)
        first = last = across
    bend = np.concatenate([first, bend, last], axis=1)
    off = np.maximum(bend[:, 1:], bend[:, :-1]) * step[:, None] ** 2 / 8
    return np.asarray((off > seen).any(axis=(0, 2)) & (step <= MOST_STEP))


def shapes_asked_for(systems: Sequence[Systems], request: FrequencyRequest) -> xr.Dataset:
    """Mode shapes at the crank angles that are asked for, with their frequencies.

    Parameters
    ----------
    systems : sequence of Systems
        Systems of each crank speed.
    request : FrequencyRequest

    Returns
    -------
    xarray.Dataset
        ``asked_shape`` (crank_speed, shape_angle, mode, part, link, station, component),
        ``asked_frequency`` (crank_speed, shape_angle, mode) and ``asked_position`` (shape_angle,
        link, station, component).
    """
    angles, modes, engine = request.shapes_at, request.formulation.modes, systems[0].engine
    frequency, shapes = [], []
    for one, speed in zip(systems, request.crank_speeds.tolist(), strict=True):
        found = [(s, solve_modes(s, modes, 0)) for s in one.batches(angles, speed)]
        frequency.append(np.concatenate([each.frequency for _, each in found]))
        displaced = [system.displacements(each.vectors) for system, each in found]
        shapes.append(scaled_parts(np.concatenate(displaced)))
    positions = rigid_positions(engine, engine.mechanism.linkage.motion(angles))
    place = ("link", "station", "component")
    return xr.Dataset(
        {
            "asked_shape": (
                ("crank_speed", "shape_angle", "mode", "part", *place),
                np.stack(shapes),
            ),
            "asked_frequency": (("crank_speed", "shape_angle", "mode"), np.stack(frequency)),
            "asked_position": (("shape_angle", *place), positions),
        },
        coords={"shape_angle": angles},
    )


def scaled_parts(shapes: NDArray[np.complex128] | FloatArray) -> FloatArray:
    """Mode shapes as real and imaginary part, the largest displacement of each mode 1.

    Parameters
    ----------
    shapes : ndarray, shape (B, mode, link, station, component)

    Returns
    -------
    ndarray, shape (B, mode, 2, link, station, component)
    """
    amplitude = np.sqrt(np.sum(np.abs(shapes) ** 2, axis=-1))
    largest = amplitude.max(axis=(-2, -1))[..., None, None, None]
    scaled = shapes / np.where(largest > 0, largest, 1.0)
    return np.stack([scaled.real, scaled.imag], axis=2)


logger = logging.getLogger(__name__)

# On each link, to which a map refines the mesh by itself; more are asked for by their number, since
# each doubling takes four times as long or more.
MOST_ELEMENTS = 32
# Modes tracked besides those asked for, so that a branch may dip out and come back.
SPARE_MODES = 2

OVER_CHECKS = ("check_angle", "mode", "part", "link", "station", "component")


@dataclass(frozen=True)
class EngineMap:
    """Map of one engine.

    Parameters
    ----------
    systems : tuple of Systems
        Systems of each speed, with as many component modes as it has needed.
    dataset : xarray.Dataset
        Over (crank_speed, crank_angle, mode), errors and shapes over (crank_speed, check_angle,
        mode); its dimensions are without coordinates but for the branches.
    """

    systems: tuple[Systems, ...]
    dataset: xr.Dataset

    @property
    def engine(self) -> Engine:
        """With the elements that the map has needed."""
        return self.systems[0].engine


def map_engine(engine: Engine, request: FrequencyRequest, report: LabelledProgress) -> EngineMap:
    """Map of one engine, on a mesh that is fine enough if the request has a tolerance.

    The elements are doubled until the estimated error of the mesh is within the tolerance, or
    until another doubling would exceed :data:`MOST_ELEMENTS`. Meshes that would be too coarse even
    if the whole error fell with the highest order are passed over. The error is estimated first:
    along all crank angles modes are solved for on the last mesh alone.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
    report : callable
        Progress: ``report(label, done, total)``.

    Returns
    -------
    EngineMap
    """
    checks = _checked_speeds(engine, request)
    while request.tolerance is not None and 2 * engine.elements <= MOST_ELEMENTS:
        error = max(float(check.mesh_error.frequency.max()) for check in checks)
        if error <= request.tolerance:
            break
        logger.info("%d elements are off by %.1e", engine.elements, error)
        doublings = max(1, math.ceil(math.log2(error / request.tolerance) / HIGHEST_ORDER))
        possible = int(math.log2(MOST_ELEMENTS / engine.elements))
        engine = engine.with_(elements=engine.elements * 2 ** min(doublings, possible))
        checks = _checked_speeds(engine, request)
    return _map_on_mesh(engine, request, checks, report)


@dataclass(frozen=True)
class _CheckedSpeed:
    """Shapes and errors at the check angles of one speed, without the matrices.

    Parameters
    ----------
    systems : Systems
        With as many component modes as they need.
    shapes : ndarray, shape (c, m, n_links, n_stations, 2)
        Shapes of the modes asked for and spare ones.
    reduction_error : ModeErrors
    mesh_error : ModeErrors
    """

    systems: Systems
    shapes: NDArray[Any]
    reduction_error: ModeErrors
    mesh_error: ModeErrors


def _checked_speeds(engine: Engine, request: FrequencyRequest) -> list[_CheckedSpeed]:
    """Reductions and errors at each speed."""
    checks = []
    checked_angles = check_angle_indices(request.crank_angles, request.full_turn)
    angles = request.crank_angles[checked_angles]
    compared = on_compared_mesh(engine)
    for speed in request.crank_speeds.tolist():
        checked = converged_along(
            systems_at(engine, request, speed),
            request.crank_angles,
            speed,
            checked_angles,
            spare=SPARE_MODES,
            full_turn=request.full_turn,
        )
        own = checked.systems.engine
        error = mesh_error(
            checked.systems,
            angles,
            speed,
            compared=compared if own is engine else on_compared_mesh(own),
        )
        checks.append(
            _CheckedSpeed(
                checked.systems,
                checked.system.displacements(checked.modes.vectors),
                checked.reduction_error,
                error,
            )
        )
    return checks


def _map_on_mesh(
    engine: Engine,
    request: FrequencyRequest,
    checks: Sequence[_CheckedSpeed],
    report: LabelledProgress,
) -> EngineMap:
    """Map of one engine, speed by speed; a speed begins with the branches of the one before."""
    angles, modes = request.crank_angles, request.formulation.modes
    losses = StrainEnergyDamping.of(engine)
    numbering: IntArray | None = None
    start_shapes: NDArray[Any] | None = None
    parts, done = [], 0

    def advance(count: int) -> None:
        nonlocal done
        done += count
        report(engine.name, done, len(request.crank_speeds) * len(angles))

    for speed, check in zip(request.crank_speeds.tolist(), checks, strict=True):
        systems, shapes = check.systems, check.shapes
        if start_shapes is not None:
            numbering = same_shapes(start_shapes, shapes[0], numbering)
        start_shapes = shapes[0]
        count = shapes.shape[1]
        along = _along_angles(systems, count, request, speed, Tracker(numbering), losses, advance)
        errors = {
            "discretisation_error": check.mesh_error.frequency,
            "reduction_error": check.reduction_error.frequency,
            "mode_shape": scaled_parts(shapes[:, :modes]),
        }
        if systems.damped_by:
            errors |= {
                "damping_ratio_discretisation_error": check.mesh_error.damping_ratio,
                "damping_ratio_reduction_error": check.reduction_error.damping_ratio,
            }
        at = angles[check_angle_indices(angles, request.full_turn)]
        if losses is not None:
            found = damping_error(systems, at, speed)
            errors["strain_energy_damping_discretisation_error"] = found
        if systems.engine.mass == "lumped":
            errors["lumping_error"] = lumping_error(systems, at, speed)
        over_checks = {name: (OVER_CHECKS[: v.ndim], v) for name, v in errors.items()}
        part = along.isel(mode=slice(modes)).assign(over_checks)
        if may_flutter(engine):
            part = part.merge(flutter(systems, angles, speed))
        if request.formulation.prestress != "trajectory":
            part = part.assign(_extremes(systems, request, speed, part))
        parts.append(part)
    dataset = xr.concat(parts, pd.Index(request.crank_speeds, name="crank_speed"), join="inner")
    dataset.attrs["damped_by"] = checks[0].systems.damped_by
    used = tuple(check.systems for check in checks)
    if request.formulation.prestress == "trajectory":
        still = request.formulation.quasi_static
        calm = [replace(s, formulation=still, running=None) for s in used]
        pairs = zip(calm, request.crank_speeds.tolist(), strict=True)
        values = [frequencies_along(s, angles, speed) for s, speed in pairs]
        dataset["quasi_static_frequency"] = dataset["frequency"].copy(data=np.stack(values))
    return EngineMap(used, dataset)


def _along_angles(
    systems: Systems,
    count: int,
    request: FrequencyRequest,
    crank_speed: float,
    tracker: Tracker,
    losses: StrainEnergyDamping | None,
    advance: Callable[[int], None],
) -> xr.Dataset:
    """A number of modes along the crank angles, batch by batch: tracked, with spare ones."""
    parts = []
    asked = request.formulation.modes

    def between(crank_angles: FloatArray) -> Positions:
        frequency, shapes = [], []
        for system in systems.batches(crank_angles, crank_speed):
            modes = solve_modes(system, asked, count - asked)
            frequency.append(modes.frequency)
            shapes.append(system.inertial_shapes(modes.vectors))
        return Positions(crank_angles, np.concatenate(frequency), np.concatenate(shapes))

    for system in systems.batches(request.crank_angles, crank_speed):
        modes = solve_modes(system, asked, count - asked)
        tracker.add(system.inertial_shapes(modes.vectors))
        found = {"frequency": modes.frequency, "damping_ratio": modes.damping_ratio}
        if system.rigid_modes:
            found["shaft_frequency"] = np.abs(modes.rigid.imag).max(axis=1) / (2 * np.pi)
            found["shaft_growth_rate"] = modes.rigid.real.max(axis=1)
        if losses is not None:
            states = systems.states(system.motion.crank_angle)
            prestress = systems.formulation.quasi_static_prestress
            found["strain_energy_damping"] = losses.ratio(system, modes, prestress, states)
        parts.append(found)
        advance(len(modes.frequency))
    every = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    branches = tracker.finish(
        every["frequency"], request.crank_angles, full_turn=request.full_turn, between=between
    )
    every |= {
        "branch_of_mode": branches.branch.astype(np.int64) + 1,
        "mac": branches.mac,
        "veering": branches.veering,
        "branch_unclear": branches.unclear,
    }
    over = ("crank_angle", "mode")
    return xr.Dataset(
        {name: (over[: values.ndim], values) for name, values in every.items()}
        | {"branch_whole": ("branch", branches.whole)},
        coords={"branch": np.arange(1, count + 1)},
    )


def _extremes(
    systems: Systems, request: FrequencyRequest, crank_speed: float, found: xr.Dataset
) -> dict[str, tuple[str, FloatArray]]:
    """Lowest and highest frequency of each mode, between the crank angles too."""
    extremes = extremes_between(
        systems,
        request.crank_angles,
        np.array([crank_speed]),
        found["frequency"].values[None],
        known_error(found).values,
        full_turn=request.full_turn,
    )
    return {name: ("mode", values[0]) for name, values in vars(extremes).items()}
