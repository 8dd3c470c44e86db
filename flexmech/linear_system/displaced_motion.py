"""The rigid motion in which rigid links are displaced, and what their frames and lines do in it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.linkages.matrix_with_rates import MatrixWithRates as MovingMatrix
from flexmech.linkages import RigidMotion, Topology
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class DisplacedMotion(RigidMotion):
    """Motion whose rigid links are displaced, as in an equilibrium: their frames turn with them.

    Parameters
    ----------
    crank_angle, crank_speed, angle, angular_velocity, angular_acceleration : ndarray
        See :class:`RigidMotion`; batch of shape (B,).
    origin, origin_velocity, origin_acceleration : ndarray
        Likewise.
    turn : ndarray, shape (B, n_links)
        By how much each angle is that of the displaced rigid link rather than that of the rigid
        motion, in rad; zero of flexible links.
    slide : ndarray, shape (B, n_sliders)
        Displacement of each slider along its line in m.
    """

    turn: FloatArray
    slide: FloatArray

    @classmethod
    def of(cls, motion: RigidMotion, turn: FloatArray, slide: FloatArray) -> Self:
        """A rigid motion with its rigid links displaced.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        turn : ndarray, shape (B, n_links)
        slide : ndarray, shape (B, n_sliders)
        """
        own = {field.name: getattr(motion, field.name) for field in fields(RigidMotion)}
        own["angle"] = motion.angle + turn
        return cls(**own, turn=turn, slide=slide)

    @property
    def undisplaced(self) -> RigidMotion:
        """The rigid motion itself."""
        own = {field.name: getattr(self, field.name) for field in fields(RigidMotion)}
        own["angle"] = self.angle - self.turn
        return RigidMotion(**own)

    def at(self, which: NDArray[np.bool_] | IntArray | slice) -> DisplacedMotion:
        """See :meth:`RigidMotion.at`."""
        return type(self)(*(getattr(self, field.name)[which] for field in fields(self)))


def frame_rotation(motion: RigidMotion, link: int) -> MovingMatrix:
    """From a link's frame to ground axes.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,).
    link : int

    Returns
    -------
    MovingMatrix
        Of shape (B, 2, 2).
    """
    return MovingMatrix.rotation(
        motion.angle[:, link],
        motion.angular_velocity[:, link],
        motion.angular_acceleration[:, link],
    )


def slider_lever(motion: RigidMotion, topology: Topology, number: int) -> MovingMatrix:
    """Where the point of a slider is in the frame of its guide.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,).
    topology : Topology
    number : int
        Of the slider; it is guided by a link.

    Returns
    -------
    MovingMatrix
        Of shape (B, 2, 1), in m.
    """
    slider = topology.sliders[number]
    guide, held = topology.index(slider.guide), topology.index(slider.held.link)
    x = 0.0 if slider.held.end == "start" else topology.links[held].length
    angle, moved = motion.angle, np.zeros(len(motion.crank_angle))
    if isinstance(motion, DisplacedMotion):
        angle, moved = motion.angle - motion.turn, motion.slide[:, number]
        motion = DisplacedMotion.of(motion, -motion.turn, motion.slide)
    back = MovingMatrix.rotation(
        -angle[:, guide],
        -motion.angular_velocity[:, guide],
        -motion.angular_acceleration[:, guide],
    )
    distance = MovingMatrix(
        (motion.position(held, x) - motion.origin[:, guide])[..., None],
        (motion.velocity(held, x) - motion.origin_velocity[:, guide])[..., None],
        np.zeros((len(angle), 2, 1)),
        (motion.acceleration(held, x) - motion.origin_acceleration[:, guide])[..., None],
    )
    lever = back @ distance
    along = np.array([np.cos(slider.direction), np.sin(slider.direction)])
    # The point stays on its line: what round-off leaves across it is not motion. The lever's
    # second derivative is an acceleration of the rigid motion along the line.
    sliding = [
        (part[..., 0] @ along)[:, None, None] * along[:, None] for part in (lever.rate, lever.twice)
    ]
    displaced = lever.value + moved[:, None, None] * along[:, None]
    return MovingMatrix(displaced, sliding[0], np.zeros_like(displaced), sliding[1])


def general_position(topology: Topology) -> RigidMotion:
    """One position with the links at angles that have nothing to do with each other.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    RigidMotion
        Batch of shape (1,) of links at rest, which need not meet.
    """
    random = np.random.default_rng(0)
    count = len(topology.links)
    angle, still = random.uniform(-np.pi, np.pi, (1, count)), np.zeros((1, count))
    length = max(link.length for link in topology.links)
    origin = length * random.uniform(-1.0, 1.0, (1, count, 2))
    nowhere = np.zeros((1, count, 2))
    return RigidMotion(still[:, 0], still[:, 0], angle, still, still, origin, nowhere, nowhere)
