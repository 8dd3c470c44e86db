"""The linear system of stressed links, in all their coordinates or in component modes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.assembly.system import LinearSystem, condense
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.links.body_forces import body_turns
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linear_system.reduction.component_modes import ComponentModes
from flexmech.linkages import RigidMotion

Connect = Callable[[LinkFrames, RigidMotion, SystemMatrices], SystemMatrices]
"""Adds to matrices those of loads and springs."""


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
    motion = frames.displaced(motion, stressed.displacement)
    turns = body_turns(frames.links, stressed.displacement)
    tangent = [link.stiffness for link in frames.links] if stressed.unstressed else stressed.tangent
    matrices = frames.assemble(
        motion, tangent, terms, stressed.damping, stressed.guide_stiffness, turns
    )
    if connect is not None:
        matrices = connect(frames, motion, matrices)
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
    damping, end_damping = _damping(links, reduction, stressed, motion.design)
    turns = body_turns(links, stressed.displacement)
    projected = [
        link.model.stiffness
        if stressed.unstressed or tangent is full.stiffness
        else _projected(link.basis_at(motion.design), tangent)
        for full, link, tangent in zip(links, reduction.links, stressed.tangent, strict=True)
    ]
    matrices = frames.assemble(
        motion, projected, terms, damping, stressed.guide_stiffness, turns, end_damping
    )
    if connect is not None:
        matrices = connect(frames, motion, matrices)
    expansion = None
    if condensed.any():
        forces = _damped_ends(frames, reduction, end_damping, motion)
        matrices, expansion = condense(matrices, condensed, forces)
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


def _projected(basis: FloatArray, tangent: FloatArray) -> FloatArray:
    """Tangent stiffness of a link in component modes."""
    return np.asarray(np.swapaxes(basis, -1, -2) @ (tangent @ basis))


def _damping(
    links: Sequence[LinkModel],
    reduction: ComponentModes,
    stressed: StressedLinks,
    design: IntArray | None,
) -> tuple[list[FloatArray], list[FloatArray]] | tuple[None, None]:
    """Damping of the stressed links in component modes, and its forces by the ends alone."""
    if stressed.damping is None:
        return None, None
    damping, end_damping = [], []
    for full, link, matrix in zip(links, reduction.links, stressed.damping, strict=True):
        names = ("start", "end", "start_rotation", "end_rotation")
        kept = {name: getattr(link.model, name) for name in names}
        basis = link.basis_at(design)
        ends = full.end_basis(link.model.size, kept) if not full.rigid else basis
        forces = np.swapaxes(basis, -1, -2) @ matrix
        damping.append(forces @ basis)
        end_damping.append(forces @ ends)
    return damping, end_damping


def _damped_ends(
    frames: LinkFrames,
    reduction: ComponentModes,
    end_damping: Sequence[FloatArray] | None,
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
        ends = link.model.ends.damping if end_damping is None else end_damping[number]
        rows = frames.targets[number][link.condensed] - first
        columns = slice(last[number] - ways[number], last[number])
        answer = ends[..., link.condensed, :] @ link.damped_ends
        forces[:, rows, columns] = answer if motion.design is None else answer[motion.design]
    return forces
