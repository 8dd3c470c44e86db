"""A rigid link as a link of three coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linear_system.chains import whole
from flexmech.linear_system.link_model import NONE, LinkModel, RigidFields
from flexmech.linear_system.link_readings import LinkReadings
from flexmech.linkages import LinkMass, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.types import FloatArray


def rigid_link(name: str, mass: LinkMass) -> LinkModel:
    """Model of a rigid link: displacement of its start along and across, and its rotation.

    With the place r of its matter from the start, the displacement is ``u + phi J r``.

    Parameters
    ----------
    name : str
    mass : LinkMass
        Distributed, in points and in bodies.

    Returns
    -------
    LinkModel
        Its end is no pair of coordinates, but follows from the three.
    """
    total, along, across = mass.moment(0), mass.moment(1), mass.moment_across
    inertia = np.array(
        [
            [total, 0.0, -across],
            [0.0, total, along],
            [-across, along, mass.moment(2)],
        ]
    )
    gyroscopic = np.array(
        [
            [0.0, -total, -along],
            [total, 0.0, -across],
            [along, across, 0.0],
        ]
    )
    # As in flexible links, matter off the axis that turns about it keeps its centrifugal potential.
    on_axis = mass.moment(2) - off_axis_inertia(mass)
    translational = inertia.copy()
    translational[2, 2] = on_axis
    nothing = np.zeros((3, 3))
    ends = np.array([0.0, mass.length])
    # Both ends of a rigid bar with the rotation of each.
    bar = np.zeros((6, 3))
    bar[:3] = bar[3:] = np.eye(3)
    bar[4, 2] = mass.length
    start, rotation = np.array([0, 1]), np.array([2])
    along_it, across_it, turning = np.eye(3)
    return LinkModel(
        name=name,
        mass=inertia,
        gyroscopic=gyroscopic,
        translational_mass=translational,
        first_moment=np.array([[across, -along, -on_axis], [along, across, 0.0]]),
        stiffness=nothing,
        damping=nothing,
        is_axial=np.zeros(3, dtype=bool),
        start=start,
        end=NONE.copy(),
        start_rotation=rotation,
        end_rotation=rotation,
        readings=LinkReadings(ends, 3, _straight, slope=2, deflection=None, basis=bar),
        fields=RigidFields(along_it, across_it, np.zeros(3), turning),
        vectors=start[:, None],
        rigid=True,
    )


def off_axis_inertia(mass: LinkMass) -> float:
    """Polar second moment in kg m^2 of matter about its own place on the axis of the link.

    Parameters
    ----------
    mass : LinkMass

    Returns
    -------
    float
    """
    distributed = mass.mass_per_length * mass.length * mass.offset**2
    bodies = (b.inertia + b.mass * (b.offset[0] ** 2 + b.offset[1] ** 2) for b in mass.bodies)
    return distributed + sum(bodies)


def _straight(fraction: FloatArray, length: FloatArray) -> FloatArray:
    """Displacement of a bar whose ends are (u, v, phi) each, (s, 2, 6)."""
    shapes = np.zeros((len(fraction), 2, 6))
    for component in (0, 1):
        shapes[:, component, component] = 1 - fraction
        shapes[:, component, 3 + component] = fraction
    return shapes


def dead_virial(
    links: Sequence[LinkModel], motion: RigidMotion, gravity: tuple[float, float]
) -> FloatArray:
    """Products of inertia force and weight with their places, from the start of rigid links.

    Parameters
    ----------
    links : sequence of LinkModel
    motion : RigidMotion
        Batch of shape (B,).
    gravity : tuple of float
        In ground axes, m/s^2.

    Returns
    -------
    ndarray, shape (B, n_links)
        In N m; zero of flexible links.
    """
    virial = np.zeros(motion.angle.shape)
    for number, link in enumerate(links):
        if link.rigid:
            pull = motion.origin_acceleration[:, number] - np.asarray(gravity)
            angle = motion.angle[:, number]
            along, across = link.first_moment[1, :2]
            centre = along * direction(angle) + across * normal(angle)
            speed = motion.angular_velocity[:, number]
            virial[:, number] = speed**2 * whole(link.mass)[2, 2] - np.sum(centre * pull, axis=1)
    return virial


def rigid_tangent(
    link: LinkModel, motion: RigidMotion, number: int, turning: FloatArray
) -> FloatArray:
    """Tangent stiffness of a rigid link under forces that keep their direction.

    Matter off the axis that turns about it keeps its centrifugal potential: that is left out
    here, as in the mass of displacements.

    Parameters
    ----------
    link : LinkModel
    motion : RigidMotion
        Batch of shape (B,).
    number : int
        Of the link.
    turning : ndarray, shape (B,)
        Stiffness against rotation by all these forces in N m/rad.

    Returns
    -------
    ndarray, shape (B, 3, 3)
    """
    tangent = np.zeros((len(turning), 3, 3))
    kept = whole(link.mass)[2, 2] - whole(link.translational_mass)[2, 2]
    tangent[:, 2, 2] = turning - motion.angular_velocity[:, number] ** 2 * kept
    return tangent
