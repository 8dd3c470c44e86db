"""Crank speeds at which the linkage finds no quasi-static equilibrium, by few crank angles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.errors import ComputationError
from flexmech.linear_system.position_errors import RefusedPositionsError
from flexmech.types import FloatArray

TURN = np.radians(np.arange(0.0, 360.0, 15.0))


def speeds_without_equilibrium(
    solver: LinkageSolver, speeds: Sequence[float]
) -> dict[float, ComputationError]:
    """Speeds without equilibrium, and why.

    The fastest speed is looked at all around. Where it fails, the slower ones are looked at where
    it failed, and so on with the fastest that is left, until one stands. A speed below that may
    still fail when it is solved for.

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
        found = {speed: _failure(solver, speed, angles) for speed in left}
        refused |= {speed: error for speed, error in found.items() if error is not None}
        left = [speed for speed in left if found[speed] is None]
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
