"""Couples and forces of springs on links, for component modes."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.loads.connectors import Connectors
from flexmech.mechanism import Mechanism


def has_dampers(mechanism: Mechanism) -> bool:
    """Whether a spring, one in a joint or one of the frame has a damper."""
    joints = any(own.torsional_damping or own.radial_damping for own in mechanism.joint_springs)
    framed = mechanism.frame is not None and mechanism.frame.damping.any()
    return bool(joints or framed or any(spring.damping for spring in mechanism.springs))


def joint_couples(mechanism: Mechanism, connectors: Connectors) -> list[FloatArray]:
    """Couples of torsional springs and dampers on the ends of links.

    Parameters
    ----------
    mechanism : Mechanism
    connectors : Connectors
        Of its links.

    Returns
    -------
    list of ndarray, shape (n_link, k)
        Force of a unit couple at each of k ends of every link, in its coordinates.
    """
    links = connectors.links
    found: list[list[FloatArray]] = [[] for _ in links]
    for own in mechanism.joint_springs:
        if not (own.torsional_stiffness or own.torsional_damping):
            continue
        for point in connectors.joint_points(own):
            if point is not None and not point.rigid:
                found[point.link].append(point.rows[2])
    for spring in mechanism.springs:
        for place in (spring.first, spring.second):
            point = connectors.point(place)
            if point is not None and not point.rigid:
                found[point.link] += [*point.rows[:2]]
    return [
        np.stack(rows, axis=1) if rows else np.zeros((link.size, 0))
        for link, rows in zip(links, found, strict=True)
    ]
