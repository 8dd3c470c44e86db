"""The error of component modes, and how many of them are enough."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.eigenproblem import Modes, solve_eigenvalues, solve_modes
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.inverse_iteration import (
    SAME,
    Pencil,
    newton_values,
    projected_values,
    responding_values,
    ritz_values,
)
from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import (
    GREAT_DETAIL,
    LinearSystem,
    LinkPencil,
    RotationTerms,
    StaticResponse,
    StressedLinks,
)
from flexmech.linkages import RigidMotion

logger = logging.getLogger(__name__)


# A reduction with a greater relative error in a frequency asked for is made finer; of damped
# links also one with a greater error in a damping ratio, relative to the ratio or, where that
# is about zero, absolute. Without damping, ratios are an effect of the frames alone.
REDUCTION_TOLERANCE = 2e-5
RATIO_TOLERANCE = 1e-3
RATIO_FLOOR = 1e-7
# Checked positions are some 30 deg apart. Beside those beyond this error the angles between are
# checked too: a link of neat resin was within 2e-5 at 0 and 30 deg and 1.3e-4 off at 5 deg.
SUSPICIOUS = REDUCTION_TOLERANCE / 2
# The first are tried in small steps, since most links need little more than the usual detail.
# Speed alone: where none is enough, the unreduced matrices are solved.
DETAILS = (1.0, 1.25, 2.0, GREAT_DETAIL, 2 * GREAT_DETAIL, 4 * GREAT_DETAIL)
# Steps of Newton's method to an unreduced eigenvalue: it converges in three or four.
MOST_STEPS = 8
# Of dense unreduced matrices of one kind in memory at a time. Memory alone.
MATRIX_BYTES = 4_000_000


@dataclass(frozen=True)
class ModeErrors:
    """How far the lowest modes are off, by component modes or by the mesh; positive, (B, m) each.

    Parameters
    ----------
    frequency : ndarray
        Relative.
    damping_ratio : ndarray
        Absolute.
    """

    frequency: FloatArray
    damping_ratio: FloatArray

    def at(self, positions: slice) -> ModeErrors:
        """The errors at some of the positions."""
        return ModeErrors(self.frequency[positions], self.damping_ratio[positions])

    def small(self, modes: Modes, *, damped: bool) -> NDArray[np.bool_]:
        """Where the reduction will do for modes, and their damping ratios, if ``damped``; (B,)."""
        accurate = np.asarray(np.all(self.frequency <= REDUCTION_TOLERANCE, axis=1))
        if not damped:
            return accurate
        ratio = np.abs(modes.damping_ratio[:, : self.damping_ratio.shape[1]])
        allowed = np.maximum(RATIO_TOLERANCE * ratio, RATIO_FLOOR)
        return np.asarray(accurate & np.all(self.damping_ratio <= allowed, axis=1))


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
    reduction_error : ModeErrors
        Of the modes asked for.
    """

    systems: Systems
    system: LinearSystem
    modes: Modes
    reduction_error: ModeErrors


def converged_modes(
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
        With the least ``detail`` to try.
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
    speed = np.broadcast_to(crank_speed, crank_angle.shape)
    # The stress is the same in whatever modes, and costs more than they do.
    if stressed is None:
        stressed = systems.stressed(crank_angle, speed)
    exact = UnreducedPositions(systems, crank_angle, speed, stressed)
    for detail in (each for each in DETAILS if each >= systems.detail):
        detailed = replace(systems, detail=detail)
        system = detailed.at(crank_angle, crank_speed, stressed)
        modes = solve_modes(system, count, max(0, min(spare, system.size - count)))
        if not systems.engine.component_modes:
            none = np.zeros((len(modes.frequency), count))
            return CheckedModes(detailed, system, modes, ModeErrors(none, none))
        error = reduction_error(exact, system, modes.lowest(count))
        small = error.small(modes, damped=systems.is_damped)
        if small.all():
            return CheckedModes(detailed, system, modes, error)
        logger.info(
            "component modes with detail %g are off by %.1e of a frequency and %.1e in a ratio",
            detail,
            error.frequency.max(),
            error.damping_ratio.max(),
        )
    unreduced = _without_component_modes(systems)
    return converged_modes(unreduced, crank_angle, crank_speed, spare, stressed)


def converged_along(
    systems: Systems,
    crank_angle: FloatArray,
    crank_speed: FloatArray | float,
    checks: IntArray,
    *,
    spare: int = 0,
    stressed: StressedLinks | None = None,
    full_turn: bool = False,
) -> CheckedModes:
    """Modes at some of many positions, with as many component modes as all of these need.

    Parameters
    ----------
    systems : Systems
    crank_angle : ndarray, shape (B,)
        In rad.
    crank_speed : ndarray, shape (B,), or float
        In rad/s.
    checks : ndarray of int, shape (c,)
        Numbers of the positions that are checked, ascending.
    spare : int
        As of :func:`converged_modes`.
    stressed : StressedLinks, optional
        In the checked positions; it is sought if left out.
    full_turn : bool
        Whether the first position comes after the last one.

    Returns
    -------
    CheckedModes
        Of the checked positions.
    """
    speed = np.broadcast_to(crank_speed, crank_angle.shape)
    if stressed is None:
        stressed = systems.stressed(crank_angle[checks], speed[checks])
    while True:
        checked = converged_modes(systems, crank_angle[checks], speed[checks], spare, stressed)
        error = checked.reduction_error.frequency
        suspicious = np.flatnonzero(error.max(axis=1) > SUSPICIOUS)
        beside = _beside(checks, suspicious, len(crank_angle), full_turn=full_turn)
        if not len(beside):
            return checked
        systems = checked.systems
        closer = converged_modes(systems, crank_angle[beside], speed[beside]).systems
        if closer.engine is systems.engine and closer.detail == systems.detail:
            return checked
        systems = closer


def _beside(checks: IntArray, which: IntArray, count: int, *, full_turn: bool) -> IntArray:
    """Up to two positions on each side of some checked ones, before the next that is checked."""
    ends = [checks[-1:] - count, checks[:1] + count] if full_turn else [checks[:1], checks[-1:]]
    around = np.concatenate([ends[0], checks, ends[1]])
    before, here, after = (around[which + shift] for shift in range(3))
    numbers = np.concatenate([np.linspace(before, here, 4), np.linspace(here, after, 4)])
    return np.setdiff1d(np.round(numbers).astype(np.intp) % count, checks)


def _without_component_modes(systems: Systems) -> Systems:
    return replace(systems, engine=systems.engine.unreduced(), detail=DETAILS[0])


@dataclass(frozen=True)
class UnreducedPositions:
    """Unreduced systems in B positions, few of which are in memory at a time: they are large.

    Parameters
    ----------
    systems : Systems
        Of the engine, which may reduce its links.
    crank_angle, crank_speed : ndarray, shape (B,)
    stressed : StressedLinks
        In these positions.
    """

    systems: Systems
    crank_angle: FloatArray
    crank_speed: FloatArray
    stressed: StressedLinks

    @cached_property
    def response(self) -> StaticResponse | None:
        """Static response, where elastic links are all that has a stiffness."""
        if not self._links_alone:
            return None
        engine = self.systems.engine
        tangent = None if self.stressed.unstressed else self.stressed.tangent
        links = engine.fixed_interface_links
        return StaticResponse(engine.topology, links, self._motion, tangent)

    @cached_property
    def moving(self) -> tuple[LinkPencil, StaticResponse] | None:
        """Pencil, and static response of straight links, where elastic links are all there is.

        Not of damped links: in turning frames their matrices are far from symmetric, and what the
        left eigenvectors miss counts to the first order.
        """
        engine = self.systems.engine
        turned = any(body.is_off_axis for link in engine.links for body in link.bodies)
        if turned or self.systems.is_damped or not self._links_alone:
            return None
        return (
            LinkPencil(engine.frames, self._motion, self.stressed, self._terms),
            StaticResponse(engine.topology, engine.fixed_interface_links, self._motion),
        )

    @property
    def _motion(self) -> RigidMotion:
        assert self.stressed.motion is not None
        return self.stressed.motion

    @property
    def _terms(self) -> RotationTerms:
        """Rotation terms that are counted; none at rest."""
        counted = self.systems.formulation.counted_terms
        return counted if self.crank_speed.any() else RotationTerms.all_or_none(False)

    @property
    def _links_alone(self) -> bool:
        """Whether elastic links are all that has a stiffness."""
        engine = self.systems.engine
        rigid = any(link.rigid for link in engine.links)
        held = self.stressed.guide_stiffness is not None or engine.connectors.any
        carried = engine.mechanism.frame is not None
        return not (rigid or held or carried or engine.rigid_modes)

    def pencils(self) -> Iterator[Pencil]:
        """Sparse matrices of each position."""
        count = len(self.crank_angle)
        engine = self.systems.engine
        at_a_time = max(1, MATRIX_BYTES // (8 * engine.frames.size**2))
        if at_a_time >= count:
            yield from self._every
        else:
            for start in range(0, count, at_a_time):
                yield from self._at(slice(start, start + at_a_time))

    @cached_property
    def _every(self) -> list[Pencil]:
        """Of few positions, which are asked for once for each detail."""
        return self._at(slice(None))

    def _at(self, part: slice) -> list[Pencil]:
        at = self.crank_angle[part], self.crank_speed[part], self.stressed.at(part)
        return Pencil.of_positions(self._unreduced.at(*at))

    @cached_property
    def _unreduced(self) -> Systems:
        return _without_component_modes(self.systems)


def reduction_error(
    unreduced: UnreducedPositions, reduced: LinearSystem, modes: Modes
) -> ModeErrors:
    """Error of reduced modes against the unreduced matrices.

    The reduced modes are improved by one step of inverse iteration on the unreduced
    matrices; what frequency and damping ratio still move by is the reduction's error.

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
    ModeErrors
    """
    engine = unreduced.systems.engine
    if reduced.is_conservative and (response := unreduced.response) is not None:
        masses = [link.mass for link in engine.links]
        improved = responding_values(response, masses, reduced.unreduced_links(modes.vectors))
    else:
        shapes = reduced.unreduced_vectors(modes.vectors, engine.frames)
        improved = _by_unreduced_matrices(unreduced, reduced, modes, shapes)
    better = Modes(improved, modes.vectors)
    return ModeErrors(
        frequency=np.abs(modes.frequency / better.frequency - 1),
        damping_ratio=np.abs(modes.damping_ratio - better.damping_ratio),
    )


def _by_unreduced_matrices(
    unreduced: UnreducedPositions, reduced: LinearSystem, modes: Modes, shapes: NDArray[Any]
) -> NDArray[np.complex128]:
    """Eigenvalues (B, m) of modes after a step on the unreduced matrices or on those of links."""
    if reduced.is_conservative:
        pencils = list(unreduced.pencils())
        return ritz_values(pencils, shapes, rigid=reduced.rigid_modes > 0)
    if (moving := unreduced.moving) is not None:
        return projected_values(*moving, modes.eigenvalues, shapes)
    return newton_values(list(unreduced.pencils()), modes.eigenvalues, shapes)


def unreduced_eigenvalues(
    systems: Systems, crank_angle: FloatArray, crank_speed: float
) -> NDArray[np.complex128]:
    """Lowest eigenvalues without the error of component modes.

    Parameters
    ----------
    systems : Systems
        In component modes.
    crank_angle : ndarray, shape (A,)
        In rad.
    crank_speed : float
        In rad/s.

    Returns
    -------
    ndarray, shape (A, modes)
        In rad/s; of the modes asked for, in ascending order.
    """
    unreduced = _without_component_modes(systems)
    frames, count = unreduced.engine.frames, systems.formulation.modes
    found = np.empty((len(crank_angle), count), dtype=complex)
    # One position at a time: unreduced matrices are large.
    for place in range(len(crank_angle)):
        angle = crank_angle[place : place + 1]
        stressed = systems.stressed(angle, crank_speed)
        reduced = systems.at(angle, crank_speed, stressed)
        modes = solve_modes(reduced, count)
        exact = UnreducedPositions(unreduced, angle, np.full(1, crank_speed), stressed)
        shapes = reduced.unreduced_vectors(modes.vectors, frames)
        pencils = list(exact.pencils())
        [values] = newton_values(pencils, modes.eigenvalues, shapes, steps=MOST_STEPS)
        values = values[np.argsort(np.abs(values))]
        # Two modes may have led to the same eigenvalue.
        alike = np.abs(np.diff(values)) <= SAME * np.abs(values[1:])
        if np.any(alike) or not np.all(np.isfinite(values)):
            values = solve_eigenvalues(unreduced.at(angle, crank_speed, stressed), count)[0]
        found[place] = values
    return found
