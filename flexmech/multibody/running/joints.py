"""Joints of a running linkage: gaps of its start, and stabilization of drift."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.link_parts import RigidPart
from flexmech.multibody.running.closure import (
    AngleGap,
    ClosedJoints,
    JoinedEnd,
    JointsClosedInTurn,
    LineGap,
    PlaceGap,
)
from flexmech.multibody.running.frame_body import FrameBody
from flexmech.multibody.running.user_functions import Shaft

JointGap: TypeAlias = PlaceGap | AngleGap | LineGap
"""What a joint has to close."""


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
        place = _pair(place_at_start(assembly, start, end))
        return PlaceGap(joined(end), None if frame is None else frame.joined(place), place, False)

    gaps: list[JointGap] = []
    for clamp in topology.clamps:
        end, place = clamp.link_end, place_on_hub(assembly, start, clamp.link_end)
        axis = None if frame is None else frame.joined((0.0, 0.0))
        between = angle(end) - float(start.angle[assembly.base])
        gaps.append(AngleGap(joined(end), axis, between, True))
        gaps.append(PlaceGap(joined(end), None, place, True) if frame is None else on_ground(end))
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
        x, y = slider.offset * np.array([-np.sin(slider.direction), np.cos(slider.direction)])
        place, guide = (float(x), float(y)), None
        if slider.guide:
            guide = replace(joined(LinkEnd(slider.guide, "start")), lever=place)
        elif frame is not None:
            guide = frame.joined(place)
        gaps.append(LineGap(joined(slider.link_end), guide, place, slider.direction))
    return gaps


def closed_joints(
    assembly: LinkAssembly, shaft: Shaft, gaps: Sequence[JointGap], frame: FrameBody | None
) -> JointsClosedInTurn | ClosedJoints:
    """Joints that are closed after every step.

    A pin between nodes, or of a node on the ground, is linear in their coordinates: it stays
    closed unless another joint of its nodes has to be closed with it.

    Parameters
    ----------
    assembly : LinkAssembly
    shaft : Shaft
    gaps : sequence of PlaceGap, AngleGap or LineGap
        Of all joints.
    frame : FrameBody or None
        On springs, which carries the linkage.

    Returns
    -------
    JointsClosedInTurn or ClosedJoints
        The latter where moving nodes one by one does not do.
    """
    turns = sum(isinstance(gap, AngleGap) for gap in gaps)
    rigid = any(isinstance(part, RigidPart) for part in assembly.parts)
    if rigid or frame is not None or turns > 1 or assembly.topology.sliders:
        axis = None if frame is None else frame.joined((0.0, 0.0))
        return ClosedJoints(shaft, list(gaps), axis)
    in_turn = [gap for gap in gaps if not isinstance(gap, LineGap) and not _stays_closed(gap)]
    return JointsClosedInTurn(shaft, in_turn)


def _stays_closed(gap: PlaceGap | AngleGap) -> bool:
    if isinstance(gap, AngleGap) or gap.on_hub:
        return False
    return not any(gap.follower.lever) and (gap.leader is None or not any(gap.leader.lever))


def _attached_nodes(assembly: LinkAssembly) -> Iterator[tuple[JoinedEnd, JoinedEnd]]:
    """Nodes of attached bodies that have one of their own, and the nodes that they are fixed to."""
    first = assembly.size
    for body in assembly.attached:
        if body.own_node is not None:
            part = assembly.parts[body.link]
            assert not isinstance(part, RigidPart)
            node = (float(part.positions[body.node]), 0.0)
            on_body = JoinedEnd(first, node, (0.0, 0.0), has_slope=False)
            yield on_body, JoinedEnd(body.place, node, (0.0, 0.0), has_slope=True)
            first += 3


def _joined_end(assembly: LinkAssembly, end: LinkEnd) -> JoinedEnd:
    part, first = assembly.part_of(end), assembly.first_coordinate(end)
    node = _pair(assembly.reference_place(end))
    if isinstance(part, RigidPart):
        lever = (0.0 if end.end == "start" else part.length, 0.0)
        return JoinedEnd(first, node, lever, has_slope=False)
    arm = 0.0 if part.arms is None else float(part.arms.length)
    return JoinedEnd(first, (node[0], arm), (0.0, -arm), len(part.kind.vectors) == 2)


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
    found = []
    for tie in topology.ties:
        place: LinkEnd | None = tie.leader
        while place is not None and place != end:
            place = leaders.get(place)
        if place is not None:
            found.append(tie.joint)
    return found
