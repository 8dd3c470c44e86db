"""Energy that springs store, and power that dampers take and loads give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.linear_system import AttachedPoint, Connectors
from flexmech.linkages import RigidMotion, continuous_angles
from flexmech.linkages.applied_forces import SpringLine
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray


@dataclass(frozen=True)
class ConnectorWork:
    """Energy of springs in J, power that dampers take and loads give in W; each (m,)."""

    stored: FloatArray
    dissipation: FloatArray
    power: FloatArray


def connector_work(
    mechanism: Mechanism,
    connectors: Connectors,
    motion: RigidMotion,
    elastic: Sequence[tuple[FloatArray, ...]],
    power: FloatArray,
) -> ConnectorWork:
    """Energy and power at m instants, by where the ends of the springs are.

    Parameters
    ----------
    mechanism : Mechanism
    connectors : Connectors
        Of the links whose coordinates are given.
    motion : RigidMotion
        Batch of shape (m,).
    elastic : sequence of tuple of ndarray, shape (m, n_link)
        Displacement and rate in the frame of each link.
    power : ndarray, shape (m,)
        That loads give.

    Returns
    -------
    ConnectorWork
    """
    stored, dissipation = np.zeros((2, len(motion.crank_angle)))
    topology = mechanism.linkage.topology
    size = max(link.length for link in topology.links)

    def moved(point: AttachedPoint | None) -> tuple[FloatArray, FloatArray]:
        """Displacement and its rate in ground axes, and rotation; (m, 3) each."""
        if point is None:
            return np.zeros((2, 1, 3))[0], np.zeros((1, 3))
        q, rate = elastic[point.link][:2]
        return point.displacement(motion, q), point.displacement_rate(motion, q, rate)

    for spring in mechanism.springs:
        first, second = connectors.spring_ends(spring, motion)
        (before, drift), (after, drifting) = moved(first.point), moved(second.point)
        line = SpringLine.of(
            spring,
            motion.crank_angle,
            (first.place + before[:, :2], second.place + after[:, :2]),
            (first.velocity + drift[:, :2], second.velocity + drifting[:, :2]),
            size,
            needs_direction=False,
        )
        stored += spring.stiffness * (line.length - spring.free_length) ** 2 / 2
        dissipation += spring.damping * line.rate**2
    if not mechanism.joint_springs:
        return ConnectorWork(stored, dissipation, power)
    angles = continuous_angles(mechanism.linkage, motion)
    for own in mechanism.joint_springs:
        second_point, first_point = connectors.joint_points(own)
        (before, drift), (after, drifting) = moved(first_point), moved(second_point)
        apart, parting = after - before, drifting - drift
        opening = apart[:, 2] + topology.opening(own.joint, angles) - own.free_angle
        rate = parting[:, 2] + topology.opening(own.joint, motion.angular_velocity)
        stored += own.torsional_stiffness * opening**2 / 2
        dissipation += own.torsional_damping * rate**2
        if own.radial_stiffness is not None:
            stored += own.radial_stiffness * np.sum(apart[:, :2] ** 2, axis=1) / 2
            dissipation += own.radial_damping * np.sum(parting[:, :2] ** 2, axis=1)
    return ConnectorWork(stored, dissipation, power)
