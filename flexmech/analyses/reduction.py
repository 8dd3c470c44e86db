"""The error of component modes, and how many of them are enough."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.eigenproblem import Modes, solve_modes
from flexmech.linear_system import Engine, LinearSystem
from flexmech.types import FloatArray

__all__ = ["CheckedModes", "accurate_reduction", "reduction_error"]

logger = logging.getLogger(__name__)


# A reduction with a greater relative error in a frequency asked for is made finer.
REDUCTION_TOLERANCE = 2e-5
DETAILS = (1.0, 2.0, 4.0)


@dataclass(frozen=True)
class CheckedModes:
    """Modes of some positions and how far the reduction may be off.

    Parameters
    ----------
    engine : Engine
        With component modes, or without where they were not accurate enough.
    detail : float
        How many of them; see :meth:`flexmech.linear_system.Engine.linear_system`.
    system : LinearSystem
        Batch of B positions.
    modes : Modes
        The modes asked for and spare ones.
    reduction_error : ndarray, shape (B, modes asked for)
        Relative.
    """

    engine: Engine
    detail: float
    system: LinearSystem
    modes: Modes
    reduction_error: FloatArray


def accurate_reduction(
    engine: Engine, build: Callable[[Engine, float], LinearSystem], count: int, spare: int = 0
) -> CheckedModes:
    """Modes with as many component modes as they need.

    Parameters
    ----------
    engine : Engine
    build : callable
        ``build(engine, detail)`` gives the linear system of the positions to check.
    count, spare : int
        Modes that must be accurate, and modes to solve for besides.

    Returns
    -------
    CheckedModes
        Within ``REDUCTION_TOLERANCE`` of the unreduced matrices.
    """
    full = build(engine.unreduced(), DETAILS[0]) if engine.component_modes else None
    for detail in DETAILS:
        system = build(engine, detail)
        modes = solve_modes(system, min(count + spare, max(count, system.size)))
        if full is None:
            exact = np.zeros((len(modes.frequency), count))
            return CheckedModes(engine, detail, system, modes, exact)
        error = reduction_error(full, system, modes)[:, :count]
        if np.all(error <= REDUCTION_TOLERANCE):
            return CheckedModes(engine, detail, system, modes, error)
        logger.info("component modes with detail %g are off by %.1e", detail, error.max())
    return accurate_reduction(engine.unreduced(), build, count, spare)


def reduction_error(full: LinearSystem, reduced: LinearSystem, modes: Modes) -> FloatArray:
    """Relative error of the reduced frequencies against the unreduced matrices.

    The reduced modes are improved by one step of inverse iteration on the unreduced
    matrices; what the frequency still moves by is the reduction's error.

    Parameters
    ----------
    full, reduced : LinearSystem
        The same batch of B positions.
    modes : Modes
        Of ``reduced``.

    Returns
    -------
    ndarray, shape (B, m)
    """
    shapes = reduced.unreduced_vectors(modes.vectors, full.frames)
    if full.is_conservative:
        loads = full.mass @ shapes
        better = np.linalg.solve(full.stiffness, loads)
        adjoint = np.swapaxes(better, 1, 2)
        inertia, stiffness = adjoint @ full.mass @ better, adjoint @ loads
        lower = np.linalg.inv(np.linalg.cholesky(inertia))
        values = np.linalg.eigvalsh(lower @ stiffness @ np.swapaxes(lower, 1, 2))
        return np.abs(modes.frequency / (np.sqrt(values) / (2 * np.pi)) - 1)
    improved = _newton_step(full, modes.eigenvalues, shapes)
    return np.abs(np.abs(modes.eigenvalues) / np.abs(improved) - 1)


def _newton_step(
    full: LinearSystem, eigenvalues: NDArray[np.complex128], shapes: NDArray[Any]
) -> NDArray[np.complex128]:
    """One Newton step on ``P(lambda) x = 0`` for each mode (Ruhe 1973, eq. 3.5)."""
    improved = np.empty_like(eigenvalues)
    for mode in range(eigenvalues.shape[1]):
        value = eigenvalues[:, mode, None, None]
        slope = 2 * value * full.mass + full.damping
        dynamic = value**2 * full.mass + value * full.damping + full.stiffness
        x = shapes[:, :, mode, None]
        weight = np.swapaxes((full.mass @ x).conj(), 1, 2)
        change = (weight @ x) / (weight @ np.linalg.solve(dynamic, slope @ x))
        improved[:, mode] = eigenvalues[:, mode] - change[:, 0, 0]
    return improved
