"""Geometrically nonlinear quasi-static equilibrium under the rigid motion's inertia forces.

Newton's method on corotational beams, over a batch of positions at once. The loads are
dead: distributed over the undeformed links, fixed in direction at the instant.

A slender link that bends by a step w shortens by the square of its slopes, and until the next step
takes it back, the tension EA w'^2 / 2 of that stretch would be the greatest stress of all: the
tangent with it is far too stiff across the link. Here each tangent is taken with the tension to
which the step's own linear equations lead, as if tension were an unknown besides the displacements
(Magisano, Leonetti & Garcea 2017, Computer Methods in Applied Mechanics and Engineering 313,
986-1005). The equilibrium is the same, and is reached in one or two steps less.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
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
from flexmech.reference.corotational import CorotationalElements, LinearStrain
from flexmech.reference.linkage_tangents import LinkageTangents
from flexmech.reference.nodal_chains import (
    chain_matrix,
    element_ends,
    node_forces,
    relative_coordinates,
)
from flexmech.types import FloatArray, IntArray

__all__ = ["Equilibrium"]

logger = logging.getLogger(__name__)


# Least length of a Newton step when the full one makes the out-of-balance forces worse.
SHORTEST_STEP = 1 / 16
# With all load at once, a position that takes longer wanders: it is loaded in steps.
FIRST_ITERATIONS = 8
# Newton's method takes its last step where that turns no section, and moves no node by a part
# of the linkage's size, by more than this. The error that is left is the step's square times at
# most 8000 on random mechanisms, loaded twice as much as at their speeds: 2e-11. Forces out of
# balance are no measure: one that is lost in the round-off of a stiff link may bend a soft one that
# is pinned to it.
LAST_STEP = 5e-8


@dataclass(frozen=True)
class _State:
    """Where Newton's method stands over a batch of positions: z and factors end with it."""

    z: FloatArray
    error: FloatArray
    factors: FloatArray
    converged: NDArray[np.bool_]

    @classmethod
    def unloaded(cls, size: int, batch: int) -> _State:
        """No displacement, nothing solved yet."""
        return cls(
            np.zeros((size, batch)), np.zeros(batch), np.zeros(0), np.zeros(batch, dtype=bool)
        )

    @property
    def is_stable(self) -> NDArray[np.bool_]:
        """Which positions have converged, to a tangent stiffness that is positive."""
        if not self.converged.any():
            return self.converged
        return np.asarray(self.converged & np.all(self.factors[:, 0] > 0, axis=0))

    def with_part(self, which: IntArray, part: _State) -> _State:
        """The state with some positions replaced; all of them at first."""
        if len(which) == len(self.error):
            return part
        for own, new in ((self.z, part.z), (self.factors, part.factors)):
            own[..., which] = new
        self.error[which] = part.error
        self.converged[which] = part.converged
        return self


@dataclass(frozen=True)
class _Imbalance:
    """How far displacements are from equilibrium, and what leads to it.

    Parameters
    ----------
    residual : ndarray, shape (size, B)
        Outer minus inner forces.
    band : ndarray
        Tangent stiffness in band form, positions last.
    strains : list of LinearStrain
        Of each link's elements.
    """

    residual: FloatArray
    band: FloatArray
    strains: list[LinearStrain]

    @property
    def error(self) -> FloatArray:
        """Greatest force out of balance, shape (B,)."""
        return np.asarray(np.abs(self.residual).max(axis=0, initial=0.0), dtype=float)

    def at(self, which: NDArray[np.bool_]) -> _Imbalance:
        """That of some positions."""
        strains = [strain.of(which) for strain in self.strains]
        return _Imbalance(self.residual[:, which], self.band[..., which], strains)


@dataclass(frozen=True)
class _Problem:
    """What the linkage is in equilibrium with in a batch of positions, and how it stands there.

    Parameters
    ----------
    outer : ndarray, shape (size, B)
        Forces on the linkage.
    extra : list of ndarray, shape (e, r, r, B)
        Stiffness that comes with them, by each element's relative coordinates.
    turns : list of list of ndarray, shape (2, 2, B)
        Rotation of each link's following ends from their leaders' frames.
    swelling : float
        Part of the swelling that has come on.
    """

    outer: FloatArray
    extra: list[FloatArray]
    turns: list[list[FloatArray]]
    swelling: float = 1.0

    def loaded(self, part: float) -> _Problem:
        """With a part of the load, and of the swelling."""
        extra = [part * e for e in self.extra]
        return _Problem(part * self.outer, extra, self.turns, part)

    def at(self, which: NDArray[np.bool_] | IntArray) -> _Problem:
        """That of some positions."""
        return _Problem(
            self.outer[:, which],
            [e[..., which] for e in self.extra],
            [[turn[..., which] for turn in turns] for turns in self.turns],
            self.swelling,
        )


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
        self._tangents = LinkageTangents(frames, self._links)
        self._force_scale = min(
            e.section.bending_stiffness / float(e.length.sum()) ** 2 for e in links
        )
        self._turned_by = _turns(frames, links)[:, None]

    def solve(
        self,
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        extra: Sequence[FloatArray],
        near: Sequence[FloatArray] | None = None,
    ) -> list[FloatArray]:
        """Elastic displacement of each link in its frame at equilibrium.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link)
            Forces on each link in its frame.
        extra : sequence of ndarray, shape (B, e, 2 p, 2 p)
            Stiffness of each element besides that of the corotational beam; a rigid
            displacement meets none.
        near : sequence of ndarray, shape (B, n_link), optional
            Displacements from which Newton's method starts. Where it leads to no stable
            equilibrium from there, and by default, it starts from straight links.

        Returns
        -------
        list of ndarray, shape (B, n_link)

        Raises
        ------
        ComputationError
            If Newton's method does not converge or the equilibrium is unstable; names the
            crank angle and speed.
        """
        problem = _Problem(
            self.frames.gather(motion, loads).T.copy(),
            self._by_relative_coordinates(extra),
            self._tangents.turns(motion),
        )
        state = _State.unloaded(*problem.outer.shape)
        if near is not None:
            state = self._newton(self._tangents.coordinates(near), problem, FIRST_ITERATIONS)
        left = np.flatnonzero(~state.is_stable)
        if len(left):
            straight = np.zeros((len(problem.outer), len(left)))
            found = self._newton(straight, problem.at(left), FIRST_ITERATIONS)
            state = state.with_part(left, found)
        for steps in LOAD_STEPS[1:]:
            left = np.flatnonzero(~state.converged)
            if not len(left):
                break
            logger.info("%d positions are loaded in %d steps", len(left), steps)
            state = state.with_part(left, self._in_steps(problem.at(left), steps))
        self._refuse_divergence(motion, state)
        self._refuse_instability(motion, state.factors)
        return [q.T for q in self._tangents.link_displacement(state.z, problem.turns)]

    def _in_steps(self, problem: _Problem, steps: int) -> _State:
        """Newton's method with the load brought on in steps; who fails in one is left there."""
        state = _State.unloaded(*problem.outer.shape)
        which = np.arange(problem.outer.shape[1])
        for part in np.arange(1, steps + 1) / steps:
            loaded = problem.at(which).loaded(float(part))
            moved = self._newton(state.z[:, which], loaded, MAX_ITERATIONS)
            state = state.with_part(which, moved)
            which = which[moved.converged]
            if not len(which):
                break
        return state

    def _newton(self, z: FloatArray, problem: _Problem, iterations: int) -> _State:
        """Newton's method from displacements z; the positions that have converged drop out."""
        state = _State.unloaded(*z.shape)
        which, order = np.arange(z.shape[1]), self._tangents.order
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            imbalance = self._out_of_balance(z, problem)
            for _ in range(iterations):
                factors = banded.factorize(imbalance.band)
                change = np.empty_like(z)
                change[order] = banded.solve(factors, imbalance.residual[order])
                change[:, state.converged[which]] = 0.0
                turned = np.abs(change * self._turned_by).max(axis=0, initial=0.0)
                last = turned <= LAST_STEP
                z = z + np.where(last, change, 0.0)
                state = state.with_part(which, _State(z, imbalance.error, factors, last))
                if last.all():
                    break
                change[:, last] = 0.0
                if 2 * np.count_nonzero(last) > len(last):
                    rest = ~last
                    which, problem, imbalance = which[rest], problem.at(rest), imbalance.at(rest)
                    z, change = z[:, rest], change[:, rest]
                z, imbalance = self._advance(z, change, problem, imbalance)
        return state

    def response(
        self, displacement: Sequence[FloatArray], extra: Sequence[FloatArray]
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Internal forces and tangents of the links at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)
        extra : sequence of ndarray, shape (B, e, 2 p, 2 p)
            Stiffness of each element besides that of the corotational beam; a rigid
            displacement meets none.

        Returns
        -------
        list of ndarray, shape (B, n_link)
            Forces on the nodes.
        list of ndarray, shape (B, n_link, n_link)
            Tangent of each link.
        """
        forces, tangents = [], []
        relative_extra = self._by_relative_coordinates(extra)
        for link, q, more in zip(self._links, displacement, relative_extra, strict=True):
            relative = relative_coordinates(q.T, self._per_node)
            force, tangent, _ = link.relative_response(relative)
            force += (more * relative[:, None]).sum(axis=2)
            tangent += more
            forces.append(node_forces(force, self._per_node).T)
            tangents.append(chain_matrix(link.of_nodes(tangent)))
        return forces, tangents

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

    def _by_relative_coordinates(self, extra: Sequence[FloatArray]) -> list[FloatArray]:
        """Element matrices (B, e, 2 p, 2 p) by relative coordinates, (e, r, r, B)."""
        own = self._links[0].relative_part
        return [np.ascontiguousarray(np.moveaxis(e, 0, -1)[:, own[:, None], own]) for e in extra]

    def _advance(
        self, z: FloatArray, change: FloatArray, problem: _Problem, before: _Imbalance
    ) -> tuple[FloatArray, _Imbalance]:
        """One Newton step, shortened where it overshoots beyond the elastic scale."""
        length = np.ones(z.shape[1])
        loaded = np.abs(problem.outer).max(axis=0, initial=0.0)
        limit = np.maximum(10 * before.error, 1e3 * loaded)
        while True:
            trial = z + length * change
            imbalance = self._out_of_balance(trial, problem, before.strains)
            worse = ~(imbalance.error <= np.maximum(limit, self._force_scale * 1e3))
            if not np.any(worse & (length > SHORTEST_STEP)):
                return trial, imbalance
            length[worse] = np.maximum(length[worse] / 2, SHORTEST_STEP)

    def _out_of_balance(
        self, z: FloatArray, problem: _Problem, before: Sequence[LinearStrain] | None = None
    ) -> _Imbalance:
        """How displacements (size, B) stand, which a step from ``before`` has led to."""
        inner, strains = [], []
        entries = self._tangents.entries(z.shape[1])
        displacement = self._tangents.link_displacement(z, problem.turns)
        for number, (link, q) in enumerate(zip(self._links, displacement, strict=True)):
            relative, extra = relative_coordinates(q, self._per_node), problem.extra[number]
            force, tangent, strain = link.relative_response(
                relative,
                problem.swelling,
                None if before is None else before[number],
                out=entries.of_link(number),
            )
            force += (extra * relative[:, None]).sum(axis=2)
            tangent += extra
            inner.append(node_forces(force, self._per_node))
            strains.append(strain)
        residual = problem.outer - self._tangents.gather(inner, problem.turns)
        return _Imbalance(residual, self._tangents.band(entries, problem.turns), strains)

    def _refuse_instability(self, motion: RigidMotion, factors: FloatArray) -> None:
        refuse_positions(
            motion,
            np.any(factors[:, 0] <= 0, axis=0),
            "the linkage buckles under its inertia forces",
            ": the tangent stiffness is not positive; lower the crank speed or stiffen the links",
        )

    def _refuse_divergence(self, motion: RigidMotion, state: _State) -> None:
        failed = ~state.converged
        if not failed.any():
            return
        worst = float(np.nan_to_num(state.error[failed], nan=np.inf).max())
        refuse_positions(
            motion,
            failed,
            "no quasi-static equilibrium",
            f": Newton's method left {worst:.3g} N out of balance, even in {LOAD_STEPS[-1]} load "
            "steps; lower the crank speed, or use prestress 'axial'",
        )


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
