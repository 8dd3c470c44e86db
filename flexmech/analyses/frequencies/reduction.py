"""The error of component modes, and how many of them are enough."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.band_form import BandForm
from flexmech.analyses.frequencies.eigenproblem import Modes, solve_modes
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.sparse_improvement import sparse_improved
from flexmech.linear_system import (
    GREAT_DETAIL,
    ChainMatrix,
    LinearSystem,
    RotationTerms,
    SparsePositions,
    StressedLinks,
    diagonal,
    inverse_mass_root,
)
from flexmech.types import FloatArray

logger = logging.getLogger(__name__)


# A reduction with a greater relative error in a frequency asked for is made finer; of damped
# links also one with a greater error in a damping ratio, relative to the ratio or, where that
# is about zero, absolute. Without damping, ratios are an effect of the frames alone.
REDUCTION_TOLERANCE = 2e-5
RATIO_TOLERANCE = 1e-3
RATIO_FLOOR = 1e-7
DETAILS = (1.0, 1.25, 2.0, GREAT_DETAIL, 2 * GREAT_DETAIL, 4 * GREAT_DETAIL)
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
    systems: Systems,
    crank_angle: FloatArray,
    crank_speed: FloatArray | float,
    spare: int = 0,
    stressed: StressedLinks | None = None,
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
    stressed : StressedLinks, optional
        In these positions; it is sought if left out.

    Returns
    -------
    CheckedModes
        Within the tolerances of the unreduced matrices.
    """
    count = systems.formulation.modes
    unreduced = replace(systems, engine=systems.engine.unreduced(), detail=DETAILS[0])
    speed = np.broadcast_to(crank_speed, crank_angle.shape)
    # The stress is the same in whatever modes, and costs more than they do.
    if stressed is None:
        stressed = systems.stressed(crank_angle, speed)
    exact = UnreducedPositions(unreduced, crank_angle, speed, stressed)
    for detail in DETAILS:
        detailed = replace(systems, detail=detail)
        system = detailed.at(crank_angle, crank_speed, stressed)
        modes = solve_modes(system, count, max(0, min(spare, system.size - count)))
        if not systems.engine.component_modes:
            none = np.zeros((len(modes.frequency), count))
            return CheckedModes(detailed, system, modes, ReductionError(none, none))
        error = reduction_error(exact, system, modes.lowest(count))
        if error.is_small(modes, damped=systems.is_damped):
            return CheckedModes(detailed, system, modes, error)
        logger.info(
            "component modes with detail %g are off by %.1e of a frequency and %.1e in a ratio",
            detail,
            error.frequency.max(),
            error.damping_ratio.max(),
        )
    return settled(unreduced, crank_angle, crank_speed, spare, stressed)


@dataclass(frozen=True)
class UnreducedPositions:
    """Unreduced systems in B positions, few of which are held at a time: they are large.

    Parameters
    ----------
    systems : Systems
        Of the unreduced engine.
    crank_angle, crank_speed : ndarray, shape (B,)
    stressed : StressedLinks
        In these positions.
    """

    systems: Systems
    crank_angle: FloatArray
    crank_speed: FloatArray
    stressed: StressedLinks

    @cached_property
    def sparse(self) -> SparsePositions | None:
        """Sparse matrices, where links have many elements and nothing else has a stiffness."""
        engine, formulation = self.systems.engine, self.systems.formulation
        links = engine.frames.links
        chains = any(isinstance(link.stiffness, ChainMatrix) for link in links)
        massless = any(not (link.rigid or diagonal(link.mass).all()) for link in links)
        if not chains or massless or engine.rigid_modes or engine.connectors.any:
            return None
        if self.stressed.guiding is not None:
            return None
        motion = engine.mechanism.linkage.motion(self.crank_angle, self.crank_speed)
        terms = formulation.rotation_terms
        if not isinstance(terms, RotationTerms):
            terms = RotationTerms.all_or_none(bool(terms))
        if not motion.crank_speed.any():
            terms = RotationTerms.all_or_none(False)
        return SparsePositions(engine.frames, motion, self.stressed, terms)

    def parts(self) -> Iterator[tuple[slice, LinearSystem]]:
        """Runs of positions and their systems; those of a single run are kept."""
        if self._at_a_time >= len(self.crank_angle):
            yield slice(None), self._every
            return
        for start in range(0, len(self.crank_angle), self._at_a_time):
            part = slice(start, start + self._at_a_time)
            yield part, self._at(part)

    @cached_property
    def _every(self) -> LinearSystem:
        return self._at(slice(None))

    @property
    def _at_a_time(self) -> int:
        return max(1, MATRIX_BYTES // (8 * self.systems.engine.frames.size**2))

    def _at(self, part: slice) -> LinearSystem:
        return self.systems.at(
            self.crank_angle[part], self.crank_speed[part], self.stressed.at(part)
        )


def reduction_error(
    unreduced: UnreducedPositions, reduced: LinearSystem, modes: Modes
) -> ReductionError:
    """Error of reduced modes against the unreduced matrices.

    The reduced modes are improved by one step of inverse iteration on the unreduced
    matrices; what frequency and damping ratio still move by is the reduction's error. Links of
    many elements have sparse ones.

    Parameters
    ----------
    unreduced : UnreducedPositions
        B of them.
    reduced : LinearSystem
        In these positions.
    modes : Modes
        Of ``reduced``; m of them.

    Returns
    -------
    ReductionError
    """
    improved = np.empty_like(modes.eigenvalues)
    shapes = reduced.unreduced_vectors(modes.vectors, unreduced.systems.engine.frames)
    if unreduced.sparse is not None:
        for position, values in enumerate(modes.eigenvalues):
            matrices = unreduced.sparse.at(position)
            improved[position] = sparse_improved(matrices, values, shapes[position])
    else:
        for part, full in unreduced.parts():
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
    # Round-off of lengths or stiffnesses beyond all proportion: of such a mode nothing is known.
    return np.asarray(1j * np.sqrt(np.where(values < 0, np.nan, values)))


def _newton_step(
    full: LinearSystem, eigenvalues: NDArray[np.complex128], shapes: NDArray[Any]
) -> NDArray[np.complex128]:
    """One Newton step on ``P(lambda) x = 0`` for each mode (Ruhe 1973, eq. 3.5)."""
    band = BandForm.of(full.mass, full.damping, full.stiffness)
    mass, damping, stiffness = map(band.entries, (full.mass, full.damping, full.stiffness))
    inertia = full.mass @ shapes
    right = 2 * eigenvalues[:, None] * inertia + full.damping @ shapes
    shapes, inertia, right = (
        np.swapaxes(columns[:, band.order], 1, 2) for columns in (shapes, inertia, right)
    )
    improved = eigenvalues.copy()
    for position, values in enumerate(eigenvalues[..., None]):
        dynamic = values * (values * mass[position] + damping[position]) + stiffness[position]
        better = band.solve(dynamic, right[position])
        of_modes = inertia[position].conj()
        change = (of_modes * shapes[position]).sum(axis=1) / (of_modes * better).sum(axis=1)
        # Where the matrix is singular the value is an eigenvalue.
        improved[position] -= np.where(np.isnan(better[:, 0]), 0.0, change)
    return improved
