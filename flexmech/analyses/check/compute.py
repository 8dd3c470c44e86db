"""What is known of a mechanism: geometry, masses, sections, operation, frequencies at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.check.result import LENGTH, LINK_MASS, ModelCheck
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.requests import engine_of
from flexmech.analyses.section_profile.properties import section_properties
from flexmech.errors import InputError
from flexmech.hygrothermal import absorbing_links, silent_links
from flexmech.linear_system import Engine
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["check_mechanism"]

UNITS = {
    LENGTH.name: (LENGTH.unit, "length of the link"),
    LINK_MASS.name: (LINK_MASS.unit, "mass of the link without point masses"),
    "joint_mass": ("kg", "point mass at the joint"),
    "point_mass": ("kg", "point mass along a link"),
    "point_mass_position": ("m", "distance of the point mass from the link's start"),
    "gravity": ("m/s^2", "gravitational acceleration in ground axes"),
    "operating_speed": ("rad/s", "crank speed at which the mechanism operates"),
    "frequency": ("Hz", "natural frequency at rest, crank angle 0"),
    "rigid_position": ("m", "ends of the link at crank angle 0"),
    "joint_position": ("m", "place of the joint at crank angle 0"),
}


def check_mechanism(engine: Engine) -> ModelCheck:
    """What is known of a mechanism, with its natural frequencies at rest.

    Parameters
    ----------
    engine : Engine
        Of the mechanism; it computes the frequencies at crank angle 0.

    Returns
    -------
    ModelCheck
        Without frequencies where the linkage cannot stand at crank angle 0.

    Raises
    ------
    ComputationError
        As :func:`flexmech.natural_frequencies`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> check = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism))
    >>> check.dataset["length"].values
    array([0.102 , 0.2794, 0.2667])
    """
    mechanism = engine_of(engine).mechanism
    topology = mechanism.linkage.topology
    sections = {name: mechanism.sections[name] for name in topology.link_names}
    dataset = section_properties(sections).sel(coupling="with", drop=True)
    dataset = dataset.assign(_of_links(mechanism) | _of_joints(mechanism))
    why_none = ""
    try:
        # Not every linkage can stand at crank angle zero; what is known of it is right even so.
        dataset["frequency"] = ("mode", natural_frequencies(engine, 0.0))
        dataset = dataset.assign(_positions(topology, mechanism.linkage.motion(0.0)))
    except InputError as error:
        why_none = str(error)
    point = mechanism.coupler_point
    attributes = {
        **provenance([engine]),
        "engine": engine.name,
        "linkage": "\n".join(mechanism.linkage.described()),
        "reference_temperature": mechanism.reference_temperature,
        "without_frequencies": why_none,
    }
    if point is not None:
        attributes |= {"coupler_point_distance": point.distance, "coupler_point_angle": point.angle}
    return ModelCheck(with_units(dataset, UNITS).assign_attrs(attributes))


def _of_links(mechanism: Mechanism) -> dict[str, Any]:
    """Lengths and masses of links, and whether heat and moisture change them."""
    links, points = mechanism.linkage.topology.links, mechanism.link_masses
    unchanged, absorbing = silent_links(mechanism), absorbing_links(mechanism)
    masses = [mechanism.sections[link.name].mass_per_length * link.length for link in links]
    return {
        LENGTH.name: ("link", [link.length for link in links]),
        LINK_MASS.name: ("link", masses),
        "changed_by_environment": ("link", [link.name not in unchanged for link in links]),
        "takes_up_water": ("link", [link.name in absorbing for link in links]),
        "point_mass": ("point", [point.mass for point in points]),
        "point_mass_position": ("point", [point.position for point in points]),
        "point_mass_link": ("point", np.array([point.link for point in points], dtype=str)),
        "gravity": ("component", list(mechanism.gravity)),
        "component": ["x", "y"],
        "operating_speed": list(mechanism.operating_speeds),
    }


def _of_joints(mechanism: Mechanism) -> dict[str, Any]:
    topology = mechanism.linkage.topology
    kinds = {"clamp": topology.clamps, "pin": topology.pins, "pivot": topology.pivots}
    kind_of = {one.joint: kind for kind, connections in kinds.items() for one in connections}
    return {
        "joint": list(topology.joint_names),
        "joint_kind": ("joint", [kind_of[name] for name in topology.joint_names]),
        "joint_mass": ("joint", [mechanism.joint_masses.get(n, 0.0) for n in topology.joint_names]),
    }


def _positions(topology: Topology, motion: RigidMotion) -> dict[str, Any]:
    """Ends of the links and places of the joints in ground axes."""

    def position(place: LinkEnd) -> FloatArray:
        number = topology.index(place.link)
        return motion.position(number, topology.links[number].length * (place.end == "end"))

    ends = [
        [position(LinkEnd(name, "start")), position(LinkEnd(name, "end"))]
        for name in topology.link_names
    ]
    joints = [position(place) for place in topology.joints.values()]
    return {
        "rigid_position": (("link", "station", "component"), np.array(ends)),
        "joint_position": (("joint", "component"), np.array(joints)),
    }
