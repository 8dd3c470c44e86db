"""Inertia forces of the rigid motion, and weight, on the links."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.links.link_inertia import FIELDS, rigid_inertia
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal


def inertia_loads(
    links: Sequence[LinkModel], motion: RigidMotion, gravity: tuple[float, float]
) -> list[FloatArray]:
    """Distributed inertia forces of the rigid motion and weight, each in its link frame.

    A rigid acceleration is linear along the link and so lies in the space of the shape
    functions: ``-M a`` with the nodal accelerations ``a`` is the exact consistent load. The couples
    of sections whose rotary inertia M leaves out are added; see
    :func:`flexmech.linear_system.links.link_inertia.rigid_inertia`.

    Parameters
    ----------
    links : sequence of LinkModel
    motion : RigidMotion
        Batch of shape (B,).
    gravity : tuple of float
        In ground axes, m/s^2.

    Returns
    -------
    list of ndarray, shape (B, n)
    """
    pull = motion.origin_acceleration - np.asarray(gravity)
    along = np.sum(pull * direction(motion.angle), axis=-1)
    across = np.sum(pull * normal(motion.angle), axis=-1)
    loads = []
    for number, link in enumerate(links):
        turning = motion.angular_velocity[:, number] ** 2
        change = motion.angular_acceleration[:, number]
        factors = np.stack([-along[:, number], -across[:, number], -change, turning], axis=-1)
        unit = rigid_inertia(link)
        # Matter that is elsewhere than the field says, as off the pins' axis, is pulled as well.
        unit[:, FIELDS.index("centripetal")] += link.first_moment[1]
        loads.append(factors @ unit.T)
    return loads
