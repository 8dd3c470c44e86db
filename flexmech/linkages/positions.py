"""Where the points of a linkage are, and what its pictures show: links, joints, named points."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.linkage import Linkage, assemblable
from flexmech.linkages.planar import PlanarLinkage
from flexmech.linkages.topology import LinkEnd, Topology

if TYPE_CHECKING:
    import xarray as xr

# In degrees; the first at which the linkage can be assembled shows it best. Then every degree.
PICTURE_ANGLES = (60.0, 0.0, 30.0, 90.0, 120.0, 180.0, 240.0, 300.0, *range(1, 360))


def linkage_positions(linkage: Linkage, crank_angle: float) -> xr.Dataset:
    """Ends of the links, and the joints, at one crank angle.

    Parameters
    ----------
    linkage : Linkage
    crank_angle : float
        In rad.

    Returns
    -------
    xarray.Dataset
        ``rigid_position`` (link, station, component) at both ends of each link and
        ``joint_position`` (joint, component) in m, ``joint_kind`` (joint): clamp, pivot, pin,
        weld or slider; and the attribute ``drawing``, what :func:`drawn_joints` gives as JSON.

    Raises
    ------
    InputError
        If the linkage cannot be assembled at the crank angle.
    """
    import xarray as xr

    topology, motion = linkage.topology, linkage.motion(crank_angle)
    ends = np.array(
        [
            [motion.position(number, x) for x in (0.0, link.length)]
            for number, link in enumerate(topology.links)
        ]
    )
    joints = [
        ends[topology.index(place.link), 0 if place.end == "start" else 1]
        for place in topology.joints.values()
    ]
    return xr.Dataset(
        {
            "rigid_position": (("link", "station", "component"), ends, {"units": "m"}),
            "joint_position": (("joint", "component"), np.array(joints), {"units": "m"}),
        },
        coords={
            "link": list(topology.link_names),
            "component": ["x", "y"],
            "joint": list(topology.joint_names),
            "joint_kind": ("joint", list(topology.joint_kinds)),
        },
        attrs={"drawing": json.dumps(drawn_joints(topology))},
    )


def picture_crank_angle(linkage: Linkage) -> float:
    """Crank angle in rad for pictures of a linkage: the first usual one that it can take.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the linkage can be assembled at no crank angle of whole degrees.
    """
    for degrees in PICTURE_ANGLES:
        if assemblable(linkage, np.radians([degrees])).all():
            return float(np.radians(degrees))
    raise InputError(
        "the linkage can be assembled at no crank angle of whole degrees; check its lengths"
    )


def drawn_joints(topology: Topology) -> dict[str, Any]:
    """Data of links and joints for pictures, in values that JSON can store.

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


def moving_points(linkage: Linkage) -> dict[str, LinkEnd]:
    """Named points that are not of the ground, each with a link end that is there.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    dict of str to LinkEnd
        Points of a drawing; pins and sliders of other linkages, each place once, and free ends of
        links, called tips. A frame that stands still has none.
    """
    if isinstance(linkage, PlanarLinkage):
        drawing = linkage.drawing
        if drawing.is_stationary:
            return {}
        moving = (name for name in drawing.points if name not in drawing.ground)
        return {name: next(iter(drawing.ends_at(name).values()))[0] for name in moving}
    topology = linkage.topology
    sliders = {slider.joint: slider.link_end for slider in topology.sliders}
    return _pins(topology) | sliders | _tips(topology)


def _pins(topology: Topology) -> dict[str, LinkEnd]:
    """Leaders of pins, each place once."""
    pins = {tie.joint: topology.leader_of(tie.leader) for tie in topology.pins}
    places = {place: joint for joint, place in reversed(pins.items())}
    return {joint: place for joint, place in pins.items() if places[place] == joint}


def _tips(topology: Topology) -> dict[str, LinkEnd]:
    """Free ends of links."""
    ends = [LinkEnd(link.name, "start") for link in topology.links]
    ends += [LinkEnd(link.name, "end") for link in topology.links]
    tips = [end for end in ends if end not in topology.joined_ends]
    return {"tip" if len(tips) == 1 else f"tip of {end.link}": end for end in tips}
