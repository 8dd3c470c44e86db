"""Boundary of a link: coordinates that joints fix, and those kept in a reduction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.joint_points import joint_points
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import LinkEnd, Topology
from flexmech.linkages.topology import End

ENDS: tuple[End, ...] = ("start", "end")


@dataclass(frozen=True)
class LinkBoundary:
    """Fixed and boundary coordinates of a link at its joints.

    Parameters
    ----------
    fixed : ndarray of bool, shape (n,)
        Fixed by the ground, the shaft or the fitting of a joint.
    unit : ndarray, shape (n, b)
        Unit displacement of each boundary coordinate: of one coordinate of the link, or of all
        that rotate with a welded end.
    kept : dict of str to ndarray of int
        Which of them are displacements of ``start`` and ``end``, and ``start_rotation`` and
        ``end_rotation``.
    dependent : ndarray of int, shape (k,)
        Which of them are displacements that depend on another link, or on a line.
    """

    fixed: NDArray[np.bool_]
    unit: FloatArray
    kept: dict[str, IntArray]
    dependent: IntArray

    @property
    def inner(self) -> IntArray:
        """Coordinates that no joint fixes or moves, (i,)."""
        return np.flatnonzero(~(self.fixed | self.joined))

    @property
    def joined(self) -> NDArray[np.bool_]:
        """Coordinates of the link that boundary coordinates move, (n,)."""
        return np.asarray(self.unit.any(axis=1), dtype=bool)


@dataclass(frozen=True)
class JoinedEnds:
    """Link ends of a linkage by their joints.

    Parameters
    ----------
    topology : Topology
    tied : set of LinkEnd
        Joined to other links, on a line, or on springs.
    welded : set of LinkEnd
        Tied by welds, or clamped to a free shaft.
    dependent : sequence of LinkEnd
        Ends of flexible links that depend on another link's end, a rigid link or a line.
    """

    topology: Topology
    tied: set[LinkEnd]
    welded: set[LinkEnd]
    dependent: Sequence[LinkEnd]

    @classmethod
    def of(cls, topology: Topology) -> JoinedEnds:
        """Ends of a linkage."""
        return cls(
            topology, _tied_ends(topology), _welded_ends(topology), _dependent_ends(topology)
        )


def link_boundary(ends: JoinedEnds, link: LinkModel) -> LinkBoundary:
    """Coordinates of a flexible link at its joints.

    Parameters
    ----------
    ends : JoinedEnds
        Of its linkage.
    link : LinkModel
        Unreduced.

    Returns
    -------
    LinkBoundary
    """
    fixed = np.zeros(link.size, dtype=bool)
    for rows in _fixed_by_joints(ends.topology, link):
        fixed[rows] = True
    columns: list[IntArray] = []
    kept: dict[str, IntArray] = {}
    for end in ENDS:
        rows = link.end_displacement(end)
        keeps = LinkEnd(link.name, end) in ends.tied and not fixed[rows].any()
        kept[end] = len(columns) + np.arange(2 if keeps else 0)
        columns += [rows[n : n + 1] for n in range(2 if keeps else 0)]
    for end in ENDS:
        rows = link.end_rotation_of(end)
        keeps = bool(len(rows)) and LinkEnd(link.name, end) in ends.welded and not fixed[rows].any()
        # Both ends of a bar have one rotation.
        before = [n for n, own in enumerate(columns) if np.array_equal(own, rows)]
        numbers = (before or [len(columns)]) if keeps else []
        kept[f"{end}_rotation"] = np.array(numbers, dtype=np.intp)
        columns += [rows] if len(columns) in numbers else []
    # The section of a body off the axis is a joint too: a rigid link is welded to it.
    arms = [body.rows.any(axis=0) for body in link.attached_off_axis]
    taken = fixed.copy()
    taken[np.concatenate([*columns, np.zeros(0, dtype=np.intp)])] = True
    columns += list(np.flatnonzero(np.any(arms, axis=0) & ~taken)[:, None]) if arms else []
    unit = np.zeros((link.size, len(columns)))
    for number, rows in enumerate(columns):
        unit[rows, number] = 1.0
    ends_of_link = [kept[place.end] for place in ends.dependent if place.link == link.name]
    dependent = np.concatenate([np.zeros(0, dtype=np.intp), *ends_of_link])
    return LinkBoundary(fixed, unit, kept, dependent)


def _fixed_by_joints(topology: Topology, link: LinkModel) -> Iterator[IntArray]:
    """Coordinates that the ground, the shaft or a fitting fixes, end by end."""
    for clamp in topology.clamps:
        if clamp.link_end.link == link.name:
            if not (clamp.free and clamp.hub):
                yield link.end_displacement(clamp.link_end.end)
            if not clamp.free:
                yield link.end_rotation_of(clamp.link_end.end)
    for pivot in topology.pivots:
        if pivot.link_end.link == link.name and not pivot.sprung:
            yield link.end_displacement(pivot.link_end.end)
    for place in topology.joined_ends:
        if place.link == link.name:
            yield link.end_warping_of(place.end)


def _tied_ends(topology: Topology) -> set[LinkEnd]:
    tied = {place for tie in topology.ties for place in (tie.leader, tie.follower)}
    tied |= {slider.link_end for slider in topology.sliders}
    tied |= {clamp.link_end for clamp in topology.clamps if clamp.free and clamp.hub}
    return tied | {pivot.link_end for pivot in topology.pivots if pivot.sprung}


def _welded_ends(topology: Topology) -> set[LinkEnd]:
    welded = {place for weld in topology.welds for place in (weld.leader, weld.follower)}
    return welded | {clamp.link_end for clamp in topology.clamps if clamp.free}


def _dependent_ends(topology: Topology) -> list[LinkEnd]:
    rigid = {link.name for link in topology.links if link.rigid}
    welded, dependent = _welded_ends(topology), []
    for point in joint_points(topology):
        elastic = [end for end in point.ends if end.link not in rigid]
        # What is welded to a rigid link does not turn against its frame.
        leaders = elastic[:1]
        if point.slider is not None:
            leaders = []
        elif len(elastic) < len(point.ends):
            leaders = [end for end in elastic if end in welded][:1]
        dependent += [end for end in elastic if end not in leaders]
    return dependent
