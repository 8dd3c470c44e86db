"""Links of a mechanism in an Exudyn system: their nodes, beams and bodies, and their coordinates.

Coordinates of a beam are those of points on the pins' axis, less the reference ones; see
:mod:`flexmech.multibody.node_maps` for what leads from them to Exudyn's. Those of a rigid link are
the place of its start and its angle, as in Exudyn: those of the one node of a chain without beams.

Rigid bodies that are fixed to links of beams are hubs, counterweights, pistons. On an exact beam
such a body shares the node, which turns. A cable's node has a slope and no angle: the body has a
node of its own, pinned to the cable's and kept from turning against its slope.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import RigidBody, RigidFields, body_nodes
from flexmech.linear_system.links.link_model import NONE
from flexmech.linkages import LinkBody, LinkEnd, LinkMass, Load
from flexmech.linkages.link_mass import LEAST_DISTANCE
from flexmech.linkages.motion import direction
from flexmech.linkages.topology import End
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.beams import BEAM_KINDS, BeamKind, add_node_bodies
from flexmech.multibody.items import ItemNumber, SystemBody, SystemItems
from flexmech.multibody.node_maps import Arms, NodeMap, PolarSlopes
from flexmech.sections import BeamSection


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
        Of the nodes along the link in m; a rigid link has one at its start.
    nodes : list of ItemNumber
    bodies : list of ItemNumber
        At the nodes, with all mass; of cables, whose elements carry it, there are none.
    coordinates : slice
        Where the link's coordinates are in those of all links.
    node_map : NodeMap
        Map from them to those of the nodes, on the neutral axis. Of a cable it is of nodes at
        which something holds the direction of the slope.
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
            Of its start in m.
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
        """What a place or velocity (m, 2) and an angle or spin (m,) add to coordinates, (m, n)."""
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
        Of the link, at which it is fixed.
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
        Of the elastic links.
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
