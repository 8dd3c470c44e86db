"""Which link ends are one point, and which of them turn together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from flexmech.errors import InputError
from flexmech.linkages import LinkEnd, Pin, Topology, Weld

__all__ = ["JointPoint", "TurningJoint", "joint_points", "turning_joints"]


@dataclass(frozen=True)
class JointPoint:
    """Link ends that pins and welds keep at one point.

    Parameters
    ----------
    ends : tuple of LinkEnd
        The one that the others follow, by the topology, comes first.
    held : bool
        Whether the ground or the shaft holds the point.
    slider : int, optional
        Number of the slider that guides it.
    """

    ends: tuple[LinkEnd, ...]
    held: bool
    slider: int | None


@dataclass(frozen=True)
class TurningJoint:
    """Link ends that welds turn together.

    Parameters
    ----------
    ends : tuple of LinkEnd
        The one that the others follow, by the topology, comes first.
    held : bool
        Whether the shaft holds their rotation.
    """

    ends: tuple[LinkEnd, ...]
    held: bool


def joint_points(topology: Topology) -> list[JointPoint]:
    """Points at which link ends meet, without those that springs alone hold together.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    list of JointPoint
        Of ends that are tied, held or guided; free tips are not in it.
    """
    pins = (pin for pin in topology.pins if not pin.sprung)
    followers = _followers([*pins, *topology.welds])
    held = {clamp.held for clamp in topology.clamps}
    held |= {pivot.held for pivot in topology.pivots if not pivot.sprung}
    sliders = {slider.held: number for number, slider in enumerate(topology.sliders)}
    roots = dict.fromkeys([*held, *sliders, *followers])
    return [
        JointPoint((root, *followers.get(root, ())), root in held, sliders.get(root))
        for root in sorted(roots, key=lambda end: (topology.index(end.link), end.end == "end"))
    ]


def turning_joints(topology: Topology) -> list[TurningJoint]:
    """Link ends whose rotations are one or held.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    list of TurningJoint
    """
    followers = _followers(topology.welds)
    held = {clamp.held for clamp in topology.clamps}
    roots = dict.fromkeys([*held, *followers])
    return [
        TurningJoint((root, *followers.get(root, ())), root in held)
        for root in sorted(roots, key=lambda end: (topology.index(end.link), end.end == "end"))
    ]


def _followers(ties: Iterable[Pin | Weld]) -> dict[LinkEnd, tuple[LinkEnd, ...]]:
    """Of each end that follows none, those that follow it directly or not."""
    leaders = {tie.follower: tie.leader for tie in ties}
    followers: dict[LinkEnd, tuple[LinkEnd, ...]] = {}
    for end in leaders:
        root = _root(leaders, end)
        followers[root] = (*followers.get(root, ()), end)
    return followers


def _root(leaders: Mapping[LinkEnd, LinkEnd], end: LinkEnd) -> LinkEnd:
    seen = {end}
    while end in leaders:
        end = leaders[end]
        if end in seen:
            raise InputError(f"pins and welds lead in a circle at {end}")
        seen.add(end)
    return end
