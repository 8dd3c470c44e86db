"""The error of component modes, and how many of them are enough."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from flexmech.analyses.frequencies.eigenproblem import Modes, solve_modes
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.linear_system import GREAT_DETAIL, LinearSystem, StressedLinks, inverse_mass_root
from flexmech.types import FloatArray

__all__ = ["CheckedModes", "ReductionError", "reduction_error", "settled"]

logger = logging.getLogger(__name__)


# A reduction with a greater relative error in a frequency asked for is made finer; of damped
# links also one with a greater error in a damping ratio, relative to the ratio or, where that
# is about zero, absolute. Without damping, ratios are an effect of the frames alone.
REDUCTION_TOLERANCE = 2e-5
RATIO_TOLERANCE = 1e-3
RATIO_FLOOR = 1e-7
DETAILS = (1.0, 2.0, GREAT_DETAIL, 2 * GREAT_DETAIL, 4 * GREAT_DETAIL)
# Of unreduced matrices of one kind that are held at a time.
MATRIX_BYTES = 4_000_000


@dataclass(frozen=True)
class ReductionError:
    """How far reduced modes are from those of the unreduced matrices; each of shape (B, m).

    Parameters
    ----------
    frequency : ndarray
        Relative.
    damping_ratio : ndarray
        Absolute.
    """

    frequency: FloatArray
    damping_ratio: FloatArray

    def is_small(self, modes: Modes, *, damped: bool) -> bool:
        """Whether the reduction will do for modes; their damping ratios too, if ``damped``."""
        accurate = bool(np.all(self.frequency <= REDUCTION_TOLERANCE))
        if not damped:
            return accurate
        ratio = np.abs(modes.damping_ratio[:, : self.damping_ratio.shape[1]])
        allowed = np.maximum(RATIO_TOLERANCE * ratio, RATIO_FLOOR)
        return accurate and bool(np.all(self.damping_ratio <= allowed))


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
    reduction_error : ReductionError
        Of the modes asked for.
    """

    systems: Systems
    system: LinearSystem
    modes: Modes
    reduction_error: ReductionError


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
        Within the tolerances of the unreduced matrices.
    """
    count = systems.formulation.modes
    unreduced = replace(systems, engine=systems.engine.unreduced(), detail=DETAILS[0])
    speed = np.broadcast_to(crank_speed, crank_angle.shape)
    # The stress is the same in whatever modes, and costs more than they do.
    stressed = systems.stressed(crank_angle, speed)
    for detail in DETAILS:
        detailed = replace(systems, detail=detail)
        system = detailed.at(crank_angle, crank_speed, stressed)
        modes = solve_modes(system, count, max(0, min(spare, system.size - count)))
        if not systems.engine.component_modes:
            exact = np.zeros((len(modes.frequency), count))
            return CheckedModes(detailed, system, modes, ReductionError(exact, exact))
        lowest = modes.lowest(count)
        error = reduction_error(unreduced, crank_angle, speed, system, lowest, stressed)
        if error.is_small(modes, damped=systems.is_damped):
            return CheckedModes(detailed, system, modes, error)
        logger.info(
            "component modes with detail %g are off by %.1e of a frequency and %.1e in a ratio",
            detail,
            error.frequency.max(),
            error.damping_ratio.max(),
        )
    return settled(unreduced, crank_angle, crank_speed, spare)


def reduction_error(
    unreduced: Systems,
    crank_angle: FloatArray,
    crank_speed: FloatArray,
    reduced: LinearSystem,
    modes: Modes,
    stressed: StressedLinks,
) -> ReductionError:
    """Error of reduced modes against the unreduced matrices.

    The reduced modes are improved by one step of inverse iteration on the unreduced
    matrices; what frequency and damping ratio still move by is the reduction's error. Few
    positions are held at a time: unreduced matrices are large.

    Parameters
    ----------
    unreduced : Systems
    crank_angle, crank_speed : ndarray, shape (B,)
    reduced : LinearSystem
        In these positions.
    modes : Modes
        Of ``reduced``; m of them.
    stressed : StressedLinks
        In these positions.

    Returns
    -------
    ReductionError
    """
    frames, improved = unreduced.engine.frames, np.empty_like(modes.eigenvalues)
    shapes = reduced.unreduced_vectors(modes.vectors, frames)
    at_a_time = max(1, MATRIX_BYTES // (8 * frames.size**2))
    for start in range(0, len(crank_angle), at_a_time):
        part = slice(start, start + at_a_time)
        full = unreduced.at(crank_angle[part], crank_speed[part], stressed.at(part))
        improved[part] = (
            _inverse_iteration(full, shapes[part])
            if full.is_conservative
            else _newton_step(full, modes.eigenvalues[part], shapes[part])
        )
        del full  # before the next ones are built
    better = Modes(improved, modes.vectors)
    return ReductionError(
        frequency=np.abs(modes.frequency / better.frequency - 1),
        damping_ratio=np.abs(modes.damping_ratio - better.damping_ratio),
    )


def _inverse_iteration(full: LinearSystem, shapes: NDArray[Any]) -> NDArray[np.complex128]:
    """Eigenvalues after one step of inverse iteration in the space of the shapes (B, n, m)."""
    loads = full.mass @ shapes
    if full.rigid_modes:
        return _shifted_iteration(full, loads, shapes)
    better = np.linalg.solve(full.stiffness, loads)
    adjoint = np.swapaxes(better, 1, 2)
    return _in_space(adjoint @ full.mass @ better, adjoint @ loads)


def _shifted_iteration(
    full: LinearSystem, loads: FloatArray, shapes: FloatArray
) -> NDArray[np.complex128]:
    """The same about minus the lowest square: of rigid modes the stiffness has no inverse."""
    square = np.einsum("bi,bij,bj->b", *[shapes[..., 0], full.stiffness, shapes[..., 0]])
    square /= np.einsum("bi,bi->b", shapes[..., 0], loads[..., 0])
    better = np.linalg.solve(full.stiffness + square[:, None, None] * full.mass, loads)
    adjoint = np.swapaxes(better, 1, 2)
    return _in_space(adjoint @ full.mass @ better, adjoint @ full.stiffness @ better)


def _in_space(inertia: FloatArray, stiffness: FloatArray) -> NDArray[np.complex128]:
    """Eigenvalues in a space, in which mass and stiffness are given."""
    lower = inverse_mass_root(inertia)
    values = np.linalg.eigvalsh(lower @ stiffness @ np.swapaxes(lower, 1, 2))
    return np.asarray(1j * np.sqrt(values))


def _newton_step(
    full: LinearSystem, eigenvalues: NDArray[np.complex128], shapes: NDArray[Any]
) -> NDArray[np.complex128]:
    """One Newton step on ``P(lambda) x = 0`` for each mode (Ruhe 1973, eq. 3.5).

    Links are chains of elements: few entries of the unreduced matrices are not zero.
    """
    improved = np.empty_like(eigenvalues)
    for position, of_modes in enumerate(eigenvalues):
        mass, damping, stiffness = _sparse(
            full.mass[position], full.damping[position], full.stiffness[position]
        )
        for mode, value in enumerate(of_modes):
            x = shapes[position, :, mode].astype(complex)
            inertia = mass @ x
            dynamic = mass.astype(complex)
            dynamic.data = value * (value * mass.data + damping.data) + stiffness.data
            better = splu(dynamic).solve(2 * value * inertia + damping @ x)
            improved[position, mode] = value - np.vdot(inertia, x) / np.vdot(inertia, better)
    return improved


def _sparse(*matrices: FloatArray) -> list[csc_array]:
    """Matrices (n, n) with their entries at the same places, those that are zero in none."""
    taken = np.any([matrix.T != 0 for matrix in matrices], axis=0)
    columns, rows = np.nonzero(taken)
    starts = np.concatenate([[0], np.cumsum(taken.sum(axis=1))])
    return [
        csc_array((matrix[rows, columns], rows, starts), shape=matrix.shape) for matrix in matrices
    ]
