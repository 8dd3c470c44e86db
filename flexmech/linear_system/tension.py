"""Tension in the links of the undeformed linkage under its own inertia forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linkages import RigidMotion
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["element_tensions"]


def element_tensions(
    mechanism: Mechanism,
    nodes: Sequence[FloatArray],
    motion: RigidMotion,
    lumped: Sequence[int] | None = None,
) -> list[FloatArray]:
    """Axial force in each element under the motion's inertia forces, in N.

    With the crank held the linkage is statically determinate, so the linear static
    solution's axial force is that of the rigid linkage; it is quadratic along an element,
    and its mean is what the element's end displacements alone would give.

    Parameters
    ----------
    mechanism : Mechanism
    nodes : sequence of ndarray, shape (e + 1,)
        Node positions along each link in m.
    motion : RigidMotion
        Batch of shape (B,).
    lumped : sequence of int, optional
        Number of elements of each link whose mass is lumped at their ends.

    Returns
    -------
    list of ndarray, shape (B, e, 3)
        Legendre coefficients along each element: mean, linear, quadratic.
    """
    forces = mechanism.inverse_dynamics(motion, lumped=lumped)
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
