"""Joints of a running linkage: gaps of its start, and stabilization of drift."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.link_parts import RigidPart
from flexmech.multibody.running.closure import (
    AngleGap,
    ClosedJoints,
    JoinedEnd,
    LineGap,
    PlaceGap,
    ShaftGap,
)
from flexmech.multibody.running.frame_body import FrameBody
from flexmech.multibody.running.user_functions import AxisPoint, HubClamp, Joints, Shaft


def place_at_start(assembly: LinkAssembly, start: RigidMotion, end: LinkEnd) -> FloatArray:
    """Position of a link end of the rigid linkage at time zero in m, shape (2,).

    Parameters
    ----------
    assembly : LinkAssembly
    start : RigidMotion
        At time zero, of shape ().
    end : LinkEnd

    Returns
    -------
    ndarray, shape (2,)
    """
    return start.position(*assembly.topology.end_place(end))


def place_on_hub(assembly: LinkAssembly, start: RigidMotion, end: LinkEnd) -> tuple[float, float]:
    """Position of a clamped end on the hub in m; the hub rotates with the first clamped link.

    Parameters
    ----------
    assembly : LinkAssembly
    start : RigidMotion
        At time zero, of shape ().
    end : LinkEnd

    Returns
    -------
    tuple of float
    """
    turn = -float(start.angle[assembly.base])
    cosine, sine = math.cos(turn), math.sin(turn)
    x, y = map(float, place_at_start(assembly, start, end))
    return cosine * x - sine * y, sine * x + cosine * y


def greatest_gap(assembly: LinkAssembly, start: RigidMotion, position: FloatArray) -> float:
    """Greatest constraint violation of the joints of a start.

    Parameters
    ----------
    assembly : LinkAssembly
    start : RigidMotion
        At time zero, of shape ().
    position : ndarray, shape (size,)
        Coordinates of the links then.

    Returns
    -------
    float
        In m; welds that are turned count by the length of their shorter link.
    """
    topology = assembly.topology

    def place(end: LinkEnd) -> FloatArray:
        return assembly.part_of(end).end_place(end.end, position)

    fixed = [clamp.link_end for clamp in topology.clamps]
    fixed += [pivot.link_end for pivot in topology.pivots if not pivot.sprung]
    gaps = [place(end) - place_at_start(assembly, start, end) for end in fixed]
    gaps += [place(tie.leader) - place(tie.follower) for tie in topology.rigid_ties]
    closed = drifting_joints(assembly, Shaft(float(start.angle[assembly.base]), 0.0), start)
    others = 0.0
    if isinstance(closed, ClosedJoints):
        nodes = np.append(assembly.arms.to_nodes(position), [0.0, 0.0, 0.0])
        others = greatest_closing_gap(assembly, closed, nodes)
    return float(max(np.max(np.linalg.norm(gaps, axis=1)), others))


def greatest_closing_gap(
    assembly: LinkAssembly, closed: ClosedJoints, position: FloatArray
) -> float:
    """Greatest gap of joints that are closed after every step, at time zero.

    Parameters
    ----------
    assembly : LinkAssembly
    closed : ClosedJoints
    position : ndarray, shape (total_size,)
        Exudyn's coordinates.

    Returns
    -------
    float
        In m; angles count by the length of the shortest link.
    """
    length = min(link.length for link in assembly.topology.links)
    others = [0.0]
    for gap in closed.gaps:
        value = np.linalg.norm(gap.gap(position, closed.shaft.angle(0.0)))
        others.append(float(value) * (length if isinstance(gap, AngleGap) else 1.0))
    return max(others)


def drifting_joints(
    assembly: LinkAssembly, shaft: Shaft, start: RigidMotion, frame: FrameBody | None = None
) -> Joints | ClosedJoints:
    """Joints whose constraints drift, to be closed after every step.

    Parameters
    ----------
    assembly : LinkAssembly
    shaft : Shaft
    start : RigidMotion
        At time zero, of shape ().
    frame : FrameBody, optional
        On springs, which carries the linkage.

    Returns
    -------
    Joints or ClosedJoints
        The latter where putting nodes in place one by one does not do.
    """
    topology = assembly.topology
    rigid = any(isinstance(part, RigidPart) for part in assembly.parts)
    own_nodes = any(body.own_node is not None for body in assembly.attached)
    if rigid or own_nodes or topology.welds or topology.sliders or topology.clamps[1:] or frame:
        return _closed_joints(assembly, shaft, start, frame)
    eccentric = {part.name for _, part in assembly.beams if part.arms is not None}
    ties = topology.rigid_ties
    pins = [(leading_end(tie.leader, ties), tie.follower) for tie in ties]
    clamped = topology.clamps[0].link_end
    lever = place_on_hub(assembly, start, clamped)
    return Joints(
        shaft,
        HubClamp(_axis_point(assembly, clamped), lever, len(assembly.kind.vectors) == 2),
        [
            (_axis_point(assembly, end), _pair(place_at_start(assembly, start, end)))
            for end in (pivot.link_end for pivot in topology.pivots if not pivot.sprung)
            if end.link in eccentric
        ],
        [
            (_axis_point(assembly, leader), _axis_point(assembly, follower))
            for leader, follower in pins
            if eccentric & {leader.link, follower.link}
        ],
    )


def _closed_joints(
    assembly: LinkAssembly, shaft: Shaft, start: RigidMotion, frame: FrameBody | None
) -> ClosedJoints:
    topology = assembly.topology
    ties = topology.rigid_ties

    def joined(end: LinkEnd) -> JoinedEnd:
        return _joined_end(assembly, end)

    def angle(end: LinkEnd) -> float:
        return float(start.angle[topology.index(end.link)])

    def on_ground(end: LinkEnd) -> PlaceGap:
        place = _pair(place_at_start(assembly, start, end))
        leader = None if frame is None else frame.joined(place)
        return PlaceGap(joined(end), leader, place, False)

    clamped = [clamp.link_end for clamp in topology.clamps]
    places = [
        PlaceGap(joined(end), None, place_on_hub(assembly, start, end), True)
        if frame is None
        else on_ground(end)
        for end in clamped
    ]
    places += [on_ground(pivot.link_end) for pivot in topology.pivots if not pivot.sprung]
    places += [
        PlaceGap(joined(tie.follower), joined(leading_end(tie.leader, ties)), (0.0, 0.0), False)
        for tie in ties
    ]
    fixed = list(_attached_nodes(assembly))
    places += [PlaceGap(body, node, (0.0, 0.0), False) for body, node in fixed]
    shaft_angle = float(start.angle[assembly.base])
    axis = None if frame is None else frame.joined((0.0, 0.0))
    angles = [
        AngleGap(joined(end), None, angle(end) - shaft_angle)
        if axis is None
        else ShaftGap(joined(end), axis, angle(end) - shaft_angle)
        for end in clamped
    ]
    angles += [
        AngleGap(
            joined(weld.follower), joined(weld.leader), angle(weld.follower) - angle(weld.leader)
        )
        for weld in topology.welds
    ]
    angles += [AngleGap(body, node, 0.0) for body, node in fixed]
    lines = []
    for slider in topology.sliders:
        x = -slider.offset * math.sin(slider.direction)
        place, guide = (x, slider.offset * math.cos(slider.direction)), None
        if slider.guide:
            own = joined(LinkEnd(slider.guide, "start"))
            guide = JoinedEnd(own.first, own.node, place, own.has_slope)
        elif frame is not None:
            guide = frame.joined(place)
        lines.append(LineGap(joined(slider.link_end), guide, place, slider.direction))
    return ClosedJoints(shaft, list(chain(places, angles, lines)), axis)


def _attached_nodes(assembly: LinkAssembly) -> Iterator[tuple[JoinedEnd, JoinedEnd]]:
    """Nodes of attached bodies that have one of their own, and the nodes that they are fixed to."""
    first = assembly.size
    for body in assembly.attached:
        if body.own_node is not None:
            part = assembly.parts[body.link]
            assert not isinstance(part, RigidPart)
            node = (float(part.positions[body.node]), 0.0)
            own = JoinedEnd(first, node, (0.0, 0.0), has_slope=False)
            yield own, JoinedEnd(body.place, node, (0.0, 0.0), has_slope=True)
            first += 3


def _joined_end(assembly: LinkAssembly, end: LinkEnd) -> JoinedEnd:
    part, first = assembly.part_of(end), assembly.first_coordinate(end)
    node = _pair(assembly.reference_place(end))
    if isinstance(part, RigidPart):
        lever = (0.0 if end.end == "start" else part.length, 0.0)
        return JoinedEnd(first, node, lever, has_slope=False)
    arm = 0.0 if part.arms is None else float(part.arms.length)
    return JoinedEnd(first, (node[0], arm), (0.0, -arm), len(part.kind.vectors) == 2)


def _axis_point(assembly: LinkAssembly, end: LinkEnd) -> AxisPoint:
    """The point on the pins' axis at an end of a beam, by Exudyn's coordinates."""
    part = assembly.part_of(end)
    assert not isinstance(part, RigidPart)
    return AxisPoint(
        first=assembly.first_coordinate(end),
        x=float(assembly.reference_place(end)[0]),
        arm=0.0 if part.arms is None else float(part.arms.length),
    )


def _pair(place: FloatArray) -> tuple[float, float]:
    return float(place[0]), float(place[1])
