"""Where links and joints of a rigid linkage are, as the dataset of a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.linkage import Linkage

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["linkage_positions", "shown_crank_angle"]

# In degrees; the first at which the linkage can stand shows it best. Then every degree.
SHOWN = (60.0, 0.0, 30.0, 90.0, 120.0, 180.0, 240.0, 300.0, *range(1, 360))


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
        ``joint_position`` (joint, component) in m, and ``joint_kind`` (joint): clamp, pivot or
        pin.

    Raises
    ------
    InputError
        If the linkage cannot stand at the crank angle.
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
    )


def shown_crank_angle(linkage: Linkage) -> float:
    """Crank angle in rad at which a picture shows a linkage.

    Parameters
    ----------
    linkage : Linkage

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the linkage can stand at no crank angle of whole degrees.
    """
    for degrees in SHOWN:
        try:
            linkage.motion(np.radians(degrees))
        except InputError:
            continue
        return float(np.radians(degrees))
    raise InputError("the linkage can stand at no crank angle of whole degrees; check its lengths")
