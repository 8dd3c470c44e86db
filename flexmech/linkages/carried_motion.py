"""Motion of a linkage in ground axes as a frame carries it that moves itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.motion import RigidMotion, direction, normal, quarter_turn


def carried_motion(
    centre: tuple[float, float],
    motion: RigidMotion,
    place: FloatArray,
    rate: FloatArray,
    change: FloatArray | None = None,
) -> RigidMotion:
    """Motion of link frames in ground axes, as a frame carries them.

    Parameters
    ----------
    centre : tuple of float
        Of the frame as it is drawn, in m.
    motion : RigidMotion
        In the axes of the frame, batch of shape (B,).
    place, rate, change : ndarray, shape (B, 3)
        Coordinates of the frame and their time derivatives; the second ones count for nothing but
        accelerations, and are zero if left out.

    Returns
    -------
    RigidMotion
    """
    change = np.zeros_like(place) if change is None else change
    turn, spin, swing = (own[:, 2, None] for own in (place, rate, change))
    arm = turned(motion.origin - np.asarray(centre), turn)
    velocity = turned(motion.origin_velocity, turn)
    acceleration = turned(motion.origin_acceleration, turn)
    by_spin = spin[..., None] * quarter_turn(arm)
    by_swing = swing[..., None] * quarter_turn(arm) - spin[..., None] ** 2 * arm
    coriolis = 2 * spin[..., None] * quarter_turn(velocity)
    return replace(
        motion,
        angle=motion.angle + turn,
        angular_velocity=motion.angular_velocity + spin,
        angular_acceleration=motion.angular_acceleration + swing,
        origin=np.asarray(centre) + place[:, None, :2] + arm,
        origin_velocity=rate[:, None, :2] + velocity + by_spin,
        origin_acceleration=change[:, None, :2] + acceleration + coriolis + by_swing,
    )


def turned(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by angles (...) in rad to the left."""
    return np.asarray(vector[..., :1] * direction(angle) + vector[..., 1:] * normal(angle))
