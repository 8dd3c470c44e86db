"""The path of a point of any link of any linkage, by its rigid motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.errors import InputError, suggestion
from flexmech.hygrothermal import (
    Environment,
    HygrothermalState,
    elongation_of,
    rigid_linkage_in_state,
)
from flexmech.linkages import CouplerPoint, Linkage, PlanarLinkage
from flexmech.linkages.motion import direction
from flexmech.mechanism import Mechanism
from flexmech.numbers import check_instance
from flexmech.types import FloatArray

METRE, RADIAN = {"units": "m"}, {"units": "rad"}


def link_named(linkage: Linkage, link: str) -> str:
    """Link of the topology that a name stands for: of a chain of beams, its first one.

    Parameters
    ----------
    linkage : Linkage
    link : str

    Returns
    -------
    str

    Raises
    ------
    InputError
        If there is no such link; names the nearest one.
    """
    check_instance(link, str, "link", "give the name of a link, such as 'coupler'")
    chains = {}
    if isinstance(linkage, PlanarLinkage):
        chains = {drawn.name: drawn.beams[0].name for drawn in linkage.links}
    known = linkage.topology.link_names
    if link in known:
        return link
    if link not in chains:
        names = list(dict.fromkeys([*chains, *known]))
        raise InputError(f"the linkage has no link {link!r}; {suggestion(link, names)}")
    return chains[link]


def path_of_link(
    mechanism: Mechanism,
    link: str,
    point: CouplerPoint,
    environment: Environment,
    crank_angles: FloatArray,
) -> xr.Dataset:
    """Path of a point of a link in one state, with those of the pins.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    link : str
        Of the topology.
    point : CouplerPoint
        By its distance from the link's start and the angle from the link's line.
    environment : HygrothermalState or Exposure
    crank_angles : ndarray, shape (A,)
        In rad.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    InputError
        Where the linkage cannot be assembled or locks.
    """
    linkage = rigid_linkage_in_state(mechanism, environment)
    if environment != HygrothermalState():
        point = point.scaled(1 + elongation_of(mechanism, link, environment))
    topology = linkage.topology
    motion, number = linkage.motion(crank_angles), topology.index(link)
    turned = motion.angle[:, number] + point.angle
    position = motion.origin[:, number] + point.distance * direction(turned)
    pins = [motion.position(number, x) for x in (0.0, topology.links[number].length)]
    over = "crank_angle"
    variables: dict[str, Any] = {
        "position": ((over, "component"), position, METRE),
        "pin_position": ((over, "pin", "component"), np.stack(pins, axis=1), METRE),
        "angle": ((over, "link"), np.unwrap(motion.angle[:, [number]], axis=0), RADIAN),
        "length": ("member", [own.length for own in topology.links], METRE),
        "coupler_point_distance": ((), point.distance, METRE),
    }
    coordinates = {
        "crank_angle": (over, crank_angles, RADIAN),
        "component": ["x", "y"],
        "pin": ["start", "end"],
        "link": [link],
        "member": list(topology.link_names),
    }
    return xr.Dataset(variables, coordinates)
