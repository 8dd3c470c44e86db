"""Properties of links and their cross-sections: how each is written, and one dataset of them all.

Their names, units and words are in ``tables.toml``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib import resources
from typing import NamedTuple

import numpy as np
import xarray as xr

from flexmech.analyses.summary import Row
from flexmech.sections import BeamSection
from flexmech.units import from_si

# A section with its axial-bending coupling, and with that left out.
COUPLINGS = ("with", "without")


class Property(NamedTuple):
    """A number that is known of a link, and how it is written.

    Parameters
    ----------
    name : str
        Of the variable in datasets.
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
        """Of the variable: its unit and words."""
        return {"units": self.unit, "long_name": self.words}

    def row(self, values: Iterable[float]) -> Row:
        """Row of a printed table: the words with their unit, and the numbers."""
        unit = self.printed_unit
        words = {"nan": "not known", "inf": "rigid"}
        shown = (f"{from_si(v, unit):.6g}" for v in values)
        numbers = (words.get(each, each) for each in shown)
        return (f"{self.words} ({unit})" if unit else self.words, *numbers)


_FILE = resources.files("flexmech.analyses.section_profile") / "tables.toml"
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
    """What is known of a section, its properties among it."""
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
        # Of the section's own kGA, which need not be that of its layers (Cowper's).
        correction = layers.shear_correction * section.shear_stiffness / layers.shear_stiffness
        known["shear_correction"] = correction
        known["membrane_modulus"] = section.axial_stiffness / area
        known["flexural_modulus"] = 12 * section.bending_stiffness / (area * height**2)
        known["density"] = section.mass_per_length / area
    return known
