"""Geometrically nonlinear quasi-static equilibrium under the rigid motion's inertia forces.

Newton's method on corotational beams, over a batch of positions at once. The loads are
dead: distributed over the undeformed links, fixed in direction at the instant.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from flexmech.beams.elements import BeamElements
from flexmech.linear_system import (
    LOAD_STEPS,
    MAX_ITERATIONS,
    LinkFrames,
    refuse_positions,
)
from flexmech.linkages import RigidMotion
from flexmech.reference import banded
from flexmech.reference.corotational import CorotationalElements
from flexmech.types import FloatArray, IntArray

__all__ = ["Equilibrium"]

logger = logging.getLogger(__name__)


# Least length of a Newton step when the full one makes the out-of-balance forces worse.
SHORTEST_STEP = 1 / 16
# Newton's method takes its last step where that turns no section, and moves no node by a part
# of the linkage's size, by more than this. The error that is left goes with the square of the
# step over a link's thickness to length. Forces out of balance are no measure: one that is
# lost in the round-off of a stiff link may bend a soft one that is pinned to it.
LAST_STEP = 1e-9


@dataclass(frozen=True)
class _State:
    """Where Newton's method stands over a batch of positions."""

    z: FloatArray
    error: FloatArray
    factors: FloatArray
    converged: NDArray[np.bool_]

    @classmethod
    def unloaded(cls, shape: tuple[int, ...]) -> _State:
        """No displacement, nothing solved yet."""
        return cls(np.zeros(shape), np.zeros(shape[0]), np.zeros(0), np.zeros(shape[0], dtype=bool))

    def with_part(self, which: IntArray, part: _State) -> _State:
        """The state with some positions replaced; all of them at first."""
        if len(which) == len(self.z):
            return part
        for own, new in ((self.z, part.z), (self.error, part.error)):
            own[which] = new
        self.factors[..., which] = part.factors
        self.converged[which] = part.converged
        return self


@dataclass(frozen=True)
class _Loads:
    """Forces on the linkage (B, size), stiffness that comes with them, and part of the swelling."""

    outer: FloatArray
    extra: list[FloatArray]
    swelling: float

    def at(self, which: NDArray[np.bool_]) -> _Loads:
        """Those of some positions."""
        return _Loads(self.outer[which], [e[which] for e in self.extra], self.swelling)


class Equilibrium:
    """Solver for the equilibrium of one linkage on one mesh.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    links : sequence of BeamElements
        Of each link, all of one kind.
    """

    def __init__(self, frames: LinkFrames, links: Sequence[BeamElements]) -> None:
        self.frames = frames
        self._links = [CorotationalElements(elements) for elements in links]
        self._per_node = links[0].shapes.per_node
        counts = [len(elements.length) for elements in links]
        rows, columns = _entries(frames, counts, self._per_node)
        self._order, self._width = _narrow_band(frames.size, rows, columns)
        self._scatter = _band_scatter(rows, columns, self._order, self._width)
        self._force_scale = min(
            e.section.bending_stiffness / float(e.length.sum()) ** 2 for e in links
        )
        self._turned_by = _turns(frames, links)

    def solve(
        self, motion: RigidMotion, loads: Sequence[FloatArray], extra: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """Elastic displacement of each link in its frame at equilibrium.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link)
            Forces on each link in its frame.
        extra : sequence of ndarray, shape (B, e, 2 p, 2 p)
            Stiffness of each element besides that of the corotational beam.

        Returns
        -------
        list of ndarray, shape (B, n_link)

        Raises
        ------
        ComputationError
            If Newton's method does not converge or the equilibrium is unstable; names the
            crank angle and speed.
        """
        outer = self.frames.gather(motion, loads)
        for steps in LOAD_STEPS:
            state = _State.unloaded(outer.shape)
            for part in np.arange(1, steps + 1) / steps:
                loads_now = _Loads(part * outer, [part * e for e in extra], float(part))
                state = self._newton(motion, state.z, loads_now)
                if not state.converged.all():
                    break
            else:
                self._refuse_instability(motion, state.factors)
                return self._link_displacement(motion, state.z)
            logger.info("no equilibrium in %d load steps", steps)
        self._refuse_divergence(motion, state)
        raise AssertionError("unreachable")

    def _newton(self, motion: RigidMotion, z: FloatArray, loads: _Loads) -> _State:
        """Newton's method from displacements z; the positions that have converged drop out."""
        state = _State.unloaded(z.shape)
        which = np.arange(len(z))
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            residual, band = self._out_of_balance(motion, z, loads)
            error = np.abs(residual).max(axis=1, initial=0.0)
            for _ in range(MAX_ITERATIONS):
                factors = banded.factorize(band)
                change = np.empty_like(z)
                change[:, self._order] = banded.solve(factors, residual.T[self._order]).T
                change[state.converged[which]] = 0.0
                turned = np.abs(change * self._turned_by).max(axis=1, initial=0.0)
                last = turned <= LAST_STEP
                z = z + np.where(last[:, None], change, 0.0)
                state = state.with_part(which, _State(z, error, factors, last))
                if last.all():
                    break
                change[last] = 0.0
                if 2 * np.count_nonzero(last) > len(last):
                    rest = ~last
                    which, motion, loads = which[rest], motion.at(rest), loads.at(rest)
                    z, change, error = z[rest], change[rest], error[rest]
                z, residual, band, error = self._advance(motion, z, change, loads, error)
        return state

    def response(
        self, displacement: Sequence[FloatArray], extra: Sequence[FloatArray]
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Internal forces and tangents of the links at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)
        extra : sequence of ndarray, shape (B, e, 2 p, 2 p)
            Stiffness of each element besides that of the corotational beam.

        Returns
        -------
        list of ndarray, shape (B, n_link)
            Forces on the nodes.
        list of ndarray, shape (B, e, 2 p, 2 p)
            Tangent of each element.
        """
        parts = [self._response(i, q, extra[i], 1.0) for i, q in enumerate(displacement)]
        return [force for force, _ in parts], [tangent for _, tangent in parts]

    def damping(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Kelvin-Voigt damping matrix of each element at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        list of ndarray, shape (B, e, 2 p, 2 p)
        """
        return [
            link.damping(element_ends(q, self._per_node))
            for link, q in zip(self._links, displacement, strict=True)
        ]

    def _response(
        self, link: int, displacement: FloatArray, extra: FloatArray, swelling: float
    ) -> tuple[FloatArray, FloatArray]:
        size = self._per_node
        ends = element_ends(displacement, size)
        force, tangent = self._links[link].response(ends, swelling)
        force = force + (extra @ ends[..., None])[..., 0]
        total = np.zeros((len(ends), force.shape[1] + 1, size))
        total[:, :-1] += force[..., :size]
        total[:, 1:] += force[..., size:]
        return total.reshape(len(ends), -1), tangent + extra

    def _link_displacement(self, motion: RigidMotion, z: FloatArray) -> list[FloatArray]:
        parts = self.frames.link_coordinates(motion, z[:, :, None])
        return [np.asarray(part[:, :, 0], dtype=float) for part in parts]

    def _advance(
        self,
        motion: RigidMotion,
        z: FloatArray,
        change: FloatArray,
        loads: _Loads,
        error: FloatArray,
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """One Newton step, shortened where it overshoots beyond the elastic scale."""
        length = np.ones(len(z))
        limit = np.maximum(10 * error, 1e3 * np.abs(loads.outer).max(axis=1, initial=0.0))
        while True:
            trial = z + length[:, None] * change
            residual, band = self._out_of_balance(motion, trial, loads)
            new_error = np.abs(residual).max(axis=1, initial=0.0)
            worse = ~(new_error <= np.maximum(limit, self._force_scale * 1e3))
            if not np.any(worse & (length > SHORTEST_STEP)):
                return trial, residual, band, new_error
            length[worse] = np.maximum(length[worse] / 2, SHORTEST_STEP)

    def _out_of_balance(
        self, motion: RigidMotion, z: FloatArray, loads: _Loads
    ) -> tuple[FloatArray, FloatArray]:
        """Outer minus inner forces (B, size) and the tangent in band form."""
        inner, entries = [], []
        for number, q in enumerate(self._link_displacement(motion, z)):
            force, tangent = self._response(number, q, loads.extra[number], loads.swelling)
            inner.append(force)
            self._turn_followers(motion, number, tangent)
            entries.append(tangent.reshape(len(z), -1))
        residual = loads.outer - self.frames.gather(motion, inner)
        stacked = np.concatenate(entries, axis=1)
        band = (self._scatter @ stacked.T).reshape(self.frames.size, self._width + 1, len(z))
        return residual, band

    def _turn_followers(self, motion: RigidMotion, link: int, tangent: FloatArray) -> None:
        size = self._per_node
        last = self.frames.links[link].size - size
        for turning in self.frames.turning_pairs(motion, link):
            at_start = turning.pair[0] == 0
            element, pair = (0, slice(0, 2)) if at_start else (-1, slice(size, size + 2))
            assert turning.pair[0] in (0, last)
            tangent[:, element, :, pair] = tangent[:, element, :, pair] @ turning.turn
            back = np.swapaxes(turning.turn, 1, 2)
            tangent[:, element, pair, :] = back @ tangent[:, element, pair, :]

    def _refuse_instability(self, motion: RigidMotion, factors: FloatArray) -> None:
        refuse_positions(
            motion,
            np.any(factors[:, 0] <= 0, axis=0),
            "the linkage buckles under its inertia forces",
            ": the tangent stiffness is not positive; lower the crank speed or stiffen the links",
        )

    def _refuse_divergence(self, motion: RigidMotion, state: _State) -> None:
        failed = ~state.converged
        worst = float(np.nan_to_num(state.error[failed], nan=np.inf).max())
        refuse_positions(
            motion,
            failed,
            "no quasi-static equilibrium",
            f": Newton's method left {worst:.3g} N out of balance, even in {LOAD_STEPS[-1]} load "
            "steps; lower the crank speed, or use prestress 'axial'",
        )


def element_ends(q: FloatArray, per_node: int) -> FloatArray:
    """Coordinates of both nodes of each element; (B, p (e + 1)) -> (B, e, 2 p)."""
    nodal = q.reshape(len(q), -1, per_node)
    return np.concatenate([nodal[:, :-1], nodal[:, 1:]], axis=2)


def _turns(frames: LinkFrames, links: Sequence[BeamElements]) -> FloatArray:
    """Angle in rad that a unit of each coordinate of z stands for, shape (size,).

    A displacement stands for its part of the shortest link, a curvature for the turn over its
    link.
    """
    lengths = [float(elements.length.sum()) for elements in links]
    shapes = links[0].shapes
    scale = np.zeros(frames.size)
    for target, length in zip(frames.targets, lengths, strict=True):
        own = np.arange(len(target)) % shapes.per_node
        angle = np.where(np.isin(own, shapes.angles), 1.0, length)
        angle[own < 2] = 1.0 / min(lengths)
        scale[target[target >= 0]] = angle[target >= 0]
    return scale


def _entries(frames: LinkFrames, counts: Sequence[int], per_node: int) -> tuple[IntArray, IntArray]:
    """Row and column in z of every entry of every element matrix; -1 where held."""
    rows, columns = [], []
    for link, count in enumerate(counts):
        local = per_node * np.arange(count)[:, None] + np.arange(2 * per_node)
        target = frames.targets[link][local]
        shape = (count, 2 * per_node, 2 * per_node)
        rows.append(np.broadcast_to(target[:, :, None], shape).ravel())
        columns.append(np.broadcast_to(target[:, None, :], shape).ravel())
    return np.concatenate(rows), np.concatenate(columns)


def _narrow_band(size: int, rows: IntArray, columns: IntArray) -> tuple[IntArray, int]:
    """Order of the coordinates (reverse Cuthill-McKee) and half band width in it."""
    free = (rows >= 0) & (columns >= 0)
    graph = scipy.sparse.csr_matrix(
        (np.ones(free.sum()), (rows[free], columns[free])), shape=(size, size)
    )
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(graph, symmetric_mode=True)
    place = np.argsort(order)
    width = int(np.abs(place[rows[free]] - place[columns[free]]).max())
    return np.asarray(order, dtype=np.intp), width


def _band_scatter(
    rows: IntArray, columns: IntArray, order: IntArray, width: int
) -> scipy.sparse.csr_matrix:
    """Sparse map from stacked element entries to the lower band, row-major (n, width + 1)."""
    place = np.argsort(order)
    used = np.flatnonzero((rows >= 0) & (columns >= 0))
    below = place[rows[used]] - place[columns[used]]
    used, below = used[below >= 0], below[below >= 0]
    slot = place[columns[used]] * (width + 1) + below
    return scipy.sparse.csr_matrix(
        (np.ones(len(used)), (slot, used)), shape=(len(order) * (width + 1), len(rows))
    )
