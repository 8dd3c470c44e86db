"""Forces in straight links under the rigid motion's inertia forces, and geometric stiffness.

Where pins alone join the links, the forces are those of the rigid linkage. Welds may make a linkage
statically indeterminate: then they are those of the linear static solution. Joint forces on rigid
links, as dead loads, are a geometric stiffness against rotation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.joints.rigid_pose import RigidGeometricStiffness
from flexmech.linear_system.links.body_forces import DeadMoments
from flexmech.linear_system.links.chains import with_entries
from flexmech.linear_system.links.link_model import StressedLinks
from flexmech.linear_system.links.rotation_terms import RotationTerms
from flexmech.linear_system.loads.connectors import Connectors
from flexmech.linkages import RigidMotion
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism

# A rigid link's stiffness against its rotation alone, by its three coordinates.
TURN = np.diag([0.0, 0.0, 1.0])


def ties_beyond_pins(frames: LinkFrames) -> bool:
    """Whether there are welds, lines, rigid links or a hub, so that pins do not tell all forces."""
    return bool(frames.topology.welds or frames.has_arms)


def straight_forces(
    mechanism: Mechanism,
    frames: LinkFrames,
    motion: RigidMotion,
    loads: list[FloatArray],
    lumped: Sequence[int] | None = None,
    connectors: Connectors | None = None,
) -> tuple[LinkForces, RigidGeometricStiffness | None]:
    """Forces in straight links under loads, from their linear static displacement.

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
    LinkForces
        Zero for rigid links.
    RigidGeometricStiffness or None
        Of rigid links, hubs and sliders; None where there are none.
    """
    if not ties_beyond_pins(frames):
        still = mechanism.without_loads_over_time
        return still.inverse_dynamics(motion, lumped=lumped), None
    elastic = [link.stiffness for link in frames.links]
    matrices = frames.assemble(motion, elastic, RotationTerms.all_or_none(False))
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
    applied = () if connectors is None else tuple(connectors.applied(motion))
    forces = LinkForces(motion, masses, mechanism.gravity, force, moment, (), applied)
    if not frames.has_arms:
        return forces, None
    virial = None if connectors is None else connectors.virial(motion)
    straight = np.zeros((len(motion.angle), len(frames.rigid.independent_coordinates)))
    dead = DeadMoments.of(frames.links, motion, mechanism.gravity, loads, virial)
    rotation_stiffness = dead.by_link([np.zeros_like(load.T) for load in loads])
    ties = frames.displaced_ties(motion, straight)
    return forces, ties.geometric_stiffness(unbalanced, rotation_stiffness)


def with_rigid_links(
    frames: LinkFrames,
    tangent: Mapping[int, FloatArray],
    found: RigidGeometricStiffness | None,
    loads: list[FloatArray] | None = None,
) -> StressedLinks:
    """Tangents of all links from those of flexible ones.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    tangent : mapping of int to ndarray, shape (n, n) or (B, n, n)
        Of each flexible link.
    found : RigidGeometricStiffness, optional
        Of rigid links, hubs and sliders.
    loads : list of ndarray, shape (B, n_link), optional

    Returns
    -------
    StressedLinks
        Without a displacement.
    """
    if found is None:
        return StressedLinks([tangent[number] for number in sorted(tangent)], loads=loads)
    tangents = [
        np.multiply.outer(found.rotation_stiffness[:, number], TURN)
        if link.rigid
        else tangent[number]
        for number, link in enumerate(frames.links)
    ]
    for clamp in frames.topology.clamps:
        number = frames.topology.index(clamp.link_end.link)
        if clamp.hub and not (link := frames.links[number]).rigid:
            turn = link.end_rotation_of(clamp.link_end.end)[:1]
            own = found.rotation_stiffness[:, number, None]
            tangents[number] = with_entries(tangents[number], turn, turn, own)
    return StressedLinks(tangents, loads=loads, guide_stiffness=found.guide_stiffness)


def element_tensions(
    mechanism: Mechanism,
    nodes: Sequence[FloatArray],
    motion: RigidMotion,
    forces: LinkForces | None = None,
) -> list[FloatArray]:
    """Axial force in each element under the motion's inertia forces, in N.

    With the crank held most linkages are statically determinate: the linear static
    solution's axial force is that of the rigid linkage. It is quadratic along an element,
    and its mean is what the element's end displacements alone would give.

    Parameters
    ----------
    mechanism : Mechanism
    nodes : sequence of ndarray, shape (e + 1,)
        Node positions along each link in m.
    motion : RigidMotion
        Batch of shape (B,).
    forces : LinkForces, optional
        In the links; those of the rigid linkage by default.

    Returns
    -------
    list of ndarray, shape (B, e, 3)
        Legendre coefficients along each element: mean, linear, quadratic.

    Raises
    ------
    InputError
        If ``forces`` are left out and the rigid linkage is not statically determinate.
    """
    if forces is None:
        forces = mechanism.inverse_dynamics(motion)
    tensions = []
    for link, places in enumerate(nodes):
        length = np.diff(places)
        inside = SAME_PLACE * length  # off the point masses that may sit at the nodes
        near, middle, far = (
            forces.axial_force(link, at)
            for at in (places[:-1] + inside, places[:-1] + length / 2, places[1:] - inside)
        )
        mean = (near + 4 * middle + far) / 6
        quadratic = (near + far - 2 * middle) / 3
        tensions.append(np.stack([mean, (far - near) / 2, quadratic], axis=-1))
    return tensions
