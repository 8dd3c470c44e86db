"""Joints of links in an Exudyn system: pins, welds, sliders, and what closes them in a run.

Where it is exact, a joint is a condition whose Jacobian is constant: that on the places of two
nodes, on the difference of two angles, or on the distance of a node from a line of the ground.
Then the constraint's force adds nothing to the tangent stiffness. A weld between cables holds
directions of slopes, a guide turns with its link, and a rigid link's end is off its node: what
the forces of these add is in the maps of :mod:`flexmech.multibody.links` and in the geometric
stiffness of rigid links, which all engines share.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, Pin, RigidMotion, Slider, Topology, Weld, turned
from flexmech.linkages.motion import normal
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import FrameBody, LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.running.user_functions import (
    AngleGap,
    ClosedJoints,
    JoinedEnd,
    LineGap,
    PlaceGap,
    Shaft,
)

JointGap: TypeAlias = PlaceGap | AngleGap | LineGap
"""Conditions that a joint closes."""


@dataclass(frozen=True)
class TieJoint:
    """A pin or weld between two link ends.

    Parameters
    ----------
    tie : Pin or Weld
    position : ItemNumber
        Constraint on the places; its multipliers are minus the force on the follower.
    rotation : ItemNumber, optional
        Rotation of a weld that is a condition on angles of two nodes: the constraint on the second
        less the first.
    """

    tie: Pin | Weld
    position: ItemNumber
    rotation: ItemNumber | None = None


@dataclass(frozen=True)
class SliderJoint:
    """A link end on a line.

    Parameters
    ----------
    slider : Slider
    constraint : ItemNumber
        Its first multiplier is the force on the held end along the line's normal, which is a
        quarter turn ahead of its direction.
    """

    slider: Slider
    constraint: ItemNumber


def add_pivots(
    assembly: LinkAssembly, motion: RigidMotion, *, sprung_alone: bool = True
) -> dict[str, ItemNumber]:
    """Pin links to the ground.

    Parameters
    ----------
    assembly : LinkAssembly
    motion : RigidMotion
        In any one position, of shape ().
    sprung_alone : bool
        Whether springs alone hold sprung pivots; they are rigid otherwise.

    Returns
    -------
    dict of str to ItemNumber
        Pin of each pivot by its name.
    """
    pivots = {}
    for pivot in assembly.topology.pivots:
        if not (pivot.sprung and sprung_alone):
            end, name = pivot.link_end, f"pivot_{pivot.joint}"
            assembly.items.begin(f"pivot {pivot.joint}")
            place = motion.position(*assembly.topology.end_place(end))
            before = assembly.add_ground(name, place.tolist())
            markers = [before, assembly.add_end_marker(end, f"{name}_on_{end.link}")]
            pin = assembly.items.add("RevoluteJoint2D", name, markerNumbers=markers)
            pivots[pivot.joint] = pin
    return pivots


def hold_axis(
    assembly: LinkAssembly, name: str, body: ItemNumber, end: LinkEnd, angle: float
) -> None:
    """Keep the axis at a link end at an angle in rad to a body.

    Parameters
    ----------
    assembly : LinkAssembly
    name : str
        Name of what holds it.
    body : ItemNumber
    end : LinkEnd
    angle : float
    """
    frames = [
        assembly.add_body_frame(body, f"{name}_direction", 0.0, 0.0, angle),
        assembly.add_frame_marker(end, f"{name}_axis"),
    ]
    assembly.items.keep_angle(f"{name}_rotation", frames)


def add_ties(
    assembly: LinkAssembly, angle: FloatArray, *, sprung_alone: bool = True
) -> list[TieJoint]:
    """Join the links by pins and welds.

    Parameters
    ----------
    assembly : LinkAssembly
    angle : ndarray, shape (n_links,)
        Angle of the links in any one position, in rad.
    sprung_alone : bool
        Whether springs alone hold sprung pins; they are rigid otherwise.

    Returns
    -------
    list of TieJoint
        In the order of the topology's ties, without those that springs alone hold.
    """
    ties = assembly.topology.ties
    return [
        _tie(assembly, tie, angle)
        for tie in ties
        if isinstance(tie, Weld) or not (tie.sprung and sprung_alone)
    ]


def _tie(assembly: LinkAssembly, tie: Pin | Weld, angle: FloatArray) -> TieJoint:
    kind = "pin" if isinstance(tie, Pin) else "weld"
    name = f"{kind}_{tie.joint}"
    assembly.items.begin(f"{kind} {tie.joint}")
    leader = leading_end(tie.leader, assembly.topology.rigid_ties)
    markers = [
        assembly.add_end_marker(place, f"{name}_on_{place.link}")
        for place in (leader, tie.follower)
    ]
    position = assembly.items.add("RevoluteJoint2D", name, markerNumbers=markers)
    if isinstance(tie, Pin):
        return TieJoint(tie, position)
    links = [assembly.topology.index(end.link) for end in (tie.leader, tie.follower)]
    between = float(angle[links[1]] - angle[links[0]])
    ends, rotation = (tie.leader, tie.follower), f"{name}_rotation"
    if all(assembly.part_of(end).kind.has_angles for end in ends):
        angles = [assembly.add_angle_marker(end, f"{name}_angle_of_{end.link}") for end in ends]
        constraint = assembly.items.add(
            "CoordinateConstraint", rotation, markerNumbers=angles, offset=between
        )
        return TieJoint(tie, position, constraint)
    frames = [
        assembly.add_frame_marker(end, f"{name}_axis_of_{end.link}", turn)
        for end, turn in zip(ends, (0.0, -between), strict=True)
    ]
    assembly.items.keep_angle(rotation, frames)
    return TieJoint(tie, position)


def add_sliders(assembly: LinkAssembly) -> list[SliderJoint]:
    """Add the sliders: link ends on lines of the ground or of rigid links.

    Parameters
    ----------
    assembly : LinkAssembly

    Returns
    -------
    list of SliderJoint
        In the topology's order.
    """
    joints = []
    for slider in assembly.topology.sliders:
        name, items = f"slider_{slider.joint}", assembly.items
        items.begin(f"slider {slider.joint}")
        across = normal(np.array(slider.direction))
        x, y = (slider.offset * across).tolist()
        end = assembly.add_frame_marker(slider.link_end, f"{name}_on_{slider.link_end.link}")
        if slider.guide:
            [guide] = assembly.parts[assembly.topology.index(slider.guide)].bodies
            line = assembly.add_body_frame(guide, f"{name}_on_{slider.guide}", x, y)
        else:
            line = assembly.add_ground(name, (x, y))
        # The normal of this joint is that of the second marker: the line's.
        constraint = items.add(
            "PrismaticJoint2D",
            name,
            markerNumbers=[end, line],
            normalMarker1=[*across.tolist(), 0.0],
            constrainRotation=False,
        )
        joints.append(SliderJoint(slider, constraint))
    return joints


def place_on_hub(assembly: LinkAssembly, start: RigidMotion, end: LinkEnd) -> tuple[float, float]:
    """Position of a clamped end on the hub in m; the hub rotates with the first clamped link.

    Parameters
    ----------
    assembly : LinkAssembly
    start : RigidMotion
        At time zero, of shape ().
    end : LinkEnd
    """
    place = start.position(*assembly.topology.end_place(end))
    return _pair(turned(place, -start.angle[assembly.base]))


def joint_gaps(
    assembly: LinkAssembly, start: RigidMotion, frame: FrameBody | None = None
) -> list[JointGap]:
    """Gaps of all joints that are not sprung.

    Parameters
    ----------
    assembly : LinkAssembly
    start : RigidMotion
        At time zero, of shape ().
    frame : FrameBody, optional
        On springs, which carries the linkage.

    Returns
    -------
    list of PlaceGap, AngleGap or LineGap
    """
    topology = assembly.topology

    def joined(end: LinkEnd) -> JoinedEnd:
        return _joined_end(assembly, end)

    def angle(end: LinkEnd) -> float:
        return float(start.angle[topology.index(end.link)])

    def on_ground(end: LinkEnd) -> PlaceGap:
        place = _pair(start.position(*topology.end_place(end)))
        if frame is None:
            return PlaceGap(joined(end), None, place, False)
        return PlaceGap(joined(end), frame.joined(place), (0.0, 0.0), False)

    gaps: list[JointGap] = []
    for clamp in topology.clamps:
        end, place = clamp.link_end, place_on_hub(assembly, start, clamp.link_end)
        axis = None if frame is None else frame.joined((0.0, 0.0))
        between = angle(end) - float(start.angle[assembly.base])
        gaps.append(AngleGap(joined(end), axis, between, True))
        gaps.append(PlaceGap(joined(end), axis, place, True))
    gaps += [on_ground(pivot.link_end) for pivot in topology.pivots if not pivot.sprung]
    for tie in topology.rigid_ties:
        leader = leading_end(tie.leader, topology.rigid_ties)
        gaps.append(PlaceGap(joined(tie.follower), joined(leader), (0.0, 0.0), False))
    for weld in topology.welds:
        between = angle(weld.follower) - angle(weld.leader)
        gaps.append(AngleGap(joined(weld.follower), joined(weld.leader), between))
    for body, node in _attached_nodes(assembly):
        gaps += [PlaceGap(body, node, (0.0, 0.0), False), AngleGap(body, node, 0.0)]
    for slider in topology.sliders:
        place, guide = _pair(slider.offset * normal(np.array(slider.direction))), None
        if slider.guide:
            guide = replace(joined(LinkEnd(slider.guide, "start")), lever=place)
        elif frame is not None:
            guide = frame.joined(place)
        gaps.append(LineGap(joined(slider.link_end), guide, place, slider.direction))
    return gaps


def closed_joints(
    assembly: LinkAssembly, shaft: Shaft, gaps: list[JointGap], frame: FrameBody | None
) -> ClosedJoints:
    """Joints that are closed after every step: all at once, or in turn where that does.

    A pin between nodes, or of a node on the ground, is linear in their coordinates: it stays
    closed unless another joint of its nodes has to be closed with it.

    Parameters
    ----------
    assembly : LinkAssembly
    shaft : Shaft
    gaps : list of PlaceGap, AngleGap or LineGap
        Gaps of all joints.
    frame : FrameBody or None
        On springs, which carries the linkage.

    Returns
    -------
    ClosedJoints
    """
    turns = sum(isinstance(gap, AngleGap) for gap in gaps)
    rigid = any(link.rigid for link in assembly.topology.links)
    if rigid or frame is not None or turns > 1 or assembly.topology.sliders:
        axis = None if frame is None else frame.joined((0.0, 0.0))
        return ClosedJoints(shaft, gaps, axis)
    return ClosedJoints(shaft, [gap for gap in gaps if not _stays_closed(gap)], in_turn=True)


def _stays_closed(gap: JointGap) -> bool:
    if not isinstance(gap, PlaceGap) or gap.on_hub:
        return False
    return not any(gap.follower.lever) and (gap.leader is None or not any(gap.leader.lever))


def _attached_nodes(assembly: LinkAssembly) -> Iterator[tuple[JoinedEnd, JoinedEnd]]:
    """Nodes of attached bodies that have one of their own, and the nodes that they are fixed to."""
    for body in assembly.attached if not assembly.kind.has_angles else ():
        node = (float(assembly.parts[body.link].positions[body.node]), 0.0)
        on_body = JoinedEnd(body.body.first, node, (0.0, 0.0), has_slope=False)
        yield on_body, JoinedEnd(body.place, node, (0.0, 0.0), has_slope=True)


def _joined_end(assembly: LinkAssembly, end: LinkEnd) -> JoinedEnd:
    part, first = assembly.part_of(end), assembly.first_coordinate(end)
    at_node = 0.0 if end.end == "start" else float(part.positions[-1])
    beyond = 0.0 if end.end == "start" else part.length - at_node
    arm = part.axis_below
    return JoinedEnd(first, (at_node, arm), (beyond, -arm), not part.kind.has_angles)


def _pair(place: FloatArray) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def dependent_joints(topology: Topology, end: LinkEnd) -> list[str]:
    """Joints whose leader is, through other joints, a given follower.

    Their forces on the end of the leader act on the follower's link.

    Parameters
    ----------
    topology : Topology
    end : LinkEnd
        Follower of a rigid pin or weld.

    Returns
    -------
    list of str
    """
    leaders = {tie.follower: tie.leader for tie in topology.rigid_ties}
    joints = []
    for tie in topology.ties:
        place: LinkEnd | None = tie.leader
        while place is not None and place != end:
            place = leaders.get(place)
        if place is not None:
            joints.append(tie.joint)
    return joints
