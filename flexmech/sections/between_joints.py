"""Sections of links whose joints keep them from twisting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from flexmech.linkages import Topology
from flexmech.linkages.topology import LinkEnd
from flexmech.sections.beam_section import BeamSection


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
        name: _held(section)
        if {LinkEnd(name, "start"), LinkEnd(name, "end")} <= joined
        else section
        for name, section in sections.items()
    }


def _held(section: BeamSection) -> BeamSection:
    layers = section.layers
    if layers is None or layers.twist is not None or not layers.twists:
        return section
    if section != _damped_as(section, BeamSection.of_laminate(layers)):
        return section
    held = BeamSection.of_laminate(replace(layers, twist="held"))
    if section.damping_frequency is None or section.specific_damping is None:
        return _damped_as(section, held)
    return held.with_damping_frequency(section.damping_frequency)


def _damped_as(section: BeamSection, other: BeamSection) -> BeamSection:
    frequency = section.damping_frequency
    return replace(other, damping=section.damping, damping_frequency=frequency)
