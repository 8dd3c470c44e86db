"""Which link ends are one point, and which of them turn together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexmech.linkages import LinkEnd, Pin, Topology, Weld
from flexmech.linkages.topology import leading_end


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
    hub : float
        Distance in m from the axis of a free shaft at which the point is on its hub, along the
        frame of the first end's link; zero of others.
    """

    ends: tuple[LinkEnd, ...]
    held: bool
    slider: int | None
    hub: float = 0.0


@dataclass(frozen=True)
class TurningJoint:
    """Link ends that welds turn together.

    Parameters
    ----------
    ends : tuple of LinkEnd
        The one that the others follow, by the topology, comes first.
    held : bool
        Whether the shaft holds their rotation; one that is free turns with them.
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
    followers = _followers(topology.rigid_ties)
    hubs = {clamp.link_end: clamp.hub for clamp in topology.clamps if clamp.free and clamp.hub}
    held = {clamp.link_end for clamp in topology.clamps} - set(hubs)
    held |= {pivot.link_end for pivot in topology.pivots if not pivot.sprung}
    sliders = {slider.link_end: number for number, slider in enumerate(topology.sliders)}
    roots = dict.fromkeys([*held, *hubs, *sliders, *followers])
    return [
        JointPoint(
            (root, *followers.get(root, ())), root in held, sliders.get(root), hubs.get(root, 0.0)
        )
        for root in sorted(roots, key=lambda end: (topology.index(end.link), end.end == "end"))
    ]


def turning_joints(topology: Topology) -> list[TurningJoint]:
    """Link ends whose rotations are one, held, or that of a free shaft.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    list of TurningJoint
    """
    followers = _followers(topology.welds)
    held = {clamp.link_end: not clamp.free for clamp in topology.clamps}
    roots = dict.fromkeys([*held, *followers])
    return [
        TurningJoint((root, *followers.get(root, ())), held.get(root, False))
        for root in sorted(roots, key=lambda end: (topology.index(end.link), end.end == "end"))
    ]


def _followers(ties: Sequence[Pin | Weld]) -> dict[LinkEnd, tuple[LinkEnd, ...]]:
    """Of each end that follows none, those that follow it directly or not."""
    followers: dict[LinkEnd, tuple[LinkEnd, ...]] = {}
    for tie in ties:
        root = leading_end(tie.follower, ties)
        followers[root] = (*followers.get(root, ()), tie.follower)
    return followers
