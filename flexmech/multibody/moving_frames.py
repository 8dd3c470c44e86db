"""Between absolute coordinates of links in motion and the frames of the rigid links."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linkages import RigidMotion
from flexmech.multibody.link_parts import LinkPart, turn_vectors
from flexmech.types import FloatArray


class MovingFrames:
    """Coordinates and velocities of links that move, batched over instants.

    Parameters
    ----------
    parts : sequence of LinkPart
        The links in an Exudyn system in ground axes.
    """

    def __init__(self, parts: Sequence[LinkPart]) -> None:
        self.parts = parts
        self.size = parts[-1].coordinates.stop

    def to_absolute(
        self, motion: RigidMotion, displacement: Sequence[FloatArray], rate: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Coordinates in ground axes and velocities of links displaced in their frames.

        They are Exudyn's where the nodes are on the pins' axis, and lead to them by
        :class:`flexmech.multibody.arms.LinkArms` where not.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        displacement, rate : sequence of ndarray, shape (m, n_link)

        Returns
        -------
        position, velocity : ndarray, shape (m, size)
        """
        position = np.empty((len(motion.crank_angle), self.size))
        velocity = np.empty_like(position)
        for link, part in enumerate(self.parts):
            angle, speed = motion.angle[:, link], motion.angular_velocity[:, link, None]
            straight = part.straight
            local = straight + displacement[link]
            carried = rate[link] + speed * _quarter_turned(part, local)
            place, drift = _rigid(part, motion, link)
            position[:, part.coordinates] = _turned(part, local, angle) + place - straight
            velocity[:, part.coordinates] = _turned(part, carried, angle) + drift
        return position, velocity

    def to_frames(
        self, motion: RigidMotion, position: FloatArray, velocity: FloatArray
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Displacement and rate of the links in their frames; undoes :meth:`to_absolute`.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        position, velocity : ndarray, shape (m, size)

        Returns
        -------
        displacement, rate : list of ndarray, shape (m, n_link)
        """
        displacement, rate = [], []
        for link, part in enumerate(self.parts):
            angle, speed = motion.angle[:, link], motion.angular_velocity[:, link, None]
            straight = part.straight
            place, drift = _rigid(part, motion, link)
            carried = _unwound(part, position[:, part.coordinates] + straight - place)
            local = _turned(part, carried, -angle)
            moving = _turned(part, velocity[:, part.coordinates] - drift, -angle)
            displacement.append(local - straight)
            rate.append(moving - speed * _quarter_turned(part, local))
        return displacement, rate


def _rigid(part: LinkPart, motion: RigidMotion, link: int) -> tuple[FloatArray, FloatArray]:
    """What the frame's place and angle add to coordinates, its motion to velocities."""
    added = []
    for point, angle in (
        (motion.origin, motion.angle),
        (motion.origin_velocity, motion.angular_velocity),
    ):
        x, y = point[:, link, 0, None], point[:, link, 1, None]
        added.append(x * part.along + y * part.across + angle[:, link, None] * part.rotation)
    return added[0], added[1]


def _turned(part: LinkPart, values: FloatArray, angle: FloatArray) -> FloatArray:
    """Coordinates (m, n_link) with every vector turned by an angle (m,); scalars stay."""
    turned = values.copy()
    turn_vectors(turned, part.vectors, angle)
    return turned


def _quarter_turned(part: LinkPart, values: FloatArray) -> FloatArray:
    """Vectors of (m, n_link) turned by a quarter; other coordinates give nothing."""
    x, y = part.vectors
    turned = np.zeros_like(values)
    turned[:, x], turned[:, y] = -values[:, y], values[:, x]
    return turned


def _unwound(part: LinkPart, coordinates: FloatArray) -> FloatArray:
    """Angles within half a turn; the angles of a linkage may jump by whole turns."""
    turns = np.round(coordinates / (2 * np.pi))
    return coordinates - np.where(part.rotation, 2 * np.pi * turns, 0.0)
