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

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import (
    LAST_STEP,
    LESS_LOADED,
    LOAD_STEPS,
    MAX_ITERATIONS,
    BucklingError,
    DeadMoments,
    EquilibriumError,
    refuse_positions,
)
from flexmech.linkages import RigidMotion
from flexmech.reference.assembly import angle_per_unit, solve_band
from flexmech.reference.corotational import in_positions
from flexmech.reference.force_balance import ForceBalance, Imbalance, Problem

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
        """That of straight links, not converged."""
        error, stable, converged = np.zeros((3, batch))
        return cls(np.zeros((size, batch)), error, stable > 0, converged > 0)

    def put(self, which: IntArray, part: State) -> None:
        """Replace that of some positions."""
        for own, new in zip(vars(self).values(), vars(part).values(), strict=True):
            own[..., which] = new


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
        elements = {n: own.elements for n, own in balance.links.items()}
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
        for part in np.arange(1, steps + 1) / steps:
            loaded = problem.at(which).loaded(float(part))
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
