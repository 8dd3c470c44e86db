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
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.elements import BeamElements
from flexmech.beams.link_matrices import Coupling
from flexmech.linear_system import (
    LAST_STEP,
    LESS_LOADED,
    LOAD_STEPS,
    MAX_ITERATIONS,
    BucklingError,
    DeadMoments,
    EquilibriumError,
    LinkFrames,
    RigidGeometricStiffness,
    chain_matrix,
    refuse_positions,
)
from flexmech.linkages import JointSpring, RigidMotion
from flexmech.reference import banded
from flexmech.reference.corotational import CorotationalElements
from flexmech.reference.coupled_links import CoupledLinks
from flexmech.reference.element_numbers import by_elements, in_positions
from flexmech.reference.force_balance import ForceBalance
from flexmech.reference.linkage_tangents import LinkageTangents, angle_per_unit
from flexmech.reference.newton_state import Imbalance, Problem, State
from flexmech.reference.nodal_chains import element_ends, node_forces, relative_coordinates
from flexmech.reference.radial_springs import RadialSprings

logger = logging.getLogger(__name__)


# Least length of a Newton step when the full one makes the out-of-balance forces worse: four
# halvings, after which loading in steps costs less.
SHORTEST_STEP = 1 / 16
# A bound of work: with all load at once five iterations do; a position that takes longer wanders
# and is loaded in steps.
FIRST_ITERATIONS = 8
# A full step may make forces out of balance this much greater, or as great as this times the forces
# between nodes and the loads: stretching by the square of a turn, which the next step takes back.
ALLOWED_GROWTH, ALLOWED_FORCES = 10, 1e3


class Equilibrium:
    """Newton solver for the equilibrium of one linkage on one mesh.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    links : mapping of int to BeamElements
        Of each flexible link by its number, all of one kind.
    springs : sequence of JointSpring
        The radial ones join ends that the frames do not constrain.
    couplings : mapping of int to Coupling, optional
        Of links whose elements are not all of their stiffness.
    stable_alone : bool
        Whether links that are unstable without springs and turning forces are refused.
    """

    def __init__(
        self,
        frames: LinkFrames,
        links: Mapping[int, BeamElements],
        springs: Sequence[JointSpring] = (),
        couplings: Mapping[int, Coupling] | None = None,
        *,
        stable_alone: bool = True,
    ) -> None:
        self._stable_alone = stable_alone
        self.frames = frames
        self._links = {n: CorotationalElements(elements) for n, elements in links.items()}
        self._per_node = next(iter(links.values())).shapes.per_node
        self._springs = RadialSprings(frames, springs)
        self._couplings = dict(couplings or {})
        coupled = CoupledLinks(frames, self._couplings)
        joined = [*self._springs.columns, *coupled.columns]
        self._tangents = LinkageTangents(frames, self._links, joined)
        self._balance = ForceBalance(
            self._links, self._tangents, self._springs, coupled, self._per_node
        )
        scales = [e.section.bending_stiffness / e.length.sum(axis=-1) ** 2 for e in links.values()]
        self._force_scale = np.asarray(np.min(scales, axis=0))
        self._angle_per_unit = angle_per_unit(frames, links)

    def solve(
        self,
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        extra: Sequence[FloatArray],
        dead: DeadMoments,
        near: Sequence[FloatArray] | None = None,
    ) -> list[FloatArray]:
        """Elastic displacement of each link in its frame at equilibrium.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link)
            Forces on each link in its frame.
        extra : sequence of ndarray, shape (e, r, r, B)
            Stiffness of each element besides that of the corotational beam, by its relative
            coordinates.
        dead : DeadMoments
            Of bodies and rigid links.
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
        outer = self.frames.gather(motion, loads).T.copy()
        problem = Problem(
            outer,
            extra,
            self._tangents.ties(motion, np.zeros_like(outer)),
            motion,
            dead,
            [load.T for load in loads] if self._tangents.ties_move else None,
        )
        start = np.zeros_like(outer) if near is None else self._tangents.coordinates(motion, near)
        state = self._newton(start, problem, FIRST_ITERATIONS)
        left = np.flatnonzero(~state.is_stable)
        if near is not None and len(left):
            straight = np.zeros((len(outer), len(left)))
            found = self._newton(straight, problem.at(left), FIRST_ITERATIONS)
            state = state.with_part(left, found)
        for steps in LOAD_STEPS[1:]:
            left = np.flatnonzero(~state.converged)
            if not len(left):
                break
            logger.info("%d positions are loaded in %d steps", len(left), steps)
            state = state.with_part(left, self._in_steps(problem.at(left), steps))
        self._refuse_divergence(motion, state)
        if self._stable_alone:
            self._refuse_instability(motion, state.factors)
        ties = self._balance.ties(state.z, problem)
        return [q.T for q in self._tangents.link_displacement(state.z, ties)]

    def by_relative_coordinates(self, matrices: Sequence[FloatArray]) -> list[FloatArray]:
        """Matrices of the links' elements by relative coordinates.

        Parameters
        ----------
        matrices : sequence of ndarray, shape (B, e, 2 p, 2 p)
            Of each flexible link, in nodal coordinates; a rigid displacement meets no force.

        Returns
        -------
        list of ndarray, shape (e, r, r, B)
        """
        own = next(iter(self._links.values())).relative_part
        return [np.ascontiguousarray(np.moveaxis(e, 0, -1)[:, own[:, None], own]) for e in matrices]

    def stiffness_of_rigid(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        beside: Sequence[FloatArray],
        dead: DeadMoments,
    ) -> RigidGeometricStiffness:
        """Geometric stiffness of rigid links and sliders at given displacements.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement, beside : sequence of ndarray, shape (B, n_link)
            Where each link is, and outer less inner forces on it there.
        dead : DeadMoments
            As in :meth:`solve`.

        Returns
        -------
        RigidGeometricStiffness
        """
        displaced = self.frames.displaced_ties_by(motion, displacement)
        columns = [q.T for q in displacement]
        inner = [-each.T for each in beside]
        rotation_stiffness = self._springs.add_forces(motion, columns, inner, displaced)
        found = displaced.geometric_stiffness([-each.T for each in inner], dead.by_link(columns))
        return replace(found, rotation_stiffness=found.rotation_stiffness + rotation_stiffness)

    def _in_steps(self, problem: Problem, steps: int) -> State:
        """Newton's method in load steps; positions that fail are left at their last step."""
        state = State.unloaded(*problem.outer.shape)
        which = np.arange(problem.outer.shape[1])
        for part in np.arange(1, steps + 1) / steps:
            loaded = problem.at(which).loaded(float(part))
            moved = self._newton(in_positions(state.z, which), loaded, MAX_ITERATIONS)
            state = state.with_part(which, moved)
            which = which[moved.converged]
            if not len(which):
                break
        return state

    def _newton(self, z: FloatArray, problem: Problem, iterations: int) -> State:
        """Newton's method from displacements z, without the positions that have converged."""
        state = State.unloaded(*z.shape)
        which = np.arange(z.shape[1])
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            imbalance = self._balance.imbalance(z, problem)
            for _ in range(iterations):
                factors = banded.factorize(imbalance.band)
                change = self._change(factors, imbalance.residual)
                change[:, state.converged[which]] = 0.0
                last = self._turned(change, problem) <= LAST_STEP
                z = z + np.where(last, change, 0.0)
                state = state.with_part(which, State(z, imbalance.error, factors, last))
                if last.all():
                    break
                change[:, last] = 0.0
                if 2 * np.count_nonzero(last) > len(last):
                    rest = np.flatnonzero(~last)
                    which, problem, imbalance = which[rest], problem.at(rest), imbalance.at(rest)
                    z, change = in_positions(z, rest), in_positions(change, rest)
                z, imbalance = self._advance(z, change, problem, imbalance)
        return state

    def _change(self, factors: FloatArray, residual: FloatArray) -> FloatArray:
        """Change of the displacements (size, B) by which a tangent balances forces (size, B)."""
        change, order = np.empty_like(residual), self._tangents.order
        change[order] = banded.solve(factors, residual[order])
        return change

    def _turned(self, change: FloatArray, problem: Problem) -> FloatArray:
        """Greatest rotation in rad of a change (size, B) of the displacements, (B,)."""
        design = problem.motion.design
        scale = self._angle_per_unit
        if design is not None:
            scale = in_positions(scale, design)
        return np.asarray(np.abs(change * scale).max(axis=0, initial=0.0), dtype=float)

    def response(
        self,
        displacement: Sequence[FloatArray],
        extra: Sequence[FloatArray],
        design: IntArray | None = None,
    ) -> tuple[list[FloatArray], dict[int, FloatArray]]:
        """Internal forces and tangents of the links at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)
        extra : sequence of ndarray, shape (e, r, r, B)
            Stiffness of each element besides that of the corotational beam, by its relative
            coordinates.
        design : ndarray of int, shape (B,), optional
            Of each position of several designs.

        Returns
        -------
        list of ndarray, shape (B, n_link)
            Forces on the nodes; none of a rigid link.
        dict of int to ndarray or ChainMatrix, shape (B, n_link, n_link)
            Tangent of each flexible link.
        """
        forces, nodal = [np.zeros_like(q) for q in displacement], []
        for (number, link), more in zip(self._links.items(), extra, strict=True):
            q = displacement[number]
            relative = relative_coordinates(q.T, self._per_node)
            force, tangent, _ = link.relative_response(relative, design=design)
            force += by_elements(more, relative)
            tangent += more
            forces[number] = node_forces(force, self._per_node).T
            nodal.append(np.ascontiguousarray(np.moveaxis(link.of_nodes(tangent), -1, 0)))
        tangents = dict(zip(self._links, map(chain_matrix, nodal), strict=True))
        for number, coupling in self._couplings.items():
            bent = displacement[number] @ coupling.rows.T - coupling.unloaded
            forces[number] += bent @ coupling.elastic @ coupling.rows
            tangents[number] = tangents[number] + coupling.stiffness
        return forces, tangents

    def damping(
        self, displacement: Sequence[FloatArray], design: IntArray | None = None
    ) -> dict[int, FloatArray]:
        """Kelvin-Voigt damping matrix of each element at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)
        design : ndarray of int, shape (B,), optional
            Of each position of several designs.

        Returns
        -------
        dict of int to ndarray, shape (B, e, 2 p, 2 p)
            Of each flexible link.
        """
        return {
            number: link.damping(element_ends(displacement[number], self._per_node), design)
            for number, link in self._links.items()
        }

    def damping_stiffness(
        self, displacement: Sequence[FloatArray], rate: Sequence[FloatArray]
    ) -> dict[int, FloatArray]:
        """Derivative of each element's damping forces by its displacement at given rates.

        Parameters
        ----------
        displacement, rate : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        dict of int to ndarray, shape (B, e, 2 p, 2 p)
            Of each flexible link.
        """
        return {
            number: link.damping_stiffness(
                *(element_ends(q[number], self._per_node) for q in (displacement, rate))
            )
            for number, link in self._links.items()
        }

    def _advance(
        self, z: FloatArray, change: FloatArray, problem: Problem, before: Imbalance
    ) -> tuple[FloatArray, Imbalance]:
        """One Newton step, with line search where it overshoots."""
        length = np.ones(z.shape[1])
        loaded = np.abs(problem.outer).max(axis=0, initial=0.0)
        limit = np.maximum(ALLOWED_GROWTH * before.error, ALLOWED_FORCES * loaded)
        design = problem.motion.design
        scale = self._force_scale if design is None else self._force_scale[design]
        while True:
            trial = z + length * change
            imbalance = self._balance.imbalance(trial, problem, before.strains)
            worse = ~(imbalance.error <= np.maximum(limit, scale * ALLOWED_FORCES))
            if not np.any(worse & (length > SHORTEST_STEP)):
                return trial, imbalance
            length[worse] = np.maximum(length[worse] / 2, SHORTEST_STEP)

    def _refuse_instability(self, motion: RigidMotion, factors: FloatArray) -> None:
        refuse_positions(
            motion,
            np.any(factors[:, 0] <= 0, axis=0),
            "the linkage buckles under its loads",
            f": the tangent stiffness is not positive; {LESS_LOADED} or stiffen the links",
            BucklingError,
        )

    def _refuse_divergence(self, motion: RigidMotion, state: State) -> None:
        failed = ~state.converged
        if not failed.any():
            return
        worst = float(np.nan_to_num(state.error[failed], nan=np.inf).max())
        refuse_positions(
            motion,
            failed,
            "no quasi-static equilibrium",
            f": Newton's method left {worst:.3g} N out of balance, even in {LOAD_STEPS[-1]} load "
            f"steps; {LESS_LOADED}, or use prestress 'axial'",
            EquilibriumError,
        )
