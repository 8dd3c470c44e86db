"""Link ends that coincide at a joint, and link ends whose rotations are equal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexmech.linkages import LinkEnd, Pin, Topology, Weld
from flexmech.linkages.topology import leading_end


@dataclass(frozen=True)
class JointPoint:
    """Link ends that coincide at a pin or a weld.

    Parameters
    ----------
    ends : tuple of LinkEnd
        The leader, by the topology, comes first.
    fixed : bool
        Whether the point is fixed to the ground or to the shaft.
    slider : int, optional
        Number of the slider on whose line the point is.
    hub : float
        Distance in m from the axis of a free shaft at which the point is on its hub, along the
        frame of the first end's link; zero of others.
    """

    ends: tuple[LinkEnd, ...]
    fixed: bool
    slider: int | None
    hub: float = 0.0


@dataclass(frozen=True)
class JointRotation:
    """Link ends that welds give equal rotations.

    Parameters
    ----------
    ends : tuple of LinkEnd
        The leader, by the topology, comes first.
    fixed : bool
        Whether their rotation is fixed to the prescribed shaft; one that is free rotates with them.
    """

    ends: tuple[LinkEnd, ...]
    fixed: bool


def joint_points(topology: Topology) -> list[JointPoint]:
    """Points at which link ends coincide; joints of springs alone are not among them.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    list of JointPoint
        Of ends that are joined, fixed or on a slider's line; free tips are not among them.
    """
    dependent = _ends_by_leader(topology.rigid_ties)
    hubs = {clamp.link_end: clamp.hub for clamp in topology.clamps if clamp.free and clamp.hub}
    fixed = {clamp.link_end for clamp in topology.clamps} - set(hubs)
    fixed |= {pivot.link_end for pivot in topology.pivots if not pivot.sprung}
    sliders = {slider.link_end: number for number, slider in enumerate(topology.sliders)}
    roots = dict.fromkeys([*fixed, *hubs, *sliders, *dependent])
    return [
        JointPoint(
            (root, *dependent.get(root, ())), root in fixed, sliders.get(root), hubs.get(root, 0.0)
        )
        for root in sorted(roots, key=lambda end: (topology.index(end.link), end.end == "end"))
    ]


def joint_rotations(topology: Topology) -> list[JointRotation]:
    """Link ends whose rotations are equal, fixed, or that of a free shaft.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    list of JointRotation
    """
    dependent = _ends_by_leader(topology.welds)
    fixed = {clamp.link_end: not clamp.free for clamp in topology.clamps}
    roots = dict.fromkeys([*fixed, *dependent])
    return [
        JointRotation((root, *dependent.get(root, ())), fixed.get(root, False))
        for root in sorted(roots, key=lambda end: (topology.index(end.link), end.end == "end"))
    ]


def _ends_by_leader(ties: Sequence[Pin | Weld]) -> dict[LinkEnd, tuple[LinkEnd, ...]]:
    """Ends that depend on each leader, directly or through others."""
    dependent: dict[LinkEnd, tuple[LinkEnd, ...]] = {}
    for tie in ties:
        root = leading_end(tie.follower, ties)
        dependent[root] = (*dependent.get(root, ()), tie.follower)
    return dependent
