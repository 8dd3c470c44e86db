"""Parts of an Exudyn system for each link: items and coordinates.

Coordinates of a beam are those of points on the pins' axis, less the reference ones; see
:mod:`flexmech.multibody.node_maps` for what leads from them to Exudyn's. Those of a rigid link are
the place of its start and its angle, as in Exudyn.

Between absolute coordinates of links in motion and the frames of the rigid links.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import RigidBody, RigidFields
from flexmech.linkages import RigidMotion
from flexmech.linkages.topology import End
from flexmech.multibody.beams import BeamKind
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.node_bodies import NodeBodies
from flexmech.multibody.node_maps import Arms, PolarSlopes
from flexmech.sections import BeamSection

# Coordinates of a rigid link.
RIGID_SIZE = 3


class LinkCoordinates(ABC):
    """Coordinates of a link as those of a rigid one.

    Attributes
    ----------
    fields : RigidFields
        Rigid fields in the link's frame.
    vectors : tuple of ndarray of int, shape (k,)
        X and y coordinates of all vectors in the link frame.
    """

    @property
    @abstractmethod
    def fields(self) -> RigidFields:
        """Rigid fields in the link's frame."""

    @property
    @abstractmethod
    def vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in the link frame, (k,) each."""

    @property
    def straight(self) -> FloatArray:
        """Coordinates of the undeformed link in its own frame, with the reference ones, (n,)."""
        return self.fields.centripetal

    @cached_property
    def rotation(self) -> FloatArray:
        """1 for coordinates that are angles, 0 for all others, (n,)."""
        # Where the link has rotations, they are all of the tangential field but its vectors.
        rotation = self.fields.tangential.copy()
        rotation[np.concatenate(self.vectors)] = 0.0
        return rotation

    def rigid(self, x: FloatArray, y: FloatArray, angle: FloatArray) -> FloatArray:
        """Coordinates of a rigid link displaced and rotated by small values, (m, n).

        Parameters
        ----------
        x, y : ndarray, shape (m, 1)
            Of the start in m.
        angle : ndarray, shape (m, 1)
            In rad.
        """
        return x * self.fields.along + y * self.fields.across + angle * self.rotation

    def pose(self, origin: FloatArray, angle: float) -> FloatArray:
        """Coordinates, less the reference ones, of the undeformed link at a place and angle."""
        motion = [-2 * np.sin(angle / 2) ** 2, np.sin(angle), origin[0], origin[1], angle]
        return np.asarray(motion @ self._motions)

    @cached_property
    def _motions(self) -> FloatArray:
        """Vectors of the straight link and the same turned by 90 deg, and rigid motions, (5, n)."""
        (x, y), straight = self.vectors, self.straight
        vectors, across = np.zeros((2, len(straight)))
        vectors[x], vectors[y] = straight[x], straight[y]
        across[x], across[y] = -straight[y], straight[x]
        fields = self.fields
        return np.stack([vectors, across, fields.along, fields.across, self.rotation])


@dataclass(frozen=True)
class BeamPart(LinkCoordinates):
    """A link of beam elements.

    Parameters
    ----------
    name : str
    section : BeamSection
    kind : BeamKind
    positions : ndarray, shape (e + 1,)
        Node positions along the link in m.
    nodes, elements : list of ItemNumber
    coordinates : slice
        Where the link's coordinates are in the system's.
    arms : Arms, optional
        From the pins' axis to the nodes; None where the section is not eccentric and the
        nodes are on it.
    bodies : NodeBodies, optional
        Bodies at the nodes, which carry all mass; its beams do where there are none.
    polar : PolarSlopes, optional
        Nodes at which something holds the direction of a cable's slope; None where there is no
        such node.
    """

    name: str
    section: BeamSection
    kind: BeamKind
    positions: FloatArray
    nodes: list[ItemNumber]
    elements: list[ItemNumber]
    coordinates: slice
    arms: Arms | None = None
    bodies: NodeBodies | None = None
    polar: PolarSlopes | None = None

    @property
    def length(self) -> float:
        """Length of the link in m."""
        return float(self.positions[-1])

    @property
    def node_map(self) -> Arms | PolarSlopes | None:
        """Map from the link's coordinates to those of its nodes; None where they are the same."""
        return self.arms or self.polar

    @cached_property
    def fields(self) -> RigidFields:
        """See :class:`LinkCoordinates`."""
        return self.kind.rigid_fields(self.positions)

    @cached_property
    def vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in the link frame, (k,) each."""
        x, y = self.force_vectors
        if self.polar is None:
            return x, y
        kept = ~np.isin(x, self.polar.first)
        return x[kept], y[kept]

    @cached_property
    def force_vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors among the forces on Exudyn's coordinates."""
        return self.kind.vector_pairs(len(self.nodes))

    def end_place(self, end: End, position: FloatArray) -> FloatArray:
        """Position of an end from the coordinates of all links (size,), shape (2,)."""
        own = position[self.coordinates]
        if end == "start":
            return np.asarray(own[:2])
        first = len(own) - self.kind.per_node
        return np.asarray(own[first : first + 2] + np.array([self.length, 0.0]))


@dataclass(frozen=True)
class RigidPart(LinkCoordinates):
    """A rigid link: a body with its node at the start of the link.

    Parameters
    ----------
    name : str
    length : float
        In m.
    nodes : list of ItemNumber
        The one node.
    body : ItemNumber
    inertia : RigidBody
        About the start.
    coordinates : slice
    """

    name: str
    length: float
    nodes: list[ItemNumber]
    body: ItemNumber
    inertia: RigidBody
    coordinates: slice

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of mass from the start, along and across the link, in m."""
        mass, (along, across) = self.inertia.mass, self.inertia.first_moment
        return (along / mass, across / mass) if mass else (0.0, 0.0)

    @cached_property
    def fields(self) -> RigidFields:
        """See :class:`LinkCoordinates`."""
        along, across, turning = np.eye(RIGID_SIZE)
        return RigidFields(along, across, np.zeros(RIGID_SIZE), turning)

    @property
    def vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in the link frame, (k,) each."""
        return np.array([0]), np.array([1])

    @property
    def force_vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors among the forces on Exudyn's coordinates."""
        return self.vectors

    def end_place(self, end: End, position: FloatArray) -> FloatArray:
        """Position of an end from the coordinates of all links (size,), shape (2,)."""
        x, y, angle = position[self.coordinates]
        arm = 0.0 if end == "start" else self.length
        return np.array([x + arm * np.cos(angle), y + arm * np.sin(angle)])


LinkPart: TypeAlias = BeamPart | RigidPart
"""One link in the Exudyn system."""


def turn_vectors(values: FloatArray, pairs: tuple[IntArray, IntArray], angle: FloatArray) -> None:
    """Rotate vectors in place.

    Parameters
    ----------
    values : ndarray, shape (m, n)
    pairs : tuple of ndarray of int, shape (k,)
        Their x and y coordinates.
    angle : ndarray, shape (m,)
        In rad.
    """
    x, y = pairs
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along, across = values[:, x], values[:, y]
    values[:, x] = cosine * along - sine * across
    values[:, y] = sine * along + cosine * across


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
        :class:`flexmech.multibody.node_maps.LinkNodes` where not.

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
            vectors = rate[link] + speed * _quarter_turned(part, local)
            place, drift = _rigid(part, motion, link)
            position[:, part.coordinates] = _turned(part, local, angle) + place - straight
            velocity[:, part.coordinates] = _turned(part, vectors, angle) + drift
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
            vectors = _unwound(part, position[:, part.coordinates] + straight - place)
            local = _turned(part, vectors, -angle)
            moving = _turned(part, velocity[:, part.coordinates] - drift, -angle)
            displacement.append(local - straight)
            rate.append(moving - speed * _quarter_turned(part, local))
        return displacement, rate


def _rigid(part: LinkPart, motion: RigidMotion, link: int) -> tuple[FloatArray, FloatArray]:
    """Contribution of the frame's position to coordinates and of its velocity to rates."""
    added = []
    for point, angle in (
        (motion.origin, motion.angle),
        (motion.origin_velocity, motion.angular_velocity),
    ):
        x, y = point[:, link, 0, None], point[:, link, 1, None]
        added.append(part.rigid(x, y, angle[:, link, None]))
    return added[0], added[1]


def _turned(part: LinkPart, values: FloatArray, angle: FloatArray) -> FloatArray:
    """Coordinates (m, n_link) with every vector rotated by an angle (m,); scalars stay."""
    turned = values.copy()
    turn_vectors(turned, part.vectors, angle)
    return turned


def _quarter_turned(part: LinkPart, values: FloatArray) -> FloatArray:
    """Vectors of (m, n_link) rotated by 90 deg; zero for other coordinates."""
    x, y = part.vectors
    turned = np.zeros_like(values)
    turned[:, x], turned[:, y] = -values[:, y], values[:, x]
    return turned


def _unwound(part: LinkPart, coordinates: FloatArray) -> FloatArray:
    """Angles within half a turn; the angles of a linkage may jump by whole turns."""
    turns = np.round(coordinates / (2 * np.pi))
    return coordinates - np.where(part.rotation, 2 * np.pi * turns, 0.0)
