"""What a picture of a mechanism shows: posture, masses, paths, stacks, transmission angle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from flexmech.analyses.check.remarks import USUAL_TRANSMISSION_ANGLE
from flexmech.linkages import (
    CouplerCurve,
    FourBar,
    LinkEnd,
    Topology,
    linkage_positions,
    standing,
)
from flexmech.linkages.topology import End
from flexmech.mechanism import Mechanism, drawing
from flexmech.sections import BeamSection
from flexmech.types import FloatArray

# Crank angles of paths and of the transmission angle.
TURN = np.radians(np.arange(0.0, 361.0))
ENDS: tuple[End, End] = ("start", "end")
COUPLER_POINT, COUPLER_MIDDLE = "coupler point", "coupler's middle"


def drawn_mechanism(mechanism: Mechanism, crank_angle: float) -> xr.Dataset:
    """A mechanism in one posture, and over a turn of its crank.

    Parameters
    ----------
    mechanism : Mechanism
    crank_angle : float
        Of the posture in rad.

    Returns
    -------
    xarray.Dataset
        ``posture_angle``; ``rigid_position`` (link, station, component), ``joint_position``
        (joint, component), ``joint_mass`` (joint), ``point_mass`` and ``point_mass_position``
        (mass, component) where there are some, and ``path_position`` (path, component). Over the
        turn ``path`` (path, crank_angle, component) of the pins that move, an arm's tip and the
        coupler point, and of a four-bar ``transmission_angle`` (crank_angle), not a number where
        the linkage cannot stand, ``transmission_angle_limit`` and
        ``usual_transmission_angle`` (limit). Of the sections
        ``layer_low`` and ``layer_high`` in m, ``ply`` and ``ply_angle`` over (link, layer), and
        ``stacking`` (link).

    Raises
    ------
    InputError
        If the linkage cannot stand at the crank angle.
    """
    linkage = mechanism.linkage
    dataset = linkage_positions(linkage, crank_angle).assign_attrs(drawing=drawing(mechanism))
    joints = [float(mechanism.joint_masses.get(str(name), 0.0)) for name in dataset["joint"].values]
    dataset["joint_mass"] = ("joint", joints)
    dataset["posture_angle"] = crank_angle
    ends = dataset["rigid_position"]
    if masses := [point for point in mechanism.link_masses if point.mass > 0]:
        places = []
        for point in masses:
            link = ends.sel(link=point.link).values
            along = link[1] - link[0]
            places.append(link[0] + point.position * along / np.hypot(*along))
        dataset["point_mass"] = ("mass", [point.mass for point in masses])
        dataset["point_mass_position"] = (("mass", "component"), np.array(places))
    paths = _paths(mechanism, np.append(TURN, crank_angle))
    if paths:
        of_turn = np.stack(list(paths.values()))
        dataset = dataset.assign_coords(path_name=("path", list(paths)), crank_angle=TURN)
        dataset["path"] = (("path", "crank_angle", "component"), of_turn[:, :-1])
        dataset["path_position"] = (("path", "component"), of_turn[:, -1])
    if isinstance(linkage, FourBar):
        dataset["transmission_angle"] = ("crank_angle", _transmission_angle(linkage))
        limits = linkage.transmission_angle_limits()
        dataset["transmission_angle_limit"] = ("limit", np.array(limits))
        dataset["usual_transmission_angle"] = ("limit", np.radians(USUAL_TRANSMISSION_ANGLE))
    names = linkage.topology.link_names
    return dataset.merge(_stacks({name: mechanism.sections.get(name) for name in names}))


def _paths(mechanism: Mechanism, angles: FloatArray) -> dict[str, FloatArray]:
    """Places of what moves at crank angles, by name; shape (angle, 2) each."""
    linkage, topology = mechanism.linkage, mechanism.linkage.topology
    stands = standing(linkage, angles)
    motion = linkage.motion(angles[stands])
    found = {}
    for name, place in _moving_ends(topology).items():
        number = topology.index(place.link)
        distance = 0.0 if place.end == "start" else topology.links[number].length
        found[name] = motion.position(number, distance)
    if (point := mechanism.coupler_point) is not None and isinstance(linkage, FourBar):
        found[COUPLER_POINT] = CouplerCurve(linkage, point).position(angles[stands])
    elif "coupler" in topology.link_names:
        number = topology.index("coupler")
        found[COUPLER_MIDDLE] = motion.position(number, topology.links[number].length / 2)
    whole = {}
    for name, places in found.items():
        whole[name] = np.full((len(angles), 2), np.nan)
        whole[name][stands] = places
    return whole


def _moving_ends(topology: Topology) -> dict[str, LinkEnd]:
    """Ends of links whose paths are drawn: pins, each place once, and free tips."""
    pins = {tie.joint: topology.leader_of(tie.leader) for tie in topology.pins}
    places = {place: joint for joint, place in reversed(pins.items())}
    found = {joint: place for joint, place in pins.items() if places[place] == joint}
    ends = [LinkEnd(link.name, end) for link in topology.links for end in ENDS]
    tips = [end for end in ends if end not in topology.joined_ends]
    return found | {"tip" if len(tips) == 1 else f"tip of {end.link}": end for end in tips}


def _transmission_angle(linkage: FourBar) -> FloatArray:
    stands = standing(linkage, TURN)
    angle = np.full(TURN.size, np.nan)
    angle[stands] = linkage.transmission_angle(TURN[stands])
    return angle


def _stacks(sections: Mapping[str, BeamSection | None]) -> xr.Dataset:
    """Layers of the sections from the lowest y up; one without a name where none is known."""
    most = max(len(_layers(section)) for section in sections.values())
    faces = np.full((2, len(sections), most), np.nan)
    plies, angles = np.full(faces.shape[1:], "", dtype=object), np.zeros(faces.shape[1:])
    texts = []
    for row, section in enumerate(sections.values()):
        layers = _layers(section)
        for column, (ply, angle, low, high) in enumerate(layers):
            faces[:, row, column] = low, high
            plies[row, column], angles[row, column] = ply, angle
        known = None if section is None else section.layers
        texts.append(known.laminate.stacking if known and len(layers) > 1 else "")
    over = ("link", "layer")
    return xr.Dataset(
        {
            "layer_low": (over, faces[0]),
            "layer_high": (over, faces[1]),
            "ply": (over, plies.astype(str)),
            "ply_angle": (over, angles),
            "stacking": ("link", texts),
        },
        coords={"link": list(sections)},
    )


def _layers(section: BeamSection | None) -> list[tuple[str, float, float, float]]:
    """Name, angle and faces in m of each layer of a section; not numbers where there is none."""
    if section is None:
        return [("", 0.0, np.nan, np.nan)]
    half = section.in_plane_thickness / 2
    if section.layers is None or len(section.layers.laminate.layers) == 1:
        return [("", 0.0, -half, half)]
    layers = section.layers.laminate.layers
    tops = np.cumsum([layer.thickness for layer in layers]) - half
    return [
        (layer.ply.name, layer.angle, float(top) - layer.thickness, float(top))
        for layer, top in zip(layers, tops, strict=True)
    ]
