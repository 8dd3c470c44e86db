"""A section that is stiffer or softer as a whole."""

from __future__ import annotations

from dataclasses import replace

from flexmech.sections.beam_section import BeamSection
from flexmech.validation import POSITIVE, check_number

# Fields that go with the moduli, and the place that follows from two of them.
_STIFFNESSES = ("axial_stiffness", "bending_stiffness", "shear_stiffness")
_NEUTRAL_AXIS = "neutral_axis"


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
    scaled = {name: factor * getattr(section, name) for name in _STIFFNESSES}
    before = section.layers
    if before is None:
        return replace(section, **scaled)
    layers = tuple(
        replace(layer, ply=layer.ply.stiffened(factor)) for layer in before.laminate.layers
    )
    after = before.resized(replace(before.laminate, layers=layers), 1.0)
    # To the last bit: it tells whose stiffness is that of its layers.
    for name in (*_STIFFNESSES, _NEUTRAL_AXIS):
        if getattr(section, name) == getattr(before, name):
            scaled[name] = getattr(after, name)
    return replace(section, layers=after, **scaled)
