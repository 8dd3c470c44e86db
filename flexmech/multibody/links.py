"""Links of a mechanism in an Exudyn system: their nodes, beams and bodies, and their coordinates.

Coordinates of a beam are those of points on the pins' axis, less the reference ones. Those of a
rigid link are the place of its start and its angle, as in Exudyn: those of the one node of a chain
without beams.

Rigid bodies that are fixed to links of beams are hubs, counterweights, pistons. On an exact beam
such a body shares the node, which turns. A cable's node has a slope and no angle: the body has a
node of its own, pinned to the cable's and kept from turning against its slope.

Maps lead from them to the coordinates of Exudyn's nodes, where these are not the same. A beam
stretches and bends without coupling about its neutral axis, so its nodes are there, and all other
parts use displacements of the pins' axis. With the neutral axis at the distance n and the section
rotated by phi, a node is at ``u - n sin(phi)``, ``v + n (cos(phi) - 1)``.

A cable's node has a slope vector ``(1 + s_x, s_y)``. A weld keeps the angle between two such
vectors, and a body on a node turns with one; the stretch of each is the link's own. By stretch e
and angle phi,

    s_x = (1 + e) cos(phi) - 1,    s_y = (1 + e) sin(phi),

such a condition is linear: two angles differ by a constant. Its forces then add nothing to the
tangent stiffness but what this map adds, second derivatives of the slope times the forces on it.
To first order about the straight link both pairs of coordinates are the same.

Both maps hold in every frame if phi is the angle against that frame.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import LinkBody, LinkEnd, LinkMass, Load
from flexmech.linkages.link_mass import LEAST_DISTANCE
from flexmech.linkages.motion import direction
from flexmech.linkages.topology import End
from flexmech.mechanics import RigidBody, RigidFields, body_nodes
from flexmech.mechanics.links.link_model import NONE
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.beams import BEAM_KINDS, BeamKind, add_node_bodies
from flexmech.multibody.items import ItemNumber, SystemBody, SystemItems
from flexmech.sections import BeamSection


class NodeMap(ABC):
    """Map of links, block by block of their coordinates, less the reference ones.

    Parameters
    ----------
    first : ndarray of int, shape (k,)
        First coordinate of each block; all coordinates in no block are the nodes' own.
    length : float or ndarray, shape (k,)
        Distance of the nodes from the axis along the link frame's y in m.
    """

    block: ClassVar[int]
    """Coordinates of a block."""

    def __init__(self, first: IntArray, length: float | FloatArray = 0.0) -> None:
        self.first, self.length = first, length
        self.at = first[:, None] + np.arange(self.block)

    @classmethod
    def joined(cls, maps: Sequence[tuple[NodeMap, int]]) -> Self:
        """Map of several links, each with its first coordinate among those of all."""
        none: list[IntArray] = [np.zeros(0, dtype=np.intp)]
        first = [one.first + start for one, start in maps]
        length = [np.full(len(one.first), one.length) for one, _ in maps]
        return cls(np.concatenate(first or none), np.concatenate(length or none))

    @abstractmethod
    def of_nodes(self, q: FloatArray) -> FloatArray:
        """Nodes' coordinates of blocks q, (..., k, b)."""

    @abstractmethod
    def of_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`of_nodes`."""

    @abstractmethod
    def gradient(self, q: FloatArray) -> FloatArray:
        """Derivative of the nodes' coordinates by those of blocks q, (..., k, b, b)."""

    @abstractmethod
    def curvature(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """Second derivative of the work of constant forces (..., k, b), (..., k, b, b)."""

    def gradient_rate(self, q: FloatArray, rate: FloatArray) -> FloatArray:
        """Time derivative of :meth:`gradient` at rates (..., k, b) of blocks, (..., k, b, b)."""
        units = np.eye(self.block)
        rows = [self.curvature(q, np.broadcast_to(u, q.shape)) @ rate[..., None] for u in units]
        return np.stack([row[..., 0] for row in rows], axis=-2)

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Coordinates of the nodes.

        Parameters
        ----------
        axis : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        nodes = axis.copy()
        nodes[..., self.at] = self.of_nodes(axis[..., self.at])
        return nodes

    def to_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`to_nodes`; angles are within half a turn.

        Parameters
        ----------
        nodes : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        axis = nodes.copy()
        axis[..., self.at] = self.of_axis(nodes[..., self.at])
        return axis

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Velocities of the nodes.

        Parameters
        ----------
        axis, rate : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        return self._rates(self.gradient(axis[..., self.at]), rate)

    def rate_to_axis(self, nodes: FloatArray, rate: FloatArray) -> FloatArray:
        """Inverse of :meth:`rate_to_nodes` by the coordinates and velocities of the nodes.

        Parameters
        ----------
        nodes, rate : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        gradient = self.gradient(self.of_axis(nodes[..., self.at]))
        return self._rates(np.asarray(np.linalg.inv(gradient), dtype=float), rate)

    def acceleration_to_nodes(
        self, axis: FloatArray, rate: FloatArray, acceleration: FloatArray
    ) -> FloatArray:
        """Accelerations of the nodes.

        Parameters
        ----------
        axis, rate, acceleration : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        moved, at = self.rate_to_nodes(axis, acceleration), self.at
        turning = self.gradient_rate(axis[..., at], rate[..., at])
        moved[..., at] += (turning @ rate[..., at, None])[..., 0]
        return moved

    def force(self, axis: FloatArray, force: FloatArray) -> FloatArray:
        """Forces on the nodes' coordinates as those on the link's, ``J' f``.

        Parameters
        ----------
        axis, force : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        return self._rates(np.swapaxes(self.gradient(axis[..., self.at]), -1, -2), force)

    def matrix(self, axis: FloatArray, matrix: FloatArray) -> FloatArray:
        """A matrix of the nodes' coordinates in those of the link, ``J' X J``.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
        matrix : ndarray, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        whole = self._gradient_of_all(axis)
        return np.asarray(np.swapaxes(whole, -1, -2) @ matrix @ whole)

    def tangent(self, axis: FloatArray, stiffness: FloatArray, force: FloatArray) -> FloatArray:
        """Tangent stiffness in the link's coordinates.

        Parameters
        ----------
        axis : ndarray, shape (..., n)
        stiffness : ndarray, shape (..., n, n)
            Stiffness of the nodes.
        force : ndarray, shape (..., n)
            Internal forces on the nodes, less outer ones that keep their direction.

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        return self.matrix(axis, stiffness) + self.geometric_stiffness(axis, force)

    def geometric_stiffness(self, axis: FloatArray, force: FloatArray) -> FloatArray:
        """Second derivative of the work of constant forces on the nodes by the link's coordinates.

        Parameters
        ----------
        axis, force : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        stiffness, at = np.zeros((*axis.shape, axis.shape[-1])), self.at
        curvature = self.curvature(axis[..., at], force[..., at])
        stiffness[..., at[:, :, None], at[:, None]] = curvature
        return stiffness

    def damping_stiffness(
        self, axis: FloatArray, rate: FloatArray, damping: FloatArray
    ) -> FloatArray:
        """Derivative of damping forces ``J' D J q.`` by the coordinates q in J.

        Parameters
        ----------
        axis, rate : ndarray, shape (..., n)
        damping : ndarray, shape (..., n, n)
            Derivative of the forces on the nodes by their velocities.

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        whole, at = self._gradient_of_all(axis), self.at
        changing = np.zeros_like(whole)
        turning = self.gradient_rate(axis[..., at], rate[..., at])
        changing[..., at[:, :, None], at[:, None]] = turning
        force = (damping @ self.rate_to_nodes(axis, rate)[..., None])[..., 0]
        by_rate = np.swapaxes(whole, -1, -2) @ damping @ changing
        return self.geometric_stiffness(axis, force) + np.asarray(by_rate)

    def _gradient_of_all(self, axis: FloatArray) -> FloatArray:
        """Derivative of all nodes' coordinates by those of the link, (..., n, n)."""
        whole = np.zeros((*axis.shape, axis.shape[-1]))
        whole[..., :, :] = np.eye(axis.shape[-1])
        whole[..., self.at[:, :, None], self.at[:, None]] = self.gradient(axis[..., self.at])
        return whole

    def _rates(self, matrices: FloatArray, values: FloatArray) -> FloatArray:
        mapped = values.copy()
        mapped[..., self.at] = (matrices @ values[..., self.at, None])[..., 0]
        return mapped


class Arms(NodeMap):
    """Rigid arms from points on the pins' axis to the nodes, which turn with the sections.

    The blocks are the coordinates of each node; see :class:`NodeMap`.
    """

    block = 3

    def of_nodes(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        return self._moved(q, 1.0)

    def of_axis(self, nodes: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        return self._moved(nodes, -1.0)

    def gradient(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        gradient = np.zeros((*q.shape, 3))
        gradient[..., :, :] = np.eye(3)
        gradient[..., 0, 2] = -self.length * np.cos(q[..., 2])
        gradient[..., 1, 2] = -self.length * np.sin(q[..., 2])
        return gradient

    def curvature(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        curvature, angle = np.zeros((*q.shape, 3)), q[..., 2]
        turned = force[..., 0] * np.sin(angle) - force[..., 1] * np.cos(angle)
        curvature[..., 2, 2] = self.length * turned
        return curvature

    def _moved(self, q: FloatArray, sign: float) -> FloatArray:
        moved, length = q.copy(), sign * self.length
        moved[..., 0] -= length * np.sin(q[..., 2])
        moved[..., 1] -= 2 * length * np.sin(q[..., 2] / 2) ** 2
        return moved


class PolarSlopes(NodeMap):
    """Stretch and angle of the slope as coordinates of nodes of cables.

    The blocks are the stretch and the angle of each; see :class:`NodeMap`.
    """

    block = 2

    def of_nodes(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        stretch, angle = q[..., 0], q[..., 1]
        # (1 + e) cos(phi) - 1, whose digits a difference of ones would lose.
        nodes = np.empty_like(q)
        nodes[..., 0] = stretch * np.cos(angle) - 2 * np.sin(angle / 2) ** 2
        nodes[..., 1] = (1 + stretch) * np.sin(angle)
        return nodes

    def of_axis(self, nodes: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        x, y, axis = 1 + nodes[..., 0], nodes[..., 1], np.empty_like(nodes)
        axis[..., 0], axis[..., 1] = np.hypot(x, y) - 1, np.arctan2(y, x)
        return axis

    def gradient(self, q: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        length, cosine, sine = 1 + q[..., 0], np.cos(q[..., 1]), np.sin(q[..., 1])
        rows = [[cosine, -length * sine], [sine, length * cosine]]
        return np.moveaxis(np.array(rows), (0, 1), (-2, -1))

    def curvature(self, q: FloatArray, force: FloatArray) -> FloatArray:
        """See :class:`NodeMap`."""
        cosine, sine = np.cos(q[..., 1]), np.sin(q[..., 1])
        x, y = force[..., 0], force[..., 1]
        along, across = x * cosine + y * sine, y * cosine - x * sine
        rows = [[np.zeros_like(along), across], [across, -(1 + q[..., 0]) * along]]
        return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


class LinkNodes:
    """Map from coordinates of all links together to Exudyn's, less the reference ones.

    Parameters
    ----------
    mapped : NodeMap
        Map of the coordinates of all links.
    size : int
        Number of coordinates of all links.
    bodies : sequence of int
        Coordinates of links that those of attached bodies are, in order: they come after those
        of all links among Exudyn's.
    """

    def __init__(self, mapped: NodeMap, size: int, bodies: Sequence[int]) -> None:
        self._map, self._links, self._bodies = mapped, slice(0, size), list(bodies)

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Exudyn's coordinates (..., system_size) of links (..., size)."""
        return np.concatenate([self._map.to_nodes(axis), axis[..., self._bodies]], axis=-1)

    def to_axis(self, nodes: FloatArray) -> FloatArray:
        """Inverse of :meth:`to_nodes`, (..., size)."""
        return self._map.to_axis(nodes[..., self._links])

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Exudyn's velocities (..., system_size) of links (..., size)."""
        moved = self._map.rate_to_nodes(axis, rate)
        return np.concatenate([moved, rate[..., self._bodies]], axis=-1)

    def rate_to_axis(self, nodes: FloatArray, rate: FloatArray) -> FloatArray:
        """Inverse of :meth:`rate_to_nodes`, (..., size)."""
        return self._map.rate_to_axis(nodes[..., self._links], rate[..., self._links])


@dataclass(frozen=True)
class LinkPart:
    """A link in an Exudyn system: a rigid one, or as a :class:`BeamPart` one of beam elements.

    Parameters
    ----------
    name : str
    length : float
        In m.
    kind : BeamKind
        Whose coordinates its nodes have.
    positions : ndarray, shape (k,)
        Positions of the nodes along the link in m; a rigid link has one at its start.
    nodes : list of ItemNumber
    bodies : list of ItemNumber
        At the nodes, with all mass; of cables, whose elements carry it, there are none.
    coordinates : slice
        Where the link's coordinates are in those of all links.
    node_map : NodeMap
        Map from them to those of the nodes, on the neutral axis. For a cable it leads to the nodes
        at which something holds the direction of the slope.
    """

    name: str
    length: float
    kind: BeamKind
    positions: FloatArray
    nodes: list[ItemNumber]
    bodies: list[ItemNumber]
    coordinates: slice
    node_map: NodeMap

    @property
    def axis_below(self) -> float:
        """Distance of the nodes from the pins' axis, across the link, in m."""
        return float(self.node_map.length)

    @property
    def firsts(self) -> IntArray:
        """First coordinate of each node among those of all links, (k,)."""
        columns = self.coordinates
        return np.arange(columns.start, columns.stop, self.kind.per_node)

    @cached_property
    def fields(self) -> RigidFields:
        """Rigid fields in the link's frame."""
        return self.kind.rigid_fields(self.positions)

    @cached_property
    def force_vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors among the forces on Exudyn's coordinates."""
        return self.kind.vector_pairs(len(self.nodes))

    @cached_property
    def vectors(self) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in the link frame, (k,) each."""
        x, y = self.force_vectors
        kept = ~np.isin(x, self.stretches)
        return x[kept], y[kept]

    @property
    def stretches(self) -> IntArray:
        """Coordinates that are stretches of slopes, next to their angles."""
        return self.node_map.first if isinstance(self.node_map, PolarSlopes) else NONE

    @cached_property
    def rotation(self) -> FloatArray:
        """1 for coordinates that are angles, 0 for all others, (n,)."""
        # Where the link has rotations, they are all of the tangential field but its vectors.
        rotation = self.fields.tangential.copy()
        rotation[np.concatenate(self.vectors)] = 0.0
        return rotation

    @cached_property
    def straight(self) -> FloatArray:
        """Vectors of the straight link in its frame, with the reference coordinates, (n,)."""
        straight, vectors = np.zeros(len(self.rotation)), np.concatenate(self.vectors)
        straight[vectors] = self.fields.centripetal[vectors]
        return straight

    def pose(self, origin: FloatArray, angle: FloatArray) -> FloatArray:
        """Coordinates, less the reference ones, of the undeformed link at places and angles.

        Parameters
        ----------
        origin : ndarray, shape (m, 2)
            Origin of its start in m.
        angle : ndarray, shape (m,)
            In rad.

        Returns
        -------
        ndarray, shape (m, n)
        """
        # cos(angle) - 1 keeps its digits, which a difference of ones would lose.
        turned = np.stack([-2 * np.sin(angle / 2) ** 2, np.sin(angle)], axis=1)
        bent = turned @ np.stack([self.straight, self.quarter_turned(self.straight[None])[0]])
        return np.asarray(bent + self.rigid(origin, angle))

    def rigid(self, place: FloatArray, angle: FloatArray) -> FloatArray:
        """Coordinates (m, n) added by a place or velocity (m, 2) and an angle or spin (m,)."""
        fields = np.stack([self.fields.along, self.fields.across, self.rotation])
        return np.asarray(np.column_stack([place, angle]) @ fields)

    def quarter_turned(self, values: FloatArray) -> FloatArray:
        """Vectors of (m, n) rotated by 90 deg; zero for other coordinates."""
        x, y = self.vectors
        turned = np.zeros_like(values)
        turned[:, x], turned[:, y] = -values[:, y], values[:, x]
        return turned

    def end_place(self, end: End, position: FloatArray) -> FloatArray:
        """Position of an end from the coordinates of all links (size,), shape (2,)."""
        first = self.firsts[0 if end == "start" else -1]
        place = position[first : first + 2]
        if end == "start":
            return np.asarray(place)
        at_node, beyond = self.positions[-1], self.length - self.positions[-1]
        if beyond:
            place = place + beyond * direction(position[first + self.kind.clamped])
        return np.asarray(place + np.array([at_node, 0.0]))


@dataclass(frozen=True)
class BeamPart(LinkPart):
    """A link of beam elements.

    Parameters
    ----------
    name, length, kind, positions, nodes, bodies, coordinates, node_map
        See :class:`LinkPart`.
    section : BeamSection
    elements : list of ItemNumber
    point_masses : ndarray, shape (e + 1,)
        At the nodes in kg.
    """

    section: BeamSection
    elements: list[ItemNumber]
    point_masses: FloatArray


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


@dataclass(frozen=True)
class AttachedPart:
    """A body on a link of beams.

    Parameters
    ----------
    link : int
    node : int
        Node of the link, at which it is fixed.
    place, angle : int
        First coordinate of that node, and its angle, among those of all links.
    body : SystemBody
    """

    link: int
    node: int
    place: int
    angle: int
    body: SystemBody


def add_attached_bodies(
    items: SystemItems, mechanism: Mechanism, parts: Sequence[LinkPart], has_mass: bool
) -> list[AttachedPart]:
    """Add the bodies on links of beams, and massless ones that give a cable's end an angle.

    Parameters
    ----------
    items : SystemItems
    mechanism : Mechanism
    parts : sequence of LinkPart
        All links.
    has_mass : bool
        Whether the system moves; at standstill a body is where forces act.

    Returns
    -------
    list of AttachedPart
    """
    attached, free = list[AttachedPart](), parts[-1].coordinates.stop
    for link, part in enumerate(parts):
        if not isinstance(part, BeamPart):
            continue
        link_mass = mechanism.link_mass(part.name)
        turned = [] if part.kind.has_angles else _turned_bodies(mechanism, link_mass, part.name)
        bodies = [*link_mass.bodies, *turned]
        items.begin(f"{part.name}: attached bodies")
        nodes = body_nodes(part.positions, bodies).tolist()
        for count, (body, node) in enumerate(zip(bodies, nodes, strict=True)):
            name, number = f"{part.name}_attached_{count}", part.nodes[node]
            first = place = int(part.firsts[node])
            if not part.kind.has_angles:
                where = [float(part.positions[node]), 0.0, 0.0]
                number = items.add("NodeRigidBody2D", f"{name}_node", referenceCoordinates=where)
                first, free = free, free + 3
            # The node of an eccentric link is off the axis from which the offset counts.
            x, y = body.offset[0], body.offset[1] - part.axis_below
            mass, inertia = (body.mass, body.inertia) if has_mass else (0.0, 0.0)
            made = items.add_body(name, number, first, mass, (x, y), inertia + mass * (x**2 + y**2))
            attached.append(AttachedPart(link, node, place, place + part.kind.clamped, made))
            if not part.kind.has_angles:
                _fix(items, part, attached[-1], name)
    return attached


def _fix(items: SystemItems, part: BeamPart, attached: AttachedPart, name: str) -> None:
    """Pin a body to a cable's node and keep it from turning against the slope there."""
    places = [
        items.add("MarkerNodePosition", f"{name}_place", nodeNumber=part.nodes[attached.node]),
        items.mark_place(f"{name}_on_body", attached.body.number),
    ]
    items.add("RevoluteJoint2D", f"{name}_pin", markerNumbers=places)
    element = max(attached.node - 1, 0)
    x = float(part.positions[attached.node] - part.positions[element])
    axis = items.mark_place(f"{name}_axis", part.elements[element], x)
    items.keep_angle(f"{name}_rotation", [axis, places[1]])


def add_links(
    items: SystemItems, mechanism: Mechanism, kind: BeamKind, elements: int
) -> list[LinkPart]:
    """Add nodes, beams and bodies of all links, each along the global x axis.

    Parameters
    ----------
    items : SystemItems
    mechanism : Mechanism
    kind : BeamKind
        Kind of the elastic links.
    elements : int
        Elements a link.

    Returns
    -------
    list of LinkPart
        In the topology's order.
    """
    parts: list[LinkPart] = []
    start = 0
    for link in mechanism.linkage.topology.links:
        parts.append(
            _add_rigid(items, mechanism, link.name, start)
            if link.rigid
            else _add_beam(items, mechanism, kind, link.name, elements, start)
        )
        start = parts[-1].coordinates.stop
    return parts


def _add_beam(
    items: SystemItems, mechanism: Mechanism, kind: BeamKind, name: str, elements: int, start: int
) -> LinkPart:
    mass = mechanism.link_mass(name)
    section = mechanism.sections[name].shearing_over(mass.length)
    places = [*_required_nodes(mechanism, mass, name, kind), *mechanism.acting_at(name)]
    positions = node_positions(mass.length, elements, places)
    items.begin(f"{name}: nodes, in the undeformed link along the x axis")
    nodes = [
        items.add(
            kind.node,
            f"{name}_node_{i}",
            referenceCoordinates=[float(x), section.neutral_axis, *kind.straight],
        )
        for i, x in enumerate(positions)
    ]
    items.begin(f"{name}: beam elements")
    beams = [
        kind.add_element(items, f"{name}_element_{i}", nodes[i : i + 2], float(h), section)
        for i, h in enumerate(np.diff(positions))
    ]
    bodies: list[ItemNumber] = []
    points = _point_masses(mass, positions)
    if kind.has_angles:
        bodies = add_node_bodies(items, name, nodes, positions, section, points, start)
    return BeamPart(
        name,
        mass.length,
        kind,
        positions,
        nodes,
        bodies,
        slice(start, start + kind.per_node * len(nodes)),
        _node_map(kind, section, positions, _places_with_angles(mechanism, mass, name)),
        section,
        beams,
        points,
    )


def _add_rigid(items: SystemItems, mechanism: Mechanism, name: str, start: int) -> LinkPart:
    mass, kind = mechanism.link_mass(name), BEAM_KINDS["geometrically-exact"]
    inertia = RigidBody.of_link(mass)
    items.begin(f"{name}: a rigid body, its node at the start of the link")
    node = items.add(kind.node, f"{name}_node", referenceCoordinates=[0.0, 0.0, *kind.straight])
    total, (along, across) = inertia.mass, inertia.first_moment
    centre = (along / total, across / total) if total else (0.0, 0.0)
    body = items.add_body(f"{name}_body", node, start, total, centre, inertia.second_moment)
    columns, straight = slice(start, start + kind.per_node), Arms(NONE)
    nodes, bodies = [node], [body.number]
    return LinkPart(name, mass.length, kind, np.zeros(1), nodes, bodies, columns, straight)


def _point_masses(mass: LinkMass, positions: FloatArray) -> FloatArray:
    """Point mass at each node in kg, (e + 1,)."""
    masses = np.zeros(len(positions))
    for x, value in zip(mass.point_positions, mass.point_masses, strict=True):
        masses[np.argmin(np.abs(positions - x))] += value
    return masses


def _node_map(
    kind: BeamKind, section: BeamSection, positions: FloatArray, places: list[float]
) -> NodeMap:
    """Arms of eccentric links, and stretch and angle of cables at places along the link in m."""
    if kind.has_angles:
        nodes = np.arange(len(positions)) if section.is_eccentric else NONE
        return Arms(kind.per_node * nodes, section.neutral_axis)
    nodes = np.unique([np.abs(positions - place).argmin() for place in places]).astype(np.intp)
    return PolarSlopes(kind.per_node * nodes + 2)


def _required_nodes(mechanism: Mechanism, mass: LinkMass, link: str, kind: BeamKind) -> list[float]:
    """Places along a link in m that need a node.

    Point masses and bodies, and on exact beams points at which loads or springs act: a cable
    takes forces anywhere, but a torque and what turns with the link at nodes alone.
    """
    places = [*mass.point_positions, *(body.position for body in mass.bodies)]
    points = [load.point.x for load in _turned_loads(mechanism, link)]
    if kind.has_angles:
        points += [load.point.x for load in mechanism.loads if load.point.link == link]
        for spring in mechanism.springs:
            points += [end.x for end in (spring.first, spring.second) if end.link == link]
    least = LEAST_DISTANCE * mass.length
    for point in points:
        if all(abs(point - place) >= least for place in (0.0, mass.length, *places)):
            places.append(point)
    return places


def _places_with_angles(mechanism: Mechanism, mass: LinkMass, link: str) -> list[float]:
    """Places along a link of cables in m at which the angle is a coordinate."""
    topology = mechanism.linkage.topology
    ends = [end for weld in topology.welds for end in (weld.leader, weld.follower)]
    ends += [clamp.link_end for clamp in topology.clamps[1:]]
    places = [0.0 if end.end == "start" else mass.length for end in ends if end.link == link]
    places += [load.point.x for load in _turned_loads(mechanism, link)]
    bodies = [*mass.bodies, *_turned_bodies(mechanism, mass, link)]
    return [*places, *(body.position for body in bodies)]


def _turned_bodies(mechanism: Mechanism, mass: LinkMass, link: str) -> list[LinkBody]:
    """Massless bodies at ends of a link of cables on which torsional springs act."""
    ends: set[LinkEnd] = set()
    for spring in mechanism.joint_springs:
        if spring.torsional_stiffness or spring.torsional_damping:
            pair = mechanism.linkage.topology.pinned_ends[spring.joint]
            ends |= {end for end in pair if end is not None and end.link == link}
    places = sorted(0.0 if end.end == "start" else mass.length for end in ends)
    return [LinkBody(place, 0.0) for place in places]


def _turned_loads(mechanism: Mechanism, link: str) -> Iterator[Load]:
    """Follower forces on a link, and loads with a torque."""
    for load in mechanism.loads:
        if load.point.link == link and (load.axes == "link" or any(load.torque)):
            yield load
