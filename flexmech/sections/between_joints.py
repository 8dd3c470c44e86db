"""Sections of links whose joints restrain their twist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from flexmech.linkages import Topology
from flexmech.linkages.topology import LinkEnd
from flexmech.sections.beam_section import BeamSection
from flexmech.sections.laminate_section import LaminateSection


def sections_between_joints(
    topology: Topology, sections: Mapping[str, BeamSection]
) -> dict[str, BeamSection]:
    """Sections of links, those that twist as they bend with what their joints do to that.

    Parameters
    ----------
    topology : Topology
    sections : mapping of str to BeamSection
        By link.

    Returns
    -------
    dict of str to BeamSection
        With the twist held where both ends of a link are at joints, and the section does not
        say otherwise. A section whose stiffness is stated rather than its layers' stays as it is.
    """
    joined = topology.joined_ends
    return {
        name: _restrained(section)
        if {LinkEnd(name, "start"), LinkEnd(name, "end")} <= joined
        else section
        for name, section in sections.items()
    }


def _restrained(section: BeamSection) -> BeamSection:
    layers = section.layers
    if not isinstance(layers, LaminateSection) or layers.twist is not None or not layers.twists:
        return section
    if section != BeamSection.of_laminate(layers).damped_as(section):
        return section
    untwisted = BeamSection.of_laminate(replace(layers, twist="held"))
    if section.damping_frequency is None or section.specific_damping is None:
        return untwisted.damped_as(section)
    return untwisted.with_damping_frequency(section.damping_frequency)
