"""A section that is changed as a whole: by other layers, stiffer, or with its twist held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from flexmech.linkages import Topology
from flexmech.linkages.topology import LinkEnd
from flexmech.sections.beam_section import BeamSection, Layers
from flexmech.sections.laminate_section import LaminateSection
from flexmech.validation import POSITIVE, check_number

# What goes with the layers, and the place that follows from two of these.
_STIFFNESSES = ("axial_stiffness", "bending_stiffness", "shear_stiffness")
_INERTIAS = ("mass_per_length", "rotary_inertia")
_NEUTRAL_AXIS = "neutral_axis"


def with_layers(section: BeamSection, layers: Layers) -> BeamSection:
    """The section with each stiffness and inertia changed as that of its layers.

    Parameters
    ----------
    section : BeamSection
        Whose layers are known, and may be stated to be stiffer or heavier than these make it.
    layers : LaminateSection or SheetSection
        As they have become.

    Returns
    -------
    BeamSection
        With a neutral axis that is stated where it was; all else stays.
    """
    changed: dict[str, float] = {}
    for name in (*_STIFFNESSES, *_INERTIAS, _NEUTRAL_AXIS):
        stated, before, after = (getattr(each, name) for each in (section, section.layers, layers))
        # To the last bit: it tells whose stiffness is that of its layers.
        if stated == before:
            changed[name] = after
        elif name != _NEUTRAL_AXIS:
            changed[name] = stated * (after / before)
    return replace(section, layers=layers, **changed)  # type: ignore[arg-type]


def stiffened_section(section: BeamSection, factor: float) -> BeamSection:
    """The same section with every stiffness times a factor.

    All moduli of its layers are, and with them A, B, D and the shear stiffnesses of a laminate, the
    warping of its cross-section, and what joints restrain of its twist. Mass, damping, free strain
    and free curvature stay.

    Parameters
    ----------
    section : BeamSection
    factor : float

    Returns
    -------
    BeamSection

    Raises
    ------
    InputError
        If the factor is not positive.

    Examples
    --------
    >>> coupler = flexmech.load_mechanism("models/composite_fourbar.toml").sections["coupler"]
    >>> stiffer = flexmech.sections.stiffened_section(coupler, 1.1)
    >>> round(stiffer.layers.bending_stiffness / coupler.bending_stiffness, 12)
    1.1
    """
    check_number(factor, "factor of a stiffness", "", POSITIVE)
    before = section.layers
    if before is None:
        scaled = {name: factor * getattr(section, name) for name in _STIFFNESSES}
        return replace(section, **scaled)
    layers = tuple(
        replace(layer, ply=layer.ply.stiffened(factor)) for layer in before.laminate.layers
    )
    return with_layers(section, before.resized(replace(before.laminate, layers=layers), 1.0))


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
