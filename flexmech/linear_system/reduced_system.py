"""The linear system of stressed links, in all their coordinates or in component modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linear_system.component_modes import ComponentModes
from flexmech.linear_system.link_frames import LinkDamping, LinkFrames, RotationTerms
from flexmech.linear_system.link_model import LinkModel
from flexmech.linear_system.stressed_links import StressedLinks
from flexmech.linear_system.system import LinearSystem, condense
from flexmech.linkages import RigidMotion, Topology

__all__ = ["reduced_system", "unreduced_system"]


def unreduced_system(
    topology: Topology,
    links: Sequence[LinkModel],
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
) -> LinearSystem:
    """Linear system in all coordinates of the links.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
    terms : RotationTerms

    Returns
    -------
    LinearSystem
    """
    frames = LinkFrames(topology, links)
    damping = None
    if stressed.damping is not None:
        damping = [LinkDamping(matrix, matrix) for matrix in stressed.damping]
    matrices = frames.assemble(motion, stressed.tangent, terms, damping)
    return LinearSystem(motion, matrices.mass, matrices.damping, matrices.stiffness, terms, frames)


def reduced_system(
    topology: Topology,
    links: Sequence[LinkModel],
    reduction: ComponentModes,
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
) -> LinearSystem:
    """Linear system in component modes, some of which follow the others statically.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        Unreduced.
    reduction : ComponentModes
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
    terms : RotationTerms

    Returns
    -------
    LinearSystem
    """
    frames = LinkFrames(topology, reduction.models)
    projected = [
        link.basis.T @ (tangent @ link.basis)
        for link, tangent in zip(reduction.links, stressed.tangent, strict=True)
    ]
    matrices = frames.assemble(motion, projected, terms, _damping(links, reduction, stressed))
    condensed = np.zeros(frames.size, dtype=bool)
    for target, link in zip(frames.targets, reduction.links, strict=True):
        condensed[target[link.condensed]] = True
    expansion = None
    if condensed.any():
        matrices, expansion = condense(matrices, condensed)
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
        unit_mass_from=frames.end_count if expansion is None else None,
    )


def _damping(
    links: Sequence[LinkModel], reduction: ComponentModes, stressed: StressedLinks
) -> list[LinkDamping] | None:
    """Damping of the stressed links in component modes."""
    if stressed.damping is None:
        return None
    damping = []
    for full, link, matrix in zip(links, reduction.links, stressed.damping, strict=True):
        ends = full.end_basis(link.model.size, {"start": link.model.start, "end": link.model.end})
        forces = link.basis.T @ matrix
        damping.append(LinkDamping(forces @ link.basis, forces @ ends))
    return damping
