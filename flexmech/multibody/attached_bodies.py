"""Rigid bodies that are fixed to links of beams: hubs, counterweights, pistons.

On an exact beam such a body shares the node, which turns. A cable's node has a slope and no angle:
the body has a node of its own, pinned to the cable's and kept from turning against its slope.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexmech.linear_system import RigidBody, body_nodes
from flexmech.linkages import LinkBody
from flexmech.multibody.items import ItemNumber, SystemItems
from flexmech.multibody.link_parts import BeamPart


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
    def moments(self) -> tuple[float, float, float, float]:
        """Mass, its first moments along and across and its polar second moment about the axis."""
        own = RigidBody.fixed(self.body)
        return own.mass, *own.first_moment, own.second_moment


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
    axis = part.kind.add_axis_marker(items, f"{name}_axis", node, part.elements[element], x)
    items.add(
        "GenericJoint",
        f"{name}_rotation",
        markerNumbers=[axis, places[1]],
        constrainedAxes=[0, 0, 0, 0, 0, 1],
    )
