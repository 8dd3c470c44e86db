"""Inertia forces of the rigid motion, and weight, on the links."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.links.chains import times, whole
from flexmech.linear_system.links.link_model import LinkModel, RigidFields
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal


def inertia_loads(
    links: Sequence[LinkModel], motion: RigidMotion, gravity: tuple[float, float]
) -> list[FloatArray]:
    """Distributed inertia forces of the rigid motion and weight, each in its link frame.

    A rigid acceleration is linear along the link and so lies in the space of the shape
    functions: ``-M a`` with the nodal accelerations ``a`` is the exact consistent load.

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
        fields, first_moment = link.fields, link.first_moment[..., 1, :]
        if motion.design is not None:
            fields = RigidFields(*(values[motion.design] for values in vars(fields).values()))
            first_moment = first_moment[motion.design]
        acceleration = (
            along[:, number, None] * fields.along
            + across[:, number, None] * fields.across
            - motion.angular_velocity[:, number, None] ** 2 * fields.centripetal
            + motion.angular_acceleration[:, number, None] * fields.tangential
        )
        # Matter that is elsewhere than the field says, as off the pins' axis, is pulled as well.
        turning = motion.angular_velocity[:, number, None] ** 2
        inertia = acceleration @ link.mass
        if motion.design is not None:
            inertia = times(whole(link.mass), acceleration[..., None])[..., 0]
        loads.append(turning * first_moment - inertia)
    return loads
