"""Links of a mechanism, and the bodies on them, as nodes, beams and bodies of an Exudyn system.

Rigid bodies that are fixed to links of beams: hubs, counterweights, pistons.

On an exact beam such a body shares the node, which turns. A cable's node has a slope and no angle:
the body has a node of its own, pinned to the cable's and kept from turning against its slope.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import RigidBody, body_nodes
from flexmech.linkages import LinkBody, LinkEnd, LinkMass, Load
from flexmech.linkages.link_mass import LEAST_DISTANCE
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.beams import BeamKind
from flexmech.multibody.items import ItemNumber, SystemItems
from flexmech.multibody.link_parts import RIGID_SIZE, BeamPart, LinkPart, RigidPart
from flexmech.multibody.node_bodies import NodeBodies, point_masses_at
from flexmech.multibody.node_maps import Arms, PolarSlopes


@dataclass(frozen=True)
class AttachedPart:
    """A body on a link of beams.

    Parameters
    ----------
    link : int
    body : LinkBody
    node : int
        Of the link, at which it is fixed.
    place, angle : int
        First coordinate of that node, and its angle, among those of all links.
    number : ItemNumber
        Of the body in the system.
    own_node : ItemNumber or None
        Its own node, if it has one.
    centre : tuple of float
        Its centre of mass in the body's axes in m.
    """

    link: int
    body: LinkBody
    node: int
    place: int
    angle: int
    number: ItemNumber
    own_node: ItemNumber | None
    centre: tuple[float, float]

    @property
    def inertia(self) -> RigidBody:
        """Inertia of the body about the link's axis."""
        return RigidBody.fixed(self.body)


def add_attached_bodies(
    items: SystemItems, link: int, part: BeamPart, bodies: Sequence[LinkBody], has_mass: bool
) -> list[AttachedPart]:
    """Add the bodies of a link to a system.

    Parameters
    ----------
    items : SystemItems
    link : int
    part : BeamPart
    bodies : sequence of LinkBody
    has_mass : bool
        Whether the system moves; at standstill a body is where forces act.

    Returns
    -------
    list of AttachedPart
    """
    if bodies:
        items.begin(f"{part.name}: attached bodies")
    attached = []
    for count, (body, node) in enumerate(
        zip(bodies, body_nodes(part.positions, bodies).tolist(), strict=True)
    ):
        name, number = f"{part.name}_attached_{count}", part.nodes[node]
        own_node = None
        # The node of an eccentric link is off the axis from which the offset counts.
        below = 0.0 if part.arms is None else part.arms.length
        if part.bodies is None:
            place = [float(part.positions[node]), 0.0, 0.0]
            own_node = items.add("NodeRigidBody2D", f"{name}_node", referenceCoordinates=place)
            number = own_node
        x, y = body.offset[0], body.offset[1] - below
        total, inertia = (body.mass, body.inertia) if has_mass else (0.0, 0.0)
        made = items.add(
            "ObjectRigidBody2D",
            name,
            nodeNumber=number,
            mass=total,
            inertia=inertia + total * (x**2 + y**2),
            centerOfMass=[x, y],
        )
        first = part.coordinates.start + part.kind.per_node * node
        angle = first + part.kind.clamped
        attached.append(AttachedPart(link, body, node, first, angle, made, own_node, (x, y)))
        if own_node is not None:
            _fix(items, part, attached[-1], name)
    return attached


def _fix(items: SystemItems, part: BeamPart, attached: AttachedPart, name: str) -> None:
    """Pin a body to a cable's node and keep it from turning against the slope there."""
    node = part.nodes[attached.node]
    places = [
        items.add("MarkerNodePosition", f"{name}_place", nodeNumber=node),
        items.add("MarkerBodyRigid", f"{name}_on_body", bodyNumber=attached.number),
    ]
    items.add("RevoluteJoint2D", f"{name}_pin", markerNumbers=places)
    element = max(attached.node - 1, 0)
    x = float(part.positions[attached.node] - part.positions[element])
    axis = items.add(
        "MarkerBodyRigid",
        f"{name}_axis",
        bodyNumber=part.elements[element],
        localPosition=[x, 0.0, 0.0],
    )
    items.add(
        "GenericJoint",
        f"{name}_rotation",
        markerNumbers=[axis, places[1]],
        constrainedAxes=[0, 0, 0, 0, 0, 1],
    )


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
        part = (
            _add_rigid(items, mechanism, link.name, start)
            if link.rigid
            else _add_beam(items, mechanism, kind, link.name, elements, start)
        )
        parts.append(part)
        start = part.coordinates.stop
    return parts


def _add_beam(
    items: SystemItems, mechanism: Mechanism, kind: BeamKind, name: str, elements: int, start: int
) -> BeamPart:
    mass = mechanism.link_mass(name)
    section = mechanism.sections[name].shearing_over(mass.length)
    places = [*required_nodes(mechanism, mass, name, kind.turns_arms), *mechanism.acting_at(name)]
    positions = node_positions(mass.length, elements, places)
    items.begin(f"{name}: nodes, in the undeformed link along the x axis")
    nodes = [
        kind.add_node(items, f"{name}_node_{i}", float(x), section.neutral_axis)
        for i, x in enumerate(positions)
    ]
    items.begin(f"{name}: beam elements")
    beams = [
        kind.add_element(items, f"{name}_element_{i}", nodes[i : i + 2], float(h), section)
        for i, h in enumerate(np.diff(positions))
    ]
    stop = start + kind.per_node * len(nodes)
    bodies = None
    if not kind.carries_mass:
        points = point_masses_at(mechanism, name, positions)
        bodies = NodeBodies.added(items, name, nodes, positions, section, points)
    return BeamPart(
        name=name,
        section=section,
        kind=kind,
        positions=positions,
        nodes=nodes,
        elements=beams,
        coordinates=slice(start, stop),
        arms=Arms(section.neutral_axis, len(nodes)) if section.is_eccentric else None,
        bodies=bodies,
        polar=_polar_slopes(kind, positions, places_with_angles(mechanism, mass, name)),
    )


def _add_rigid(items: SystemItems, mechanism: Mechanism, name: str, start: int) -> RigidPart:
    inertia = RigidBody.of_link(mechanism.link_mass(name))
    items.begin(f"{name}: a rigid body, its node at the start of the link")
    node = items.add("NodeRigidBody2D", f"{name}_node", referenceCoordinates=[0.0, 0.0, 0.0])
    total, (along, across) = inertia.mass, inertia.first_moment
    body = items.add(
        "ObjectRigidBody2D",
        f"{name}_body",
        nodeNumber=node,
        mass=total,
        inertia=inertia.second_moment,
        centerOfMass=[along / total, across / total] if total else [0.0, 0.0],
    )
    own = slice(start, start + RIGID_SIZE)
    return RigidPart(name, mechanism.link_mass(name).length, [node], body, inertia, own)


def _polar_slopes(kind: BeamKind, positions: FloatArray, places: list[float]) -> PolarSlopes | None:
    """Nodes of a link of cables with stretch and angle as coordinates."""
    if kind.turns_arms or not places:
        return None
    nodes = np.unique(np.abs(positions - np.array(places)[:, None]).argmin(axis=1))
    return PolarSlopes(kind.per_node * nodes + 2)


def required_nodes(mechanism: Mechanism, mass: LinkMass, link: str, exact: bool) -> list[float]:
    """Places along a link that need a node.

    Point masses and bodies, and on exact beams points at which loads or springs act: a cable
    takes forces anywhere, but a torque and what turns with the link at nodes alone.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    exact : bool
        Whether it is of exact beams.

    Returns
    -------
    list of float
        In m.
    """
    places = [*mass.point_positions, *(body.position for body in mass.bodies)]
    points = [load.point.x for load in _turned_loads(mechanism, link)]
    if exact:
        points += [load.point.x for load in mechanism.loads if load.point.link == link]
        for spring in mechanism.springs:
            points += [end.x for end in (spring.first, spring.second) if end.link == link]
    least = LEAST_DISTANCE * mass.length
    for point in points:
        if all(abs(point - place) >= least for place in (0.0, mass.length, *places)):
            places.append(point)
    return places


def places_with_angles(mechanism: Mechanism, mass: LinkMass, link: str) -> list[float]:
    """Places along a link of cables in m at which the angle is a coordinate.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    """
    topology = mechanism.linkage.topology
    ends = [end for weld in topology.welds for end in (weld.leader, weld.follower)]
    ends += [clamp.link_end for clamp in topology.clamps[1:]]
    places = [0.0 if end.end == "start" else mass.length for end in ends if end.link == link]
    places += [load.point.x for load in _turned_loads(mechanism, link)]
    bodies = [*mass.bodies, *turned_bodies(mechanism, mass, link)]
    return [*places, *(body.position for body in bodies)]


def turned_bodies(mechanism: Mechanism, mass: LinkMass, link: str) -> list[LinkBody]:
    """Massless bodies at ends of a link of cables on which torsional springs act.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    """
    ends: set[LinkEnd] = set()
    for own in mechanism.joint_springs:
        if own.torsional_stiffness or own.torsional_damping:
            pair = mechanism.linkage.topology.pinned_ends[own.joint]
            ends |= {end for end in pair if end is not None and end.link == link}
    places = sorted(0.0 if end.end == "start" else mass.length for end in ends)
    return [LinkBody(place, 0.0) for place in places]


def _turned_loads(mechanism: Mechanism, link: str) -> Iterator[Load]:
    """Follower forces on a link, and loads with a torque."""
    for load in mechanism.loads:
        if load.point.link == link and (load.axes == "link" or any(load.torque)):
            yield load
