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


def assembled_system(
    frames: LinkFrames,
    reduction: ComponentModes | None,
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
    connect: Connect,
) -> LinearSystem:
    """Linear system of stressed links in all their coordinates or in component modes.

    Coordinates without mass are condensed statically: rotations and nodes between lumped masses may
    have none; of component modes those are condensed that the reduction says.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    reduction : ComponentModes or None
        None: all coordinates.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
    terms : RotationTerms
    connect : callable
        Adds the matrices of loads and springs.

    Returns
    -------
    LinearSystem
    """
    links, displacement = frames.links, stressed.displacement
    motion, turns = frames.displaced(motion, displacement), body_turns(links, displacement)
    damping, end_damping = stressed.damping, None
    forces, bases, unit_mass_from = None, None, None
    if reduction is None:
        stiffness = [link.stiffness for link in links]
        tangent = stiffness if stressed.unstressed else stressed.tangent
    else:
        frames = reduction.frames
        damping, end_damping = _damping(links, reduction, stressed, motion.design)
        forces = _damped_ends(frames, reduction, end_damping, motion)
        bases = tuple(link.basis for link in reduction.links)
        tangent = [
            link.model.stiffness
            if stressed.unstressed or tangent is full.stiffness
            else _projected(link.basis_at(motion.design), tangent)
            for full, link, tangent in zip(links, reduction.links, stressed.tangent, strict=True)
        ]
    matrices = frames.assemble(
        motion, tangent, terms, damping, stressed.guide_stiffness, turns, end_damping
    )
    matrices = connect(frames, motion, matrices)
    if reduction is None:
        condensed = np.all(np.diagonal(matrices.mass, axis1=1, axis2=2) == 0, axis=0)
        condensed[: len(frames.rigid.independent_coordinates)] = False
    else:
        condensed = np.zeros(frames.size, dtype=bool)
        for target, link in zip(frames.targets, reduction.links, strict=True):
            condensed[target[link.condensed]] = True
        # Component modes are normalized by the mass; condensed ones bring theirs along.
        if reduction.decouples_mass and not condensed.any() and turns is None:
            unit_mass_from = frames.end_count
    expansion = None
    if condensed.any():
        matrices, expansion = condense(matrices, condensed, forces)
    return LinearSystem(
        motion,
        matrices.mass,
        matrices.damping,
        matrices.stiffness,
        terms,
        frames,
        expansion,
        bases,
        unit_mass_from,
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
