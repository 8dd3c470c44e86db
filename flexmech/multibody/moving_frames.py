"""Between absolute coordinates of links in motion and the frames of the rigid links."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system import LinkModel
from flexmech.linkages import RigidMotion
from flexmech.multibody.assembly import LinkPart
from flexmech.multibody.beam_kind import BeamKind
from flexmech.types import FloatArray

__all__ = ["MovingFrames"]


class MovingFrames:
    """Coordinates and velocities of links that move, batched over instants.

    Parameters
    ----------
    kind : BeamKind
    parts : sequence of LinkPart
        The links in an Exudyn system in ground axes.
    links : sequence of LinkModel
    """

    def __init__(
        self, kind: BeamKind, parts: Sequence[LinkPart], links: Sequence[LinkModel]
    ) -> None:
        self.kind = kind
        self.parts = parts
        self.links = links
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
            straight = self.links[link].fields.centripetal
            local = straight + displacement[link]
            carried = rate[link] + speed * self._quarter_turned(local)
            place, drift = self._rigid(motion, link)
            position[:, part.coordinates] = self.kind.turned(local, angle) + place - straight
            velocity[:, part.coordinates] = self.kind.turned(carried, angle) + drift
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
            straight = self.links[link].fields.centripetal
            place, drift = self._rigid(motion, link)
            carried = self._unwound(position[:, part.coordinates] + straight - place)
            local = self.kind.turned(carried, -angle)
            moving = self.kind.turned(velocity[:, part.coordinates] - drift, -angle)
            displacement.append(local - straight)
            rate.append(moving - speed * self._quarter_turned(local))
        return displacement, rate

    def _rigid(self, motion: RigidMotion, link: int) -> tuple[FloatArray, FloatArray]:
        """What the frame's place and angle add to coordinates, its motion to velocities."""
        fields = self.links[link].fields
        # Where the beam has rotations, they are all of the tangential field but its vectors.
        rotation = np.where(self._is_vector(len(fields.along)), 0.0, fields.tangential)
        added = []
        for point, angle in (
            (motion.origin, motion.angle),
            (motion.origin_velocity, motion.angular_velocity),
        ):
            x, y = point[:, link, 0, None], point[:, link, 1, None]
            added.append(x * fields.along + y * fields.across + angle[:, link, None] * rotation)
        return added[0], added[1]

    def _quarter_turned(self, vectors: FloatArray) -> FloatArray:
        """Vectors (m, n_link) turned by a quarter; rotations give nothing."""
        x, y = self.kind.vector_pairs(vectors.shape[1] // self.kind.per_node)
        turned = np.zeros_like(vectors)
        turned[:, x], turned[:, y] = -vectors[:, y], vectors[:, x]
        return turned

    def _unwound(self, coordinates: FloatArray) -> FloatArray:
        """Rotations within half a turn; the angles of a linkage may jump by whole turns."""
        turns = np.round(coordinates / (2 * np.pi))
        return coordinates - np.where(self._is_vector(coordinates.shape[1]), 0.0, 2 * np.pi * turns)

    def _is_vector(self, size: int) -> NDArray[np.bool_]:
        x, y = self.kind.vector_pairs(size // self.kind.per_node)
        return np.isin(np.arange(size), np.concatenate([x, y]))
