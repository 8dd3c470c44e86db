"""Where links and joints of a rigid linkage are, as the dataset of a picture."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.errors import InputError
from flexmech.linkages.drawing import drawn_joints
from flexmech.linkages.linkage import Linkage
from flexmech.types import FloatArray

if TYPE_CHECKING:
    import xarray as xr


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
        ``joint_position`` (joint, component) in m, ``joint_kind`` (joint): clamp, pivot, pin,
        weld or slider; and the attribute ``drawing``, what :func:`drawn_joints` gives as JSON.

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
        attrs={"drawing": json.dumps(drawn_joints(topology))},
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
        if _stands(linkage, np.radians(degrees)):
            return float(np.radians(degrees))
    raise InputError("the linkage can stand at no crank angle of whole degrees; check its lengths")


def standing(linkage: Linkage, crank_angles: FloatArray) -> NDArray[np.bool_]:
    """Whether a linkage can stand at each of some crank angles.

    Parameters
    ----------
    linkage : Linkage
    crank_angles : ndarray, shape (A,)
        In rad.

    Returns
    -------
    ndarray of bool, shape (A,)
    """
    if _stands(linkage, crank_angles):
        return np.ones(len(crank_angles), dtype=bool)
    return np.array([_stands(linkage, angle) for angle in crank_angles.tolist()], dtype=bool)


def _stands(linkage: Linkage, crank_angle: ArrayLike) -> bool:
    """Whether it stands at a crank angle, or at each of several."""
    try:
        linkage.motion(crank_angle)
    except InputError:
        return False
    return True
