"""Forces in straight links under the inertia forces of the rigid motion, and what they stiffen.

Of links that pins alone tie, the rigid linkage tells them all. Welds may make a linkage statically
indeterminate: then they are those of the linear static solution. Rigid links meet the forces of
their joints, which keep their direction, as springs against rotation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.linear_system.chains import LinkMatrix
from flexmech.linear_system.connectors import Connectors
from flexmech.linear_system.dead_forces import DeadForces
from flexmech.linear_system.link_frames import LinkFrames
from flexmech.linear_system.rigid_coordinates import PoseStiffness
from flexmech.linear_system.rigid_link import dead_virial, rigid_tangent
from flexmech.linear_system.stressed_links import StressedLinks
from flexmech.linear_system.tension import forces_of_links, static_displacement
from flexmech.linkages import RigidMotion
from flexmech.linkages.internal_forces import LinkForces
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray


@dataclass(frozen=True)
class StraightForces:
    """Forces in straight links.

    Parameters
    ----------
    loads : list of ndarray, shape (B, n_link)
        That they are under.
    links : LinkForces
    stiffness : PoseStiffness, optional
        Of rigid links and sliders by them; None where there are none.
    """

    loads: list[FloatArray]
    links: LinkForces
    stiffness: PoseStiffness | None


def ties_beyond_pins(frames: LinkFrames) -> bool:
    """Whether there are welds, lines or rigid links: the linkage may be indeterminate."""
    return bool(frames.topology.welds or frames.rigid.size)


def straight_forces(
    mechanism: Mechanism,
    frames: LinkFrames,
    motion: RigidMotion,
    loads: list[FloatArray],
    lumped: Sequence[int] | None = None,
    connectors: Connectors | None = None,
) -> StraightForces:
    """Forces in straight links under loads.

    Parameters
    ----------
    mechanism : Mechanism
    frames : LinkFrames
        Of its unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    loads : list of ndarray, shape (B, n_link)
    lumped : sequence of int, optional
        Number of elements of each link whose mass is lumped at their ends.
    connectors : Connectors, optional
        Loads and springs among the loads.

    Returns
    -------
    StraightForces
    """
    if not ties_beyond_pins(frames):
        still = mechanism.without_loads_over_time
        return StraightForces(loads, still.inverse_dynamics(motion, lumped=lumped), None)
    applied = () if connectors is None else connectors.applied(motion)
    displacement = static_displacement(frames, motion, loads)
    masses = mechanism.link_masses_in_order
    if lumped is not None:
        masses = tuple(mass.lumped(n) for mass, n in zip(masses, lumped, strict=True))
    forces = forces_of_links(frames, motion, displacement, loads, masses, mechanism.gravity)
    forces = replace(forces, applied=applied)
    if not frames.rigid.size:
        return StraightForces(loads, forces, None)
    virial = dead_virial(frames.links, motion, mechanism.gravity)
    if connectors is not None:
        virial = virial + connectors.virial(motion)
    posed = frames.displaced_ties(
        motion, np.zeros((len(virial), len(frames.rigid.independent_coordinates)))
    )
    inner = [q @ link.stiffness for q, link in zip(displacement, frames.links, strict=True)]
    dead = DeadForces.of(frames.links, motion, loads, virial)
    return StraightForces(loads, forces, dead.stiffness(posed, inner))


def with_rigid_links(
    frames: LinkFrames,
    motion: RigidMotion,
    tangent: Mapping[int, LinkMatrix],
    found: PoseStiffness | None,
    loads: list[FloatArray] | None = None,
) -> StressedLinks:
    """Tangents of all links from those of flexible ones.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    tangent : mapping of int to ndarray, shape (n, n) or (B, n, n)
        Of each flexible link.
    found : PoseStiffness, optional
        Of rigid links and sliders.
    loads : list of ndarray, shape (B, n_link), optional

    Returns
    -------
    StressedLinks
        Without a displacement.
    """
    if found is None:
        return StressedLinks(list(_in_order(tangent)), loads=loads)
    tangents = [
        rigid_tangent(link, motion, number, found.turning[:, number])
        if link.rigid
        else tangent[number]
        for number, link in enumerate(frames.links)
    ]
    return StressedLinks(tangents, loads=loads, guiding=found.guiding)


def _in_order(values: Mapping[int, LinkMatrix]) -> Sequence[LinkMatrix]:
    return [values[number] for number in sorted(values)]
