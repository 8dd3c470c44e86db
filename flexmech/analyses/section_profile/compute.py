"""Cross-sections of a mechanism's links: properties, and what is inside under unit loads."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.environment import environment_lines
from flexmech.analyses.provenance import origin, with_units
from flexmech.analyses.requests import environment_of, link_of
from flexmech.analyses.section_profile.properties import COUPLINGS, section_properties
from flexmech.analyses.section_profile.result import QUANTITIES, SectionProfiles
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linear_system import checked_mechanism
from flexmech.mechanism import Mechanism
from flexmech.sections import LaminateSection
from flexmech.types import FloatArray

__all__ = ["section_profiles"]

# Places in a layer, and about how many in all layers of a link with few.
FEWEST_PLACES, SMOOTH = 9, 60
# Axial force, bending moment and shear force, each 1 alone.
LOADS = {
    "axial_force": (1.0, 0.0, 0.0),
    "bending_moment": (0.0, 1.0, 0.0),
    "shear_force": (0.0, 0.0, 1.0),
}


def section_profiles(
    mechanism: Mechanism, link: str | None = None, *, environment: Environment | None = None
) -> SectionProfiles:
    """Properties of the links' sections, and strain and stress in them under unit loads.

    The loads are 1 N along the pins' axis (not the neutral axis: with coupling it bends the
    link), 1 N m that stretches the side of lower y, and 1 N along y on the face towards
    higher x.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    link : str, optional
        This link alone, such as ``"coupler"``; all of them by default.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the sections are in.

    Returns
    -------
    SectionProfiles

    Raises
    ------
    InputError
        If there is no such link, or as :func:`flexmech.mechanism_in_state`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/composite_fourbar.toml")
    >>> sections = flexmech.section_profiles(mechanism, "coupler").dataset
    >>> sections["bending_stiffness"].values.round(2)
    array([[62.13, 89.8 ]])
    """
    names = checked_mechanism(mechanism).linkage.topology.link_names
    chosen = names if link is None else [link_of(link, names)]
    words: list[str] = []
    if environment is not None:
        words = environment_lines(mechanism, environment_of(environment))
        mechanism = mechanism_in_state(mechanism, environment)
    sections = {name: mechanism.sections[name] for name in chosen}
    layers = [section.layers for section in sections.values()]
    inside = xr.concat(
        [_through_thickness(one) for one in layers],
        pd.Index(chosen, name="link"),
        join="outer",
        fill_value={"ply": "", "run": 0},
    )
    dataset = section_properties(sections).merge(with_units(inside, "section_profile"))
    dataset.coords["reduction"] = ("link", [one.reduction if one else "" for one in layers])
    return SectionProfiles(
        dataset.assign_attrs(origin(mechanism), environment_lines="\n".join(words))
    )


def _through_thickness(layers: LaminateSection | None) -> xr.Dataset:
    """Strain and stress over (coupling, load, layer, point); of size zero without layers."""
    stack = () if layers is None else layers.laminate.layers
    place, values = np.empty((0, 0)), np.empty((len(COUPLINGS), len(LOADS), len(QUANTITIES), 0, 0))
    if layers is not None:
        place = layers.places(max(FEWEST_PLACES, 2 * (SMOOTH // (2 * len(stack))) + 1))
        values = np.array(
            [[_under(layers, load, place, c == "with") for load in LOADS] for c in COUPLINGS]
        )
    # Layers are counted together where neighbours have one ply and angle.
    turns = [(one.ply, one.angle) != (other.ply, other.angle) for one, other in pairwise(stack)]
    dims = ("coupling", "load", "layer", "point")
    return xr.Dataset(
        {
            "place": (dims[2:], place),
            **{name: (dims, values[:, :, number]) for number, name in enumerate(QUANTITIES)},
        },
        coords={
            "coupling": list(COUPLINGS),
            "load": list(LOADS),
            "layer": np.arange(1, len(stack) + 1),
            "point": np.arange(1, place.shape[1] + 1),
            "ply": ("layer", np.array([layer.ply.name for layer in stack], dtype=str)),
            "angle": ("layer", [layer.angle for layer in stack]),
            "run": ("layer", np.cumsum([1, *turns])[: len(stack)]),
        },
    )


def _under(layers: LaminateSection, load: str, place: FloatArray, coupled: bool) -> FloatArray:
    """The quantities (quantity, layer, point) under one unit load."""
    force, moment, shear = LOADS[load]
    # Along the pins' axis a force has this lever about the neutral axis.
    moment += force * layers.neutral_axis * coupled
    classical = layers.stresses(place, force, moment, shear, coupled=coupled)
    third = layers.stresses(place, force, moment, shear, coupled=coupled, theory="third-order")
    return np.array(
        [classical.strain, classical.normal_stress, classical.shear_stress, third.shear_stress]
    )
