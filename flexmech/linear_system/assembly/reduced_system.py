"""The linear system of stressed links, in all their coordinates or in component modes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.assembly.system import LinearSystem, condense
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.links.chains import LinkMatrix, in_positions, whole
from flexmech.linear_system.links.dead_moments import body_turns
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rotation_terms import LinkDamping, RotationTerms, SystemMatrices
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linear_system.reduction.component_modes import ComponentModes
from flexmech.linkages import RigidMotion

Connect = Callable[[LinkFrames, RigidMotion, SystemMatrices, slice], SystemMatrices]
"""Adds to matrices in the positions of a slice those of loads and springs."""
# Of one matrix in the positions that are assembled at a time. Speed alone: memory near the
# processor holds it.
MATRIX_BYTES = 1_000_000


def unreduced_system(
    frames: LinkFrames,
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
    connect: Connect | None = None,
) -> LinearSystem:
    """Linear system in all coordinates of the links that have mass.

    Rotations, and nodes between lumped masses, may have none: they are condensed statically.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
    terms : RotationTerms
    connect : callable, optional
        Adds the matrices of loads and springs.

    Returns
    -------
    LinearSystem
    """
    damping = None
    if stressed.damping is not None:
        damping = [LinkDamping(matrix, matrix) for matrix in stressed.damping]
    motion = frames.displaced(motion, stressed.displacement)
    turns = body_turns(frames.links, stressed.displacement)
    tangent = [link.stiffness for link in frames.links] if stressed.unstressed else stressed.tangent
    matrices = frames.assemble(motion, tangent, terms, damping, stressed.guide_stiffness, turns)
    if connect is not None:
        matrices = connect(frames, motion, matrices, slice(None))
    massless = np.all(np.diagonal(matrices.mass, axis1=1, axis2=2) == 0, axis=0)
    massless[: len(frames.rigid.independent_coordinates)] = False
    expansion = None
    if massless.any():
        matrices, expansion = condense(matrices, massless)
    return LinearSystem(
        motion,
        matrices.mass,
        matrices.damping,
        matrices.stiffness,
        terms,
        frames,
        expansion,
    )


def reduced_system(
    links: Sequence[LinkModel],
    reduction: ComponentModes,
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
    connect: Connect | None = None,
) -> LinearSystem:
    """Linear system in component modes, some of which are condensed statically.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    reduction : ComponentModes
    motion : RigidMotion
        Batch of shape (B,); of rigid links where they are displaced.
    stressed : StressedLinks
    terms : RotationTerms
    connect : callable, optional
        Adds the matrices of loads and springs.

    Returns
    -------
    LinearSystem
    """
    frames = reduction.frames
    condensed = np.zeros(frames.size, dtype=bool)
    for target, link in zip(frames.targets, reduction.links, strict=True):
        condensed[target[link.condensed]] = True
    damping = _damping(links, reduction, stressed)
    turns = body_turns(links, stressed.displacement)
    at_once = max(1, MATRIX_BYTES // (8 * frames.size**2))
    parts = []
    for first in range(0, len(motion.crank_angle), at_once):
        some = slice(first, first + at_once)
        projected = [
            link.model.stiffness
            if stressed.unstressed or tangent is full.stiffness
            else _projected(link.basis, in_positions(tangent, some))
            for full, link, tangent in zip(links, reduction.links, stressed.tangent, strict=True)
        ]
        own = damping and [each.at(some) for each in damping]
        guide_stiffness = (
            None if stressed.guide_stiffness is None else stressed.guide_stiffness[some]
        )
        turned = turns and [[angle[some] for angle in each] for each in turns]
        matrices = frames.assemble(motion.at(some), projected, terms, own, guide_stiffness, turned)
        if connect is not None:
            matrices = connect(frames, motion.at(some), matrices, some)
        forces = _damped_ends(frames, reduction, own, motion.at(some))
        parts.append(condense(matrices, condensed, forces) if condensed.any() else (matrices, None))
    matrices = SystemMatrices(
        *(_joined([getattr(m, field.name) for m, _ in parts]) for field in fields(SystemMatrices))
    )
    expansion = _joined([e for _, e in parts if e is not None]) if condensed.any() else None
    has_unit_mass = reduction.decouples_mass and expansion is None and turns is None
    return LinearSystem(
        motion,
        matrices.mass,
        matrices.damping,
        matrices.stiffness,
        terms,
        frames,
        expansion,
        tuple(link.basis for link in reduction.links),
        # Component modes are normalized by the mass; condensed ones bring theirs along.
        unit_mass_from=frames.end_count if has_unit_mass else None,
    )


def _projected(basis: FloatArray, tangent: LinkMatrix) -> FloatArray:
    """Tangent stiffness of a link in component modes."""
    return np.asarray(basis.T @ (tangent @ basis))


def _joined(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate(parts) if len(parts) > 1 else parts[0]


def _damping(
    links: Sequence[LinkModel], reduction: ComponentModes, stressed: StressedLinks
) -> list[LinkDamping] | None:
    """Damping of the stressed links in component modes."""
    if stressed.damping is None:
        return None
    damping = []
    for full, link, matrix in zip(links, reduction.links, stressed.damping, strict=True):
        names = ("start", "end", "start_rotation", "end_rotation")
        kept = {name: getattr(link.model, name) for name in names}
        ends = full.end_basis(link.model.size, kept) if not full.rigid else link.basis
        forces = link.basis.T @ matrix
        damping.append(LinkDamping(forces @ link.basis, forces @ ends))
    return damping


def _damped_ends(
    frames: LinkFrames,
    reduction: ComponentModes,
    damping: Sequence[LinkDamping] | None,
    motion: RigidMotion,
) -> FloatArray | None:
    """Damping forces of end motions on the condensed coordinates, (B, c, r) or None."""
    ways = [link.damped_ends.shape[-1] for link in reduction.links]
    if not any(ways):
        return None
    first = frames.size - sum(int(link.condensed.sum()) for link in reduction.links)
    forces = np.zeros((len(motion.crank_angle), frames.size - first, sum(ways)))
    last = np.cumsum(ways)
    for number, link in enumerate(reduction.links):
        if not ways[number]:
            continue
        ends = whole(link.model.ends.damping if damping is None else damping[number].ends)
        rows = frames.targets[number][link.condensed] - first
        columns = slice(last[number] - ways[number], last[number])
        forces[:, rows, columns] = ends[..., link.condensed, :] @ link.damped_ends
    return forces
