"""A range of crank speeds: those without equilibrium, and windows as narrow as is needed."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, pairwise

import numpy as np

from flexmech.analyses.parallel import in_order
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.mechanics.joints.position_errors import RefusedPositionsError
from flexmech.solvers.stability import NODES, SERIES_TOLERANCE, LinkageSolver, SpeedWindow

# What has no equilibrium has none over twenty degrees of the turn or more.
TURN = np.radians(np.arange(0.0, 360.0, 15.0))


def speeds_without_equilibrium(
    solver: LinkageSolver, speeds: Sequence[float]
) -> dict[float, ComputationError]:
    """Speeds without equilibrium, and why.

    The fastest speed is looked at all around. Where it fails, the slower ones are looked at where
    it failed, and so on with the fastest that is left, until one has an equilibrium. A
    speed below that may still fail when it is solved for.

    Parameters
    ----------
    solver : LinkageSolver
    speeds : sequence of float
        rad/s, by increasing size.

    Returns
    -------
    dict of float to ComputationError
    """
    refused: dict[float, ComputationError] = {}
    left = list(speeds)
    while left:
        failure = _failure(solver, left[-1], TURN)
        if failure is None:
            break
        refused[left.pop()] = failure
        if not isinstance(failure, RefusedPositionsError) or not len(failure.crank_angles):
            continue
        angles = failure.crank_angles[[0, -1]]
        failures = {speed: _failure(solver, speed, angles) for speed in left}
        refused |= {speed: error for speed, error in failures.items() if error is not None}
        left = [speed for speed in left if failures[speed] is None]
    return refused


def _failure(
    solver: LinkageSolver, crank_speed: float, crank_angle: FloatArray
) -> ComputationError | None:
    motion = solver.engine.mechanism.linkage.motion(crank_angle, crank_speed)
    try:
        solver.engine.stressed_links(motion, solver.quasi_static)
    except ComputationError as error:
        return error
    return None


logger = logging.getLogger(__name__)

Ends = tuple[float, float]
ForEach = Callable[[Callable[[Ends], list[SpeedWindow]], Sequence[Ends]], list[list[SpeedWindow]]]
"""From a task and the ends of windows to the windows of each."""

# Width of windows over the lowest natural frequency: with six nodes their error is 1e-8 far from
# the last equilibrium. Windows that are narrower than the least relative width save nothing. The
# relative error of the system's matrix by interpolation is that between crank angles.
WINDOW = 1 / 40
NARROWEST = 0.02
WINDOW_TOLERANCE = SERIES_TOLERANCE


def window_ends(speeds: Sequence[float], lowest: float) -> list[tuple[float, float]]:
    """Ends of the windows to try first; the fastest, which take longest, come first.

    Parameters
    ----------
    speeds : sequence of float
        rad/s, of one sign.
    lowest : float
        Lowest natural frequency in rad/s.

    Returns
    -------
    list of tuple of float
    """
    low, high = min(speeds), max(speeds)
    count = int(np.ceil((high - low) / (WINDOW * lowest)))
    ends = list(pairwise(np.linspace(low, high, count + 1).tolist()))
    return sorted(ends, key=lambda pair: -abs(sum(pair)))


def windows_are_cheaper(speeds: Sequence[float], lowest: float) -> bool:
    """Whether windows have fewer nodes than there are speeds."""
    return NODES * len(window_ends(speeds, lowest)) < len(speeds)


def narrow_windows(solver: LinkageSolver, ends: tuple[float, float]) -> list[SpeedWindow]:
    """Windows between two speeds, as narrow as interpolation needs them.

    None is left where there is no equilibrium, or where it changes too fast: there each speed is
    solved for by itself.

    Parameters
    ----------
    solver : LinkageSolver
    ends : tuple of float
        rad/s.

    Returns
    -------
    list of SpeedWindow
    """
    low, high = ends
    try:
        window = solver.window(low, high)
    except ComputationError as refusal:
        logger.info("no window from %g to %g rad/s: %s", low, high, refusal)
    else:
        if window.error <= WINDOW_TOLERANCE:
            return [window]
    if high - low < NARROWEST * abs(high):
        return []
    middle = (low + high) / 2
    return [*narrow_windows(solver, (low, middle)), *narrow_windows(solver, (middle, high))]


def with_windows(
    solver: LinkageSolver, speeds: Sequence[float], lowest: float, each: ForEach | None = None
) -> LinkageSolver:
    """The solver with windows over a range of crank speeds.

    Parameters
    ----------
    solver : LinkageSolver
    speeds : sequence of float
        rad/s, of one sign.
    lowest : float
        Lowest natural frequency in rad/s.
    each : callable, optional
        See :data:`ForEach`; in several processes by default.

    Returns
    -------
    LinkageSolver
    """
    task, ends = partial(narrow_windows, solver), window_ends(speeds, lowest)
    opened = list(in_order(task, ends)) if each is None else each(task, ends)
    return replace(solver, windows=tuple(sorted(chain(*opened), key=lambda window: window.low)))
