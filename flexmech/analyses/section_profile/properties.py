"""Properties of cross-sections: names, units and words, and one dataset of them all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from flexmech.sections import BeamSection

__all__ = ["COUPLINGS", "PROPERTIES", "Property", "section_properties"]

COUPLINGS = ("with", "without")
"""A section with its axial-bending coupling, and with that left out."""
_ACTIONS = ("axial", "bending", "shear")


class Property(NamedTuple):
    """A number that is known of a link, and how it is written.

    Parameters
    ----------
    name : str
        Of the variable in datasets.
    suffix : str
        Unit as the name of a CSV column ends with it.
    unit : str
        SI unit.
    words : str
    printed : str
        Unit of the printed number, if it is another one.
    factor : float
        From the SI unit to the printed one.
    """

    name: str
    suffix: str
    unit: str
    words: str
    printed: str = ""
    factor: float = 1.0

    @property
    def column(self) -> str:
        """Name of the CSV column."""
        return f"{self.name}_{self.suffix}" if self.suffix else self.name

    @property
    def label(self) -> str:
        """Words and unit of a printed row."""
        unit = self.printed or self.unit
        return self.words if unit == "1" else f"{self.words} ({unit})"

    def text(self, value: float) -> str:
        """A printed number."""
        return "not known" if np.isnan(value) else f"{value * self.factor:.6g}"


PROPERTIES = (
    Property("in_plane_thickness", "m", "m", "in-plane thickness", "mm", 1e3),
    Property("out_of_plane_width", "m", "m", "out-of-plane width", "mm", 1e3),
    Property("axial_stiffness", "N", "N", "EA"),
    Property("bending_stiffness", "Nm2", "N m^2", "EI about the neutral axis"),
    Property("coupling_stiffness", "Nm", "N m", "coupling B about the pins' axis"),
    Property("neutral_axis", "m", "m", "neutral axis y", "mm", 1e3),
    Property("shear_stiffness", "N", "N", "kGA"),
    Property("shear_correction", "", "1", "shear correction k"),
    Property("membrane_modulus", "Pa", "Pa", "EA / (b h)", "GPa", 1e-9),
    Property("flexural_modulus", "Pa", "Pa", "12 EI / (b h^3)", "GPa", 1e-9),
    Property("density", "kg_m3", "kg/m^3", "density"),
    Property("mass_per_length", "kg_m", "kg/m", "rho A"),
    Property("rotary_inertia", "kg_m", "kg m", "rho I about the mass axis"),
    Property("mass_axis", "m", "m", "mass axis y", "mm", 1e3),
    *(
        Property(f"specific_damping_{a}", "", "1", f"specific damping, {a}", "%", 100.0)
        for a in _ACTIONS
    ),
    *(Property(f"damping_time_{a}", "s", "s", f"damping time, {a}") for a in _ACTIONS),
)


def section_properties(sections: Mapping[str, BeamSection]) -> xr.Dataset:
    """Properties of sections, with their axial-bending coupling and without.

    Parameters
    ----------
    sections : mapping of str to BeamSection
        By the names of their links.

    Returns
    -------
    xarray.Dataset
        Each of :data:`PROPERTIES` over (link, coupling); NaN where it is not known.
    """
    rows = [[_values(section), _values(_uncoupled(section))] for section in sections.values()]
    dataset = xr.Dataset(coords={"link": list(sections), "coupling": list(COUPLINGS)})
    for number, one in enumerate(PROPERTIES):
        values = np.array(rows)[..., number]
        attributes = {"units": one.unit, "long_name": one.words}
        dataset[one.name] = (("link", "coupling"), values, attributes)
    return dataset


def _values(section: BeamSection) -> list[float]:
    """Numbers in the order of the properties."""
    layers, loss = section.layers, section.specific_damping
    height, width = section.in_plane_thickness, np.nan if layers is None else layers.width
    area = width * height
    derived = {
        "out_of_plane_width": width,
        "shear_correction": np.nan,
        "membrane_modulus": section.axial_stiffness / area,
        "flexural_modulus": 12 * section.bending_stiffness / (area * height**2),
        "density": section.mass_per_length / area,
    }
    if layers is not None:
        # Of the section's own kGA, which need not be that of its layers (Cowper's).
        ratio = layers.shear_correction * section.shear_stiffness / layers.shear_stiffness
        derived["shear_correction"] = ratio
    for action in _ACTIONS:
        derived[f"specific_damping_{action}"] = np.nan if loss is None else getattr(loss, action)
        derived[f"damping_time_{action}"] = getattr(section.damping, action)
    # All others are the section's own.
    names = [one.name for one in PROPERTIES]
    return [derived[name] if name in derived else getattr(section, name) for name in names]


def _uncoupled(section: BeamSection) -> BeamSection:
    """The section without its axial-bending coupling, its layers still known."""
    return replace(section.without_coupling(), layers=section.layers)
