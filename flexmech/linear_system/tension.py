"""Tension in the links of the undeformed linkage under its own inertia forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linear_system.link_frames import LinkFrames
from flexmech.linear_system.rotation_terms import RotationTerms
from flexmech.linkages import LinkMass, RigidMotion
from flexmech.linkages.internal_forces import LinkForces
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray


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
        inside = 1e-9 * length  # off the point masses that may sit at the nodes
        near, middle, far = (
            forces.axial_force(link, at)
            for at in (places[:-1] + inside, places[:-1] + length / 2, places[1:] - inside)
        )
        mean = (near + 4 * middle + far) / 6
        quadratic = (near + far - 2 * middle) / 3
        tensions.append(np.stack([mean, (far - near) / 2, quadratic], axis=-1))
    return tensions


def static_displacement(
    frames: LinkFrames, motion: RigidMotion, loads: Sequence[FloatArray]
) -> list[FloatArray]:
    """Linear static displacement of straight links under loads.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    loads : sequence of ndarray, shape (B, n_link)

    Returns
    -------
    list of ndarray, shape (B, n_link)
    """
    elastic = [link.stiffness for link in frames.links]
    matrices = frames.assemble(motion, elastic, RotationTerms.all_or_none(False))
    force = frames.gather(motion, loads)[..., None]
    moved = np.linalg.solve(matrices.stiffness, force)
    return [q[..., 0] for q in frames.link_coordinates(motion, moved)]


def forces_of_links(
    frames: LinkFrames,
    motion: RigidMotion,
    displacement: Sequence[FloatArray],
    loads: Sequence[FloatArray],
    masses: tuple[LinkMass, ...],
    gravity: tuple[float, float],
) -> LinkForces:
    """Forces in flexible links by their own displacements, determinate or not.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links.
    motion : RigidMotion
        Batch of shape (B,).
    displacement, loads : sequence of ndarray, shape (B, n_link)
        A linear static solution and what it is under.
    masses : tuple of LinkMass
        Of all links.
    gravity : tuple of float
        In ground axes, m/s^2.

    Returns
    -------
    LinkForces
        Of rigid links nothing is told.
    """
    force = np.zeros((*motion.angle.shape, 2))
    moment = np.zeros(motion.angle.shape)
    for number, link in enumerate(frames.links):
        if link.rigid:
            continue
        needed = displacement[number] @ link.stiffness - loads[number]
        angle = motion.angle[:, number]
        x, y = (needed[:, row, None] for row in link.start)
        force[:, number] = x * direction(angle) + y * normal(angle)
        moment[:, number] = needed[:, link.start_rotation[:1]].sum(axis=1)
    return LinkForces(motion, masses, gravity, force, moment, (), ())
