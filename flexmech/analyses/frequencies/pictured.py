"""What pictures show beside the map: points between its crank angles, and mode shapes asked for.

Between two crank angles of the map a line is straight, which shows where a frequency bends. There
the eigenvalues are solved for in between, halving steps until a straight line is as good as the
curve to the eye: every point of a line is a solution, none is interpolated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.datasets import rigid_positions
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.analyses.frequencies.extremes import MOST_STEP
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.arrays import FloatArray

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
        Of each crank speed.
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
        Of each crank speed.
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
