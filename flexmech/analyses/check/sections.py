"""Cross-sections of links: properties, and strain and stress inside under unit loads.

Names, units and words of the properties are in ``sections.toml``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib import resources
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.summary import Row
from flexmech.arrays import FloatArray
from flexmech.sections import SHEAR_THEORIES, BeamSection, Layers
from flexmech.units import from_si

# A section with its axial-bending coupling, and with that left out.
COUPLINGS = ("with", "without")


class Property(NamedTuple):
    """A number that is known of a link, and how it is written.

    Parameters
    ----------
    name : str
        Name of the variable in datasets.
    unit : str
        SI unit.
    column : str
        Name of the CSV column.
    words : str
    printed_unit : str
        Empty for a ratio that is printed as it is.
    """

    name: str
    unit: str
    column: str
    words: str
    printed_unit: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the variable: its unit and words."""
        return {"units": self.unit, "long_name": self.words}

    def row(self, values: Iterable[float]) -> Row:
        """Row of a printed table: the words with their unit, and the numbers."""
        unit = self.printed_unit
        words = {"nan": "not known", "inf": "rigid"}
        shown = (f"{from_si(v, unit):.6g}" for v in values)
        numbers = (words.get(each, each) for each in shown)
        return (f"{self.words} ({unit})" if unit else self.words, *numbers)


_FILE = resources.files("flexmech.analyses.check") / "sections.toml"
# What tables of links and their sections say.
STORED = tomllib.loads(_FILE.read_text(encoding="utf-8"))
# What is known of a link beside its section.
LINK_PROPERTIES = tuple(Property(*row) for row in STORED["link"])
# What is known of a section.
PROPERTIES = tuple(Property(*row) for row in STORED["section"])


def section_properties(sections: Mapping[str, BeamSection | None]) -> xr.Dataset:
    """Properties of sections, with their axial-bending coupling and without.

    Parameters
    ----------
    sections : mapping of str to BeamSection
        By the names of their links; None for a rigid link without a section.

    Returns
    -------
    xarray.Dataset
        Each of :data:`PROPERTIES` over (link, coupling); NaN where it is not known.
    """
    pairs = [
        # The layers of the section without coupling are still known.
        (_known(section), _known(replace(section.without_coupling(), layers=section.layers)))
        if section is not None
        else ({}, {})
        for section in sections.values()
    ]
    dataset = xr.Dataset(coords={"link": list(sections), "coupling": list(COUPLINGS)})
    for one in PROPERTIES:
        values = [[known.get(one.name, np.nan) for known in pair] for pair in pairs]
        dataset[one.name] = (("link", "coupling"), values, one.attributes)
    return dataset


def _known(section: BeamSection) -> dict[str, float]:
    """Data of a section, its properties among them."""
    known = vars(section) | {"coupling_stiffness": section.coupling_stiffness}
    for action, time in vars(section.damping).items():
        known[f"damping_time_{action}"] = time
    if section.specific_damping is not None:
        for action, loss in vars(section.specific_damping).items():
            known[f"specific_damping_{action}"] = loss
    if (layers := section.layers) is not None:
        height = section.in_plane_thickness
        area = layers.width * height
        known["out_of_plane_width"] = layers.width
        # For the section's shear stiffness, which need not be that of its layers (Cowper's).
        correction = layers.shear_correction * section.shear_stiffness / layers.shear_stiffness
        known["shear_correction"] = correction
        known["membrane_modulus"] = section.axial_stiffness / area
        known["flexural_modulus"] = 12 * section.bending_stiffness / (area * height**2)
        known["density"] = section.mass_per_length / area
    return known


QUANTITIES = ("strain", "normal_stress", "shear_stress", "third_order_shear_stress")
DIRECTIONS = ("along", "across")
"""Directions against the fibres of a ply."""
# Places in a layer, and about how many in all layers of a link with few.
_FEWEST_PLACES, _SMOOTH = 9, 60
# After the layers of a link with fewer of them.
_PADDING = {"ply": "", "run": 0}
_LOADS = ("axial_force", "bending_moment", "shear_force")


def section_dataset(sections: Mapping[str, BeamSection]) -> xr.Dataset:
    """Properties of sections, and strain and stress through the thickness of those with layers.

    Parameters
    ----------
    sections : mapping of str to BeamSection
        By the names of their links.

    Returns
    -------
    xarray.Dataset
        As of :class:`~flexmech.analyses.section_profile.compute.SectionProfiles`.
    """
    known = {name: one.layers for name, one in sections.items() if one.layers is not None}
    dataset = section_properties(sections)
    for variable, attribute in (("reduction", "reduction"), ("direction_of_layers", "direction")):
        texts = [getattr(known.get(name), attribute, "") for name in sections]
        dataset[variable] = ("link", texts)
    if not known:
        return dataset
    each = [_through_thickness(layers) for layers in known.values()]
    inside = xr.concat(each, pd.Index(known, name="link"), join="outer", fill_value=_PADDING)
    return dataset.merge(inside, join="left", fill_value=_PADDING)


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
