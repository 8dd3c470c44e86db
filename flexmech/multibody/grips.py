"""What connectors take hold of: points of links, angles at their ends, and who leads at a joint."""

from __future__ import annotations

import numpy as np

from flexmech.linkages import LinkEnd, LinkPoint
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.link_parts import BeamPart, RigidPart


def add_point_marker(assembly: LinkAssembly, point: LinkPoint, name: str) -> ItemNumber:
    """Add a marker of a point on a link's axis, which turns with the link there.

    Parameters
    ----------
    assembly : LinkAssembly
    point : LinkPoint
        On a link.
    name : str

    Returns
    -------
    ItemNumber
    """
    part = assembly.parts[assembly.topology.index(point.link)]
    if isinstance(part, RigidPart):
        return assembly.add_body_frame(part.body, name, point.x)
    if not assembly.kind.turns_arms:
        element = int(np.searchsorted(part.positions, point.x, side="right")) - 1
        element = min(max(element, 0), len(part.elements) - 1)
        x = float(point.x - part.positions[element])
        return assembly.items.add(
            "MarkerBodyRigid", name, bodyNumber=part.elements[element], localPosition=[x, 0.0, 0.0]
        )
    number = int(np.argmin(np.abs(part.positions - point.x)))
    if part.arms is not None:
        return assembly.add_axis_point(part, number, name)
    return assembly.items.add("MarkerNodeRigid", name, nodeNumber=part.nodes[number])


def add_angle_marker(assembly: LinkAssembly, end: LinkEnd, name: str) -> ItemNumber:
    """Add a marker of the angle at a link end, as a coordinate.

    Parameters
    ----------
    assembly : LinkAssembly
    end : LinkEnd
        At a cable, one at which a body has a node of its own.
    name : str

    Returns
    -------
    ItemNumber
    """
    turning, node = assembly.turning_coordinate(end), assembly.end_node(end)
    if turning is None:
        part = assembly.part_of(end)
        assert isinstance(part, BeamPart)
        number = 0 if end.end == "start" else len(part.nodes) - 1
        link = assembly.topology.index(end.link)
        node = next(
            body.own_node
            for body in assembly.attached
            if body.link == link and body.node == number and body.own_node is not None
        )
        turning = 2
    return assembly.items.add("MarkerNodeCoordinate", name, nodeNumber=node, coordinate=turning)


def angle_of_end(assembly: LinkAssembly, end: LinkEnd) -> int:
    """Number of the angle at a link end among the coordinates of all links."""
    turning = assembly.turning_coordinate(end)
    first = assembly.first_coordinate(end)
    return first + (assembly.kind.clamped if turning is None else turning)
