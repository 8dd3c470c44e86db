"""What a picture of a linkage shows of its joints: plain data, the same in every posture."""

from __future__ import annotations

from typing import Any

from flexmech.linkages.topology import LinkEnd, Topology


def drawn_joints(topology: Topology) -> dict[str, Any]:
    """Links and joints as a picture shows them, in numbers and words that JSON can hold.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    dict
        ``links``: ``name`` and whether ``rigid``. ``joints``: ``name``, ``kind``, ``at`` (number
        of a link, and how far along it from 0 to 1); of sliders ``direction`` of the line in rad
        to the x axis of the ground or of the link whose number is ``guide``. ``hub``: distance of
        the driven link's end from the axis of the shaft in m.
    """
    lines = {slider.joint: slider for slider in topology.sliders}
    joints = []
    for (name, place), kind in zip(topology.joints.items(), topology.joint_kinds, strict=True):
        joint: dict[str, Any] = {"name": name, "kind": kind, "at": _at(topology, place)}
        if (line := lines.get(name)) is not None:
            joint["direction"] = line.direction
            joint["guide"] = topology.index(line.guide) if line.guide else None
        joints.append(joint)
    return {
        "links": [{"name": link.name, "rigid": link.rigid} for link in topology.links],
        "joints": joints,
        "hub": topology.clamps[0].hub if topology.clamps else 0.0,
    }


def _at(topology: Topology, place: LinkEnd) -> list[float]:
    return [topology.index(place.link), 0.0 if place.end == "start" else 1.0]
