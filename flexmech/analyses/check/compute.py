"""What is known of a mechanism: sections, masses, words, and natural frequencies at rest."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmech.analyses.check.result import LENGTH, LINK_MASS, ModelCheck
from flexmech.analyses.check.words import mechanism_lines
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.requests import engine_of
from flexmech.analyses.section_profile.properties import section_properties
from flexmech.analyses.stations import rigid_positions
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.linkages import Clamp, Pin, Pivot

__all__ = ["check_mechanism"]


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
    links = mechanism.linkage.topology.links
    sections = {link.name: mechanism.sections[link.name] for link in links}
    dataset = section_properties(sections).sel(coupling="with", drop=True)
    dataset[LENGTH.name] = ("link", [link.length for link in links])
    dataset[LINK_MASS.name] = dataset["mass_per_length"] * dataset[LENGTH.name]
    dataset = dataset.assign_attrs(
        provenance([engine]),
        engine=engine.name,
        linkage="\n".join(mechanism.linkage.described()),
        mechanism_lines="\n".join(mechanism_lines(mechanism)),
        without_frequencies="",
    )
    try:
        dataset["frequency"] = ("mode", natural_frequencies(engine, 0.0))
        dataset = dataset.assign(_positions(engine))
    except InputError as error:
        # Not every linkage can stand at crank angle zero; what is known of it is right even so.
        dataset.attrs["without_frequencies"] = str(error)
    return ModelCheck(with_units(dataset, "check"))


def _positions(engine: Engine) -> dict[str, Any]:
    """Stations along the links, and joints, in ground axes."""
    linkage = engine.mechanism.linkage
    topology = linkage.topology
    stations = rigid_positions(engine, linkage.motion(np.zeros(1)))[0]
    joints = [
        stations[topology.index(place.link), 0 if place.end == "start" else -1]
        for place in topology.joints.values()
    ]
    connections: tuple[Clamp | Pin | Pivot, ...]
    connections = (*topology.clamps, *topology.pins, *topology.pivots)
    kinds = {one.joint: type(one).__name__.lower() for one in connections}
    return {
        "rigid_position": (("link", "station", "component"), stations),
        "joint_position": (("joint", "component"), np.array(joints)),
        "joint_kind": ("joint", [kinds[name] for name in topology.joint_names]),
        "joint": list(topology.joint_names),
    }
