"""Geometrically nonlinear quasi-static equilibrium under the rigid motion's inertia forces.

Newton's method on corotational beams, over a batch of positions at once. The loads are
dead: distributed over the undeformed links, fixed in direction at the instant.

A slender link that bends by a step w shortens by the square of its slopes, and until the next step
takes it back, the tension EA w'^2 / 2 of that stretch would be the greatest stress of all: the
tangent with it is far too stiff across the link. Here each tangent is taken with the tension to
which the step's own linear equations lead, as if tension were an unknown besides the displacements
(Magisano, Leonetti & Garcea 2017, Computer Methods in Applied Mechanics and Engineering 313,
986-1005). The equilibrium is the same, and is reached in one or two steps less.

Forces and tangents are those of all displaced links at all crank angles; arrays inside end with the
batch of positions.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import RigidMotion
from flexmech.mechanics import (
    LAST_STEP,
    LESS_LOADED,
    LOAD_STEPS,
    MAX_ITERATIONS,
    BucklingError,
    Connectors,
    DeadMoments,
    EquilibriumError,
    LinkFrames,
    refuse_positions,
)
from flexmech.mechanics.beams.elements import Chain
from flexmech.reference.assembly import (
    LinkageAssembly,
    LinkRows,
    RadialSprings,
    Ties,
    angle_per_unit,
    solve_band,
)
from flexmech.reference.corotational import (
    CorotationalElements,
    ElementResponse,
    LinearStrain,
    by_elements,
    in_positions,
)


@dataclass(frozen=True)
class Problem:
    """Loads of the equilibrium in a batch of positions.

    Parameters
    ----------
    motion : RigidMotion
    loads : sequence of ndarray, shape (n_link, B)
        Forces on each link.
    greatest : ndarray, shape (B,)
        Greatest force of them on the linkage where it is not displaced.
    extra : sequence of ndarray, shape (e, r, r, B)
        Stiffness that comes with them, by each element's relative coordinates.
    dead : DeadMoments
        Dead of bodies and rigid links.
    ties : Ties, optional
        Constraints where they do not depend on the displacement.
    swelling : float
        Part of the swelling that has come on.
    """

    motion: RigidMotion
    loads: Sequence[FloatArray]
    greatest: FloatArray
    extra: Sequence[FloatArray]
    dead: DeadMoments
    ties: Ties | None
    swelling: float = 1.0

    def loaded(self, fraction: float) -> Problem:
        """The problem with a part of the loads and of the swelling."""
        loads, extra = ([fraction * x for x in arrays] for arrays in (self.loads, self.extra))
        dead, greatest = self.dead.scaled(fraction), fraction * self.greatest
        return Problem(self.motion, loads, greatest, extra, dead, self.ties, fraction)

    def at(self, which: IntArray) -> Problem:
        """Quantities of some positions."""
        loads, extra = (
            [in_positions(x, which) for x in arrays] for arrays in (self.loads, self.extra)
        )
        greatest, ties = self.greatest[which], self.ties and self.ties.at(which)
        motion, dead = self.motion.at(which), self.dead.at(which)
        return Problem(motion, loads, greatest, extra, dead, ties, self.swelling)


@dataclass(frozen=True)
class Imbalance:
    """Residual and tangent at displacements.

    Parameters
    ----------
    residual : ndarray, shape (size, B)
        Outer minus inner forces.
    band : ndarray, shape (size, width + 1, B)
        Tangent stiffness in band form.
    strains : list of LinearStrain
        Strains of each link's elements.
    """

    residual: FloatArray
    band: FloatArray
    strains: list[LinearStrain]

    @property
    def error(self) -> FloatArray:
        """Greatest force out of balance, shape (B,)."""
        return np.asarray(np.abs(self.residual).max(axis=0, initial=0.0), dtype=float)

    def at(self, which: IntArray) -> Imbalance:
        """Quantities of some positions."""
        strains = [strain.of(which) for strain in self.strains]
        residual, band = (in_positions(values, which) for values in (self.residual, self.band))
        return Imbalance(residual, band, strains)


class ForceBalance:
    """Forces and tangents of one linkage on one mesh.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the unreduced links.
    chains : mapping of int to Chain
        Each flexible link by its number, all of one kind of elements.
    connectors : Connectors
        Whose radial springs join ends that the frames do not constrain.

    Attributes
    ----------
    links : dict of int to CorotationalElements
        The flexible ones.
    assembly : LinkageAssembly
    """

    def __init__(
        self, frames: LinkFrames, chains: Mapping[int, Chain], connectors: Connectors
    ) -> None:
        self.frames = frames
        self.links = {n: CorotationalElements(chain.elements) for n, chain in chains.items()}
        self._connectors, self._springs = connectors, RadialSprings(frames, connectors)
        # Energies of whole links, which have off-axis plies between joints. A rigid rotation of the
        # link has no curvature, to first order in the rotations of elements against it.
        self._couplings = {n: x.coupling for n, x in chains.items() if x.coupling is not None}
        every = {n: np.arange(frames.links[n].size) for n in self._couplings}
        self._coupled = {n: LinkRows(frames, n, rows) for n, rows in every.items()}
        joined = [*self._springs.columns, *(rows.columns for rows in self._coupled.values())]
        self.assembly = LinkageAssembly(frames, self.links, joined)

    def imbalance(
        self, z: FloatArray, problem: Problem, before: Sequence[LinearStrain] | None = None
    ) -> Imbalance:
        """Residual forces and tangent stiffness at displacements.

        Parameters
        ----------
        z : ndarray, shape (size, B)
        problem : Problem
        before : sequence of LinearStrain, optional
            Strains of each link's elements where a step came from that has led to z; see
            :meth:`CorotationalElements.response`.

        Returns
        -------
        Imbalance
        """
        motion, dead = problem.motion, problem.dead
        entries, ties = self.assembly.entries(z.shape[1]), problem.ties
        if ties is None:
            ties = self.assembly.ties(motion, z)
        displacement = self.assembly.link_displacement(z, ties)
        inner, strains = [np.zeros_like(q) for q in displacement], []
        for place, (number, extra) in enumerate(zip(self.links, problem.extra, strict=True)):
            response = self._response(
                number,
                displacement[number],
                extra,
                problem.swelling,
                None if before is None else before[place],
                entries[1][number],
            )
            inner[number] = self.links[number].on_nodes(response.force)
            strains.append(response.strain)
        dead.add_forces(inner, displacement)
        by_rotation = {}
        for link, (rows, stiffness) in dead.rotation_stiffness(displacement).items():
            if link not in self.links:
                by_rotation[link] = stiffness[0]
                continue
            elements, tangent = self.links[link], entries[1][link]
            per_node = elements.elements.shapes.per_node
            element = np.minimum(rows // per_node, len(tangent) - 1)
            place = elements.relative_places[rows - per_node * element]
            tangent[element, place, place] += stiffness
        self._add_coupling(displacement, inner, problem.swelling)
        for push in self._connectors.radial_forces(motion, [q.T for q in displacement]):
            link, q = push.point.link, displacement[push.point.link].T
            inner[link] -= push.on_link(motion, q).T
            if push.point.rigid:
                by_rotation[link] = by_rotation[link] + push.rotation_stiffness(motion, q)
        unbalanced = [load - force for load, force in zip(problem.loads, inner, strict=True)]
        rigid = None
        if ties.displaced is not None:
            geometric = ties.displaced.geometric_stiffness([f.T for f in unbalanced], by_rotation)
            rigid = geometric.projected(self.frames.rigid, ties.displaced.coordinates)
        coupled = (
            rows.turned(self._couplings[link].stiffness, ties)
            for link, rows in self._coupled.items()
        )
        joined = chain(self._springs.tangents(motion, displacement, ties), coupled)
        band = self.assembly.band(entries, ties, rigid, joined)
        return Imbalance(self.assembly.gather(unbalanced, ties), band, strains)

    def _response(
        self, number: int, q: FloatArray, extra: FloatArray, *given: Any
    ) -> ElementResponse:
        """Forces and tangent of a link's elements at displacements q (n, B), with extra stiffness.

        ``given`` is that of :meth:`CorotationalElements.response`.
        """
        relative = self.links[number].relative(q)
        response = self.links[number].response(relative, *given)
        response.force[:] += by_elements(extra, relative)
        response.tangent[:] += extra
        return response

    def _add_coupling(
        self, displacement: Sequence[FloatArray], forces: Sequence[FloatArray], swelling: float
    ) -> None:
        """Add internal forces (n_link, B) of energies of whole links."""
        for link, coupling in self._couplings.items():
            bent = coupling.rows @ displacement[link] - swelling * coupling.unloaded[:, None]
            forces[link][:] += coupling.rows.T @ (coupling.elastic @ bent)

    def response(
        self, displacement: Sequence[FloatArray], extra: Sequence[FloatArray]
    ) -> tuple[list[FloatArray], dict[int, FloatArray]]:
        """Internal forces and tangents of the links at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)
        extra : sequence of ndarray, shape (e, r, r, B)
            Stiffness of each element besides that of the corotational beam, by its relative
            coordinates.

        Returns
        -------
        list of ndarray, shape (B, n_link)
            Forces on the nodes; none of a rigid link.
        dict of int to ndarray, shape (B, n_link, n_link)
            Tangent of each flexible link.
        """
        columns, tangents = [q.T for q in displacement], {}
        forces = [np.zeros_like(q) for q in columns]
        for (number, link), more in zip(self.links.items(), extra, strict=True):
            response = self._response(number, columns[number], more, 1.0, None, None)
            forces[number] = link.on_nodes(response.force)
            tangents[number] = link.of_link(response.tangent)
        self._add_coupling(columns, forces, swelling=1.0)
        for number, coupling in self._couplings.items():
            tangents[number] += coupling.stiffness
        return [force.T for force in forces], tangents

    def damping(self, displacement: Sequence[FloatArray]) -> dict[int, FloatArray]:
        """Kelvin-Voigt damping matrix of each flexible link at given displacements.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        dict of int to ndarray, shape (B, n_link, n_link)
        """
        matrices = {
            number: link.of_link(link.damping(link.relative(displacement[number].T)))
            for number, link in self.links.items()
        }
        for number, coupling in self._couplings.items():
            matrices[number] += coupling.damping_time * coupling.stiffness
        return matrices

    def damping_stiffness(
        self, displacement: Sequence[FloatArray], rate: Sequence[FloatArray]
    ) -> dict[int, FloatArray]:
        """Derivative of each flexible link's damping forces by its displacement at given rates.

        Parameters
        ----------
        displacement, rate : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        dict of int to ndarray, shape (B, n_link, n_link)
        """
        return {
            number: link.of_link(
                link.damping_stiffness(*(link.relative(q[number].T) for q in (displacement, rate)))
            )
            for number, link in self.links.items()
        }


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


@dataclass(frozen=True)
class State:
    """State of Newton's method over a batch of positions.

    Parameters
    ----------
    z : ndarray, shape (size, B)
        Independent coordinates.
    error : ndarray, shape (B,)
        Greatest force out of balance.
    stable : ndarray of bool, shape (B,)
        Whether the tangent stiffness is positive definite.
    converged : ndarray of bool, shape (B,)
    """

    z: FloatArray
    error: FloatArray
    stable: NDArray[np.bool_]
    converged: NDArray[np.bool_]

    @classmethod
    def unloaded(cls, size: int, batch: int) -> State:
        """Equilibrium of straight links, not converged."""
        error, stable, converged = np.zeros((3, batch))
        return cls(np.zeros((size, batch)), error, stable > 0, converged > 0)

    def put(self, which: IntArray, state: State) -> None:
        """Replace that of some positions."""
        for values, new in zip(vars(self).values(), vars(state).values(), strict=True):
            values[..., which] = new


class Equilibrium:
    """Newton solver for the equilibrium of one linkage on one mesh.

    Parameters
    ----------
    balance : ForceBalance
    stable_alone : bool
        Whether links that are unstable without springs and turning forces are refused.
    """

    def __init__(self, balance: ForceBalance, *, stable_alone: bool) -> None:
        self._balance, self._stable_alone = balance, stable_alone
        self._assembly, self._frames = balance.assembly, balance.frames
        elements = {n: chain.elements for n, chain in balance.links.items()}
        self._force_scale = min(
            e.section.bending_stiffness / float(e.length.sum()) ** 2 for e in elements.values()
        )
        self._angle_per_unit = angle_per_unit(self._frames, elements)

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
            Dead of bodies and rigid links.
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
        greatest = np.abs(self._frames.gather(motion, loads)).max(axis=1, initial=0.0)
        start = np.zeros((self._frames.size, len(greatest)))
        ties = None if self._assembly.ties_move else self._assembly.ties(motion, start)
        problem = Problem(motion, [load.T.copy() for load in loads], greatest, extra, dead, ties)
        state = State.unloaded(*start.shape)
        if near is not None:
            start = self._assembly.coordinates(motion, near)
            state = self._newton(start, problem, FIRST_ITERATIONS)
            state.converged[~state.stable] = False
        for steps in LOAD_STEPS:
            left = np.flatnonzero(~state.converged)
            if not len(left):
                break
            if steps > 1:
                logger.info("%d positions are loaded in %d steps", len(left), steps)
            state.put(left, self._in_steps(problem.at(left), steps))
        self._refuse_divergence(motion, state)
        if self._stable_alone:
            refuse_positions(
                motion,
                ~state.stable,
                "the linkage buckles under its loads",
                f": the tangent stiffness is not positive; {LESS_LOADED} or stiffen the links",
                BucklingError,
            )
        ties = ties or self._assembly.ties(motion, state.z)
        return [q.T for q in self._assembly.link_displacement(state.z, ties)]

    def _in_steps(self, problem: Problem, steps: int) -> State:
        """Newton's method in load steps; positions that fail are left at their last step."""
        state = State.unloaded(self._frames.size, len(problem.greatest))
        which = np.arange(len(problem.greatest))
        for fraction in np.arange(1, steps + 1) / steps:
            loaded = problem.at(which).loaded(float(fraction))
            most = FIRST_ITERATIONS if steps == 1 else MAX_ITERATIONS
            moved = self._newton(in_positions(state.z, which), loaded, most)
            state.put(which, moved)
            which = which[moved.converged]
            if not len(which):
                break
        return state

    def _newton(self, z: FloatArray, problem: Problem, iterations: int) -> State:
        """Newton's method from displacements z, without the positions that have converged."""
        which = np.arange(z.shape[1])
        state = State.unloaded(*z.shape)
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            imbalance = self._balance.imbalance(z, problem)
            for _ in range(iterations):
                change, order = np.empty_like(z), self._assembly.order
                change[order], stable = solve_band(imbalance.band, imbalance.residual[order])
                last = self._turned(change) <= LAST_STEP
                state.put(
                    which, State(z + np.where(last, change, 0.0), imbalance.error, stable, last)
                )
                rest = np.flatnonzero(~last)
                if not len(rest):
                    break
                if len(rest) < len(last):
                    which, problem, imbalance = which[rest], problem.at(rest), imbalance.at(rest)
                    z, change = in_positions(z, rest), in_positions(change, rest)
                z, imbalance = self._advance(z, change, problem, imbalance)
        return state

    def _turned(self, change: FloatArray) -> FloatArray:
        """Greatest rotation in rad of a change (size, B) of the displacements, (B,)."""
        return np.asarray(np.abs(change * self._angle_per_unit).max(axis=0, initial=0.0))

    def _advance(
        self, z: FloatArray, change: FloatArray, problem: Problem, before: Imbalance
    ) -> tuple[FloatArray, Imbalance]:
        """One Newton step, with line search where it overshoots."""
        length = np.ones(z.shape[1])
        limit = np.maximum(ALLOWED_GROWTH * before.error, ALLOWED_FORCES * problem.greatest)
        limit = np.maximum(limit, self._force_scale * ALLOWED_FORCES)
        while True:
            trial = z + length * change
            imbalance = self._balance.imbalance(trial, problem, before.strains)
            worse = ~(imbalance.error <= limit)
            if not np.any(worse & (length > SHORTEST_STEP)):
                return trial, imbalance
            length[worse] = np.maximum(length[worse] / 2, SHORTEST_STEP)

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
