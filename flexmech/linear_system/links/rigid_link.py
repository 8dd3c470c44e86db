"""Link model of a rigid link, with three coordinates."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.links.link_model import NONE, LinkModel, RigidFields
from flexmech.linear_system.links.link_readings import LinkReadings
from flexmech.linear_system.links.rigid_body import RigidBody
from flexmech.linkages import LinkMass


def rigid_link(name: str, mass: LinkMass) -> LinkModel:
    """Model of a rigid link in the displacement of its start and its rotation.

    With the place r of its matter from the start, the displacement is ``u + phi J r``.

    Parameters
    ----------
    name : str
    mass : LinkMass
        Distributed, in points and in bodies.

    Returns
    -------
    LinkModel
        Without coordinates of its end, which depends on the three.
    """
    body = RigidBody.of_link(mass)
    inertia, gyroscopic, translational = body.matrices(np.zeros(()))
    along, across = body.first_moment
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
        centrifugal_mass=translational,
        first_moment=np.array(
            [[across, -along, -body.translational_inertia], [along, across, 0.0]]
        ),
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
        bodies=(body,),
    )


def _straight(fraction: FloatArray, length: FloatArray) -> FloatArray:
    """Displacement of a bar whose ends are (u, v, phi) each, (s, 2, 6)."""
    shapes = np.zeros((len(fraction), 2, 6))
    for component in (0, 1):
        shapes[:, component, component] = 1 - fraction
        shapes[:, component, 3 + component] = fraction
    return shapes
