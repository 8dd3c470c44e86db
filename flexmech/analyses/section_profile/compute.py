"""Cross-sections of a mechanism's links: properties, and what is inside under unit loads."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.remarks import environment_lines
from flexmech.analyses.requests import environment_of, link_of
from flexmech.analyses.section_profile.properties import COUPLINGS, section_properties
from flexmech.analyses.section_profile.result import DIRECTIONS, QUANTITIES, SectionProfiles
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linear_system import checked_mechanism
from flexmech.mechanism import Mechanism
from flexmech.sections import SHEAR_THEORIES, Layers

# Places in a layer, and about how many in all layers of a link with few.
_FEWEST_PLACES, _SMOOTH = 9, 60
# After the layers of a link with fewer of them.
_PADDING = {"ply": "", "run": 0}
_LOADS = ("axial_force", "bending_moment", "shear_force")


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
    names = checked_mechanism(mechanism).links_with_sections
    chosen = names if link is None else [link_of(link, names)]
    if not chosen:
        raise InputError(
            "links: none has a section, all are rigid; give one of them a section, such as "
            'section = "rectangle"'
        )
    words: list[str] = []
    if environment is not None:
        words = environment_lines(mechanism, environment_of(environment))
        mechanism = mechanism_in_state(mechanism, environment)
    sections = {name: mechanism.sections[name] for name in chosen}
    known = {name: one.layers for name, one in sections.items() if one.layers is not None}
    dataset = section_properties(sections)
    dataset["reduction"] = ("link", [known[n].reduction if n in known else "" for n in chosen])
    dataset["direction_of_layers"] = (
        "link",
        [known[n].direction if n in known else "" for n in chosen],
    )
    if known:
        each = [_through_thickness(layers) for layers in known.values()]
        inside = xr.concat(each, pd.Index(known, name="link"), join="outer", fill_value=_PADDING)
        dataset = dataset.merge(inside, join="left", fill_value=_PADDING)
    attributes = origin(mechanism) | {"environment_lines": "\n".join(words)}
    return SectionProfiles(with_units(dataset, "section_profile").assign_attrs(attributes))


def _through_thickness(layers: Layers) -> xr.Dataset:
    """Strain and stress over (coupling, load, layer, point)."""
    stack = layers.laminate.layers
    place = layers.places(max(_FEWEST_PLACES, 2 * (_SMOOTH // (2 * len(stack))) + 1))
    values = [[_under(layers, load, place, c == "with") for load in _LOADS] for c in COUPLINGS]
    coordinates = [
        ("coupling", list(COUPLINGS)),
        ("load", list(_LOADS)),
        ("quantity", list(QUANTITIES)),
        ("layer", np.arange(1, len(stack) + 1)),
        ("point", np.arange(1, place.shape[1] + 1)),
    ]
    of_plies = ("layer", "direction")
    # Layers are counted together where neighbours have one ply and angle.
    turns = [(one.ply, one.angle) != (other.ply, other.angle) for one, other in pairwise(stack)]
    return (
        xr.DataArray(values, coordinates)
        .to_dataset("quantity")
        .assign(
            place=(("layer", "point"), place),
            layer_thickness=("layer", [layer.thickness for layer in stack]),
            thermal_expansion=(of_plies, [layer.ply.thermal_expansion for layer in stack]),
            moisture_expansion=(of_plies, [layer.ply.moisture_expansion for layer in stack]),
        )
        .assign_coords(
            ply=("layer", [layer.ply.name for layer in stack]),
            angle=("layer", [layer.angle for layer in stack]),
            direction=list(DIRECTIONS),
            run=("layer", np.cumsum([1, *turns])),
        )
    )


def _under(layers: Layers, load: str, place: FloatArray, coupled: bool) -> FloatArray:
    """The quantities (quantity, layer, point) under one unit load."""
    loads = {load: 1.0}
    if load == "axial_force" and coupled:
        # Along the pins' axis the force has this lever about the neutral axis.
        loads["bending_moment"] = layers.neutral_axis
    classical, third = (
        layers.stresses(place, **loads, coupled=coupled, theory=theory) for theory in SHEAR_THEORIES
    )
    return np.array(
        [classical.strain, classical.normal_stress, classical.shear_stress, third.shear_stress]
    )
