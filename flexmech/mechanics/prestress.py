"""Loads and forces of the state about which links are linearized: an equilibrium, or straight.

Loads of a quasi-static equilibrium depend on its displacements: the forces of springs, follower
forces, and the inertia forces of links that rotate as one body
(:mod:`flexmech.mechanics.links.body_forces`). An engine's solver finds the displacement under
given forces. The loads are those at that displacement, found by Newton's method: the links' tangent
stiffness predicts the next displacement, and the forces there are the next load.

Forces in straight links are those of their linear static solution: where pins alone join them,
those of the rigid linkage. Joint forces on rigid links, as dead loads, are a geometric stiffness
against rotation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import RigidMotion
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics.joints.joint_coordinates import RigidGeometricStiffness
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.joints.position_errors import (
    LESS_LOADED,
    BucklingError,
    EquilibriumError,
    refuse_positions,
)
from flexmech.mechanics.links.body_forces import DeadMoments, DisplacedInertia
from flexmech.mechanics.links.link_model import LinkModel, StressedLinks, with_entries
from flexmech.mechanics.links.rotation_terms import RotationTerms
from flexmech.mechanics.loads.connectors import Connectors
from flexmech.mechanism import Mechanism

# Passes of Newton's method: linkages with springs take four or five; one that takes ten times as
# many oscillates.
MOST_PASSES = 60
# Greatest change of a load in the last pass, relative to the greatest. A pass gains more than that.
LAST_PASS = 1e-10
# A change that is smaller than this and no longer falls is the round-off of an engine's solver.
STAGNATED = 1e-8
MAX_ITERATIONS = 40
"""Iterations of Newton's method in one load step: five do near an equilibrium; shortened steps take
more."""
LOAD_STEPS = (1, 5, 25)
"""Where all load at once leads nowhere, it is brought on in steps, swelling along with it.

Five times more each time: what 25 steps do not reach, such as a bow beyond half a link's length, is
not the equilibrium next to the straight links.
"""
LAST_STEP = 5e-8
"""Newton's method takes its last step where that turns no section, and moves no node by a part of
the linkage's size, by more than this.

The error that is left is the step's square times at most 8000 on random mechanisms, loaded twice as
much as at their speeds: 2e-11. Forces out of balance are no measure: one that is lost in the
round-off of a stiff link may bend a soft one that is pinned to it.
"""
# A link displaced by more than this part of its length is no longer near the rigid linkage,
# about whose motion vibrations are asked for; Newton's method may have found any equilibrium.
FARTHEST = 0.5
# A rigid link's stiffness against its rotation alone, by its three coordinates.
TURN = np.diag([0.0, 0.0, 1.0])
FROZEN = RotationTerms.all_or_none(False)


@dataclass(frozen=True)
class BalancedLoads:
    """Loads on the links, and the displacement at which they act.

    Parameters
    ----------
    loads : list of ndarray, shape (B, n_link)
    at : list of ndarray, shape (B, n_link), or None
        Displacement of the links at which the loads are these; None of links as drawn.
    """

    loads: list[FloatArray]
    at: list[FloatArray] | None


def balanced_links(
    connectors: Connectors,
    frames: LinkFrames,
    motion: RigidMotion,
    loads: Sequence[FloatArray],
    solve: Callable[[BalancedLoads], StressedLinks],
    *,
    displaced_inertia: DisplacedInertia | None = None,
    solve_connects: bool = False,
) -> StressedLinks:
    """Links at equilibrium under loads, some of which depend on where the links are.

    Parameters
    ----------
    connectors : Connectors
        Connectors of the links of ``frames``.
    frames : LinkFrames
    motion : RigidMotion
        Batch of shape (B,).
    loads : sequence of ndarray, shape (B, n_link)
        Others.
    solve : callable
        Links at equilibrium under given :class:`BalancedLoads`.
    displaced_inertia : DisplacedInertia, optional
        Inertia forces by which the displacement of the links changes those among ``loads``.
    solve_connects : bool
        Whether ``solve`` counts the connectors, whose forces are then not among its loads.

    Returns
    -------
    StressedLinks

    Raises
    ------
    ComputationError
        Where no such forces are found, or inertia forces grow faster with the displacement than
        the links' forces; names the crank angle.
    """
    undisplaced = [np.zeros_like(load) for load in loads]

    def forces(displacement: Sequence[FloatArray] | None) -> list[FloatArray]:
        total = undisplaced if solve_connects else connectors.forces(motion, displacement)
        if displaced_inertia is None or displacement is None:
            return total
        return _sum(total, displaced_inertia.on_undeformed(displacement))

    force, moved = forces(None), None
    if displaced_inertia is None and (solve_connects or not connectors.depend_on_displacement):
        return solve(BalancedLoads(_sum(loads, force), None))
    stiffness: Sequence[FloatArray] = [link.stiffness for link in frames.links]
    displacement, unbalanced = undisplaced, _sum(loads, force)
    load_change = np.full(len(motion.crank_angle), np.inf)
    converged = np.zeros(len(load_change), dtype=bool)
    for number in range(MOST_PASSES):
        # Near its first frequency a body is stiff by its tension alone, which straight links lack.
        if number or displaced_inertia is not None:
            stressed = solve(BalancedLoads(_sum(loads, force), moved))
            assert stressed.displacement is not None
            stiffness, displacement = stressed.tangent, stressed.displacement
            unbalanced = [b - a for a, b in zip(force, forces(displacement), strict=True)]
        if displaced_inertia is not None:
            pairs = zip(stiffness, displaced_inertia.matrices(displacement), strict=True)
            stiffness = [tangent - matrix for tangent, matrix in pairs]
        links = frames.assemble(motion, stiffness, FROZEN)
        against = connectors.added(
            frames, motion, links, FROZEN, "equilibrium", displacement
        ).stiffness
        right = frames.gather(motion, unbalanced)[..., None]
        step = frames.link_coordinates(motion, np.linalg.solve(against, right))
        moved = [q + change[..., 0] for q, change in zip(displacement, step, strict=True)]
        before, force, last = force, forces(moved), load_change
        load_change = _greatest([b - a for a, b in zip(before, force, strict=True)])
        size = np.maximum(_greatest(force), _greatest(loads))
        stagnated = (load_change <= STAGNATED * size) & (2 * load_change >= last)
        converged |= (load_change <= LAST_PASS * size) | stagnated
        if number and converged.all():
            if displaced_inertia is not None:
                _refuse_instability(motion, against, follow=connectors.follow)
            break
    else:
        refuse_positions(
            motion,
            ~converged,
            "no equilibrium with the forces that depend on the displacement of the links",
            f": they still change by {float((load_change / size).max()):.3g} of the greatest after "
            f"{MOST_PASSES} passes; use softer springs, smaller loads or a lower crank speed, or "
            "prestress 'axial'",
            EquilibriumError,
        )
    return solve(BalancedLoads(_sum(loads, force), moved))


def _refuse_instability(motion: RigidMotion, stiffness: FloatArray, *, follow: bool) -> None:
    """Refuse an equilibrium that is statically unstable.

    Under forces that follow the links the stiffness is not symmetric, and its symmetric part says
    nothing: a linkage diverges where the determinant is negative (Bolotin 1963), and
    flutter is no matter of statics.
    """
    if follow:
        unstable = np.linalg.slogdet(stiffness).sign <= 0
    else:
        symmetric = (stiffness + np.swapaxes(stiffness, 1, 2)) / 2
        unstable = np.linalg.eigvalsh(symmetric)[:, 0] <= 0
    refuse_positions(
        motion,
        unstable,
        "the linkage buckles: the inertia forces and springs on its displaced links",
        f" grow faster with the displacement than the links' own forces; {LESS_LOADED} or stiffen "
        "the links",
        BucklingError,
    )


def _sum(loads: Sequence[FloatArray], others: Sequence[FloatArray]) -> list[FloatArray]:
    return [a + b for a, b in zip(loads, others, strict=True)]


def _greatest(vectors: Sequence[FloatArray]) -> FloatArray:
    """Greatest entry of several batches of vectors (B, n_link), (B,)."""
    return np.asarray(np.max([np.abs(v).max(axis=1) for v in vectors], axis=0), dtype=float)


def refuse_large_displacements(
    links: Sequence[LinkModel],
    motion: RigidMotion,
    displacements: Sequence[FloatArray],
) -> None:
    """Refuse an equilibrium far from the rigid linkage.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    motion : RigidMotion
        Batch of shape (B,).
    displacements : sequence of ndarray, shape (B, n_link)
        Elastic displacement of each link in its frame.

    Raises
    ------
    ComputationError
        Where a link is displaced by more than half its length; names the crank angle.
    """
    for link, q in zip(links, displacements, strict=True):
        if link.rigid:
            moved = np.einsum("scn,bn->bsc", link.shape, q)
        else:
            moved = q.reshape(len(q), -1, link.readings.per_node)[:, :, :2]
        farthest = np.linalg.norm(moved, axis=2).max(axis=1) / link.readings.nodes[-1]
        too_far = farthest > FARTHEST
        refuse_positions(
            motion,
            too_far,
            f"the {link.name} is displaced by {100 * farthest[too_far.argmax()]:.3g} % of its "
            "length",
            f": that equilibrium is not near the rigid linkage; {LESS_LOADED} or stiffen the links",
            EquilibriumError,
        )


def straight_forces(
    mechanism: Mechanism,
    frames: LinkFrames,
    motion: RigidMotion,
    loads: list[FloatArray],
    dead: DeadMoments,
    connectors: Connectors,
    lumped: Sequence[int] | None,
) -> tuple[LinkForces, RigidGeometricStiffness | None]:
    """Forces in straight links under loads, from their linear static displacement.

    Parameters
    ----------
    mechanism : Mechanism
    frames : LinkFrames
        Frames of its unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    loads : list of ndarray, shape (B, n_link)
    dead : DeadMoments
        Moments of these loads.
    connectors : Connectors
        Loads and springs among the loads.
    lumped : sequence of int, or None
        Number of elements of each link whose mass is lumped at their ends; None of distributed
        mass.

    Returns
    -------
    LinkForces
        Zero for rigid links.
    RigidGeometricStiffness or None
        Stiffness of rigid links, hubs and sliders; None where there are none.
    """
    elastic = [link.stiffness for link in frames.links]
    matrices = frames.assemble(motion, elastic, FROZEN)
    moved = np.linalg.solve(matrices.stiffness, frames.gather(motion, loads)[..., None])
    displacement = [q[..., 0] for q in frames.link_coordinates(motion, moved)]
    unbalanced = [
        load - q @ matrix for load, q, matrix in zip(loads, displacement, elastic, strict=True)
    ]
    force, moment = np.zeros((*motion.angle.shape, 2)), np.zeros(motion.angle.shape)
    for number, link in enumerate(frames.links):
        if not link.rigid:
            needed, angle = -unbalanced[number], motion.angle[:, number]
            x, y = (needed[:, row, None] for row in link.start)
            force[:, number] = x * direction(angle) + y * normal(angle)
            moment[:, number] = needed[:, link.start_rotation[:1]].sum(axis=1)
    masses = mechanism.link_masses_in_order
    if lumped is not None:
        masses = tuple(mass.lumped(n) for mass, n in zip(masses, lumped, strict=True))
    applied = tuple(connectors.applied(motion))
    forces = LinkForces(motion, masses, mechanism.gravity, force, moment, applied)
    if not frames.has_arms:
        return forces, None
    straight = np.zeros((len(motion.angle), len(frames.rigid.independent_coordinates)))
    rotation_stiffness = dead.by_link([np.zeros_like(load.T) for load in loads])
    ties = frames.displaced_ties(motion, straight)
    return forces, ties.geometric_stiffness(unbalanced, rotation_stiffness)


def with_rigid_links(
    frames: LinkFrames,
    tangent: Mapping[int, FloatArray],
    geometric: RigidGeometricStiffness | None,
) -> StressedLinks:
    """Tangents of all links from those of flexible ones.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the unreduced links.
    tangent : mapping of int to ndarray, shape (n, n) or (B, n, n)
        Tangent of each flexible link.
    geometric : RigidGeometricStiffness, optional
        Stiffness of rigid links, hubs and sliders.

    Returns
    -------
    StressedLinks
        Without a displacement.
    """
    if geometric is None:
        return StressedLinks([tangent[number] for number in sorted(tangent)])
    tangents = [
        np.multiply.outer(geometric.rotation_stiffness[:, number], TURN)
        if link.rigid
        else tangent[number]
        for number, link in enumerate(frames.links)
    ]
    for clamp in frames.topology.clamps:
        number = frames.topology.index(clamp.link_end.link)
        if clamp.hub and not (link := frames.links[number]).rigid:
            turn = link.end_rotation_of(clamp.link_end.end)[:1]
            stiffness = geometric.rotation_stiffness[:, number, None]
            tangents[number] = with_entries(tangents[number], turn, turn, stiffness)
    return StressedLinks(tangents, guide_stiffness=geometric.guide_stiffness)
