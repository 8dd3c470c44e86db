"""The error of component modes, and how many of them are enough."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.eigenproblem import Modes, solve_modes
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.linear_system import LinearSystem
from flexmech.types import FloatArray

__all__ = ["CheckedModes", "reduction_error", "settled"]

logger = logging.getLogger(__name__)


# A reduction with a greater relative error in a frequency asked for is made finer.
REDUCTION_TOLERANCE = 2e-5
DETAILS = (1.0, 2.0, 4.0)


@dataclass(frozen=True)
class CheckedModes:
    """Modes of some positions and how far the reduction may be off.

    Parameters
    ----------
    systems : Systems
        With as many component modes as are accurate enough, or without any.
    system : LinearSystem
        Batch of B positions.
    modes : Modes
        The modes asked for and spare ones.
    reduction_error : ndarray, shape (B, modes asked for)
        Relative.
    """

    systems: Systems
    system: LinearSystem
    modes: Modes
    reduction_error: FloatArray


def settled(
    systems: Systems, crank_angle: FloatArray, crank_speed: FloatArray | float, spare: int = 0
) -> CheckedModes:
    """Modes with as many component modes as they need.

    Parameters
    ----------
    systems : Systems
    crank_angle : ndarray, shape (B,)
        Positions to check, in rad.
    crank_speed : ndarray, shape (B,), or float
        In rad/s.
    spare : int
        Modes to solve for besides those that must be accurate.

    Returns
    -------
    CheckedModes
        Within ``REDUCTION_TOLERANCE`` of the unreduced matrices.
    """
    count = systems.formulation.modes
    unreduced = replace(systems, engine=systems.engine.unreduced(), detail=DETAILS[0])
    full = unreduced.at(crank_angle, crank_speed) if systems.engine.component_modes else None
    for detail in DETAILS:
        detailed = replace(systems, detail=detail)
        system = detailed.at(crank_angle, crank_speed)
        modes = solve_modes(system, min(count + spare, max(count, system.size)))
        if full is None:
            exact = np.zeros((len(modes.frequency), count))
            return CheckedModes(detailed, system, modes, exact)
        error = reduction_error(full, system, modes)[:, :count]
        if np.all(error <= REDUCTION_TOLERANCE):
            return CheckedModes(detailed, system, modes, error)
        logger.info("component modes with detail %g are off by %.1e", detail, error.max())
    return settled(unreduced, crank_angle, crank_speed, spare)


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
