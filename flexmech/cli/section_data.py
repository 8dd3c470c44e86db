"""Numbers of ``flexmech section``: of a section, and inside it under unit loads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.materials import Laminate, Layer
from flexmech.sections import BeamSection, LaminateSection
from flexmech.types import FloatArray

__all__ = [
    "in_runs",
    "profile_frame",
    "section_frame",
    "section_values",
    "uncoupled",
    "unit_load_profile",
]


# Places in a layer, and about how many in all layers of a link with few.
FEWEST_PLACES, SMOOTH = 9, 60
LOADS = ("axial_force", "bending_moment", "shear_force")
COUPLINGS = ("with", "without")
UNITS = {
    "place": ("m", "place y from the pins' axis"),
    "strain": ("1", "strain along the link under a unit load"),
    "normal_stress": ("Pa", "stress along the link under a unit load"),
    "shear_stress": ("Pa", "shear stress under a unit load, by equilibrium"),
    "third_order_shear_stress": ("Pa", "shear stress under a unit load, third-order theory"),
    "neutral_axis": ("m", "place y of the neutral axis"),
    "mass_axis": ("m", "place y of the centre of mass"),
    "angle": ("rad", "angle of the fibres against the link's axis"),
}


def section_values(section: BeamSection) -> dict[str, float | None]:
    """Everything that is known of a section, by name and SI unit.

    Parameters
    ----------
    section : BeamSection

    Returns
    -------
    dict of str to float or None
        None where it is not known.
    """
    layers, loss = section.layers, section.specific_damping
    height, width = section.in_plane_thickness, None if layers is None else layers.width
    area = None if width is None else width * height
    known = {
        "in_plane_thickness_m": height,
        "out_of_plane_width_m": width,
        "axial_stiffness_N": section.axial_stiffness,
        "bending_stiffness_Nm2": section.bending_stiffness,
        "coupling_stiffness_Nm": section.coupling_stiffness,
        "neutral_axis_m": section.neutral_axis,
        "shear_stiffness_N": section.shear_stiffness,
        "shear_correction": None if layers is None else _shear_correction(section, layers),
        "membrane_modulus_Pa": area and section.axial_stiffness / area,
        "flexural_modulus_Pa": area and 12 * section.bending_stiffness / (area * height**2),
        "density_kg_m3": area and section.mass_per_length / area,
        "mass_per_length_kg_m": section.mass_per_length,
        "rotary_inertia_kg_m": section.rotary_inertia,
        "mass_axis_m": section.mass_axis,
    }
    for name in ("axial", "bending", "shear"):
        known[f"specific_damping_{name}"] = None if loss is None else getattr(loss, name)
    for name in ("axial", "bending", "shear"):
        known[f"damping_time_{name}_s"] = getattr(section.damping, name)
    return known


def section_frame(sections: Mapping[str, BeamSection]) -> pd.DataFrame:
    """Tabulate sections, with their axial-bending coupling and without: two rows a link.

    Parameters
    ----------
    sections : mapping
        By the names of their links.

    Returns
    -------
    pandas.DataFrame
    """
    rows = []
    for link, section in sections.items():
        for coupling, shown in zip(COUPLINGS, (section, uncoupled(section)), strict=True):
            rows.append({"link": link, "coupling": coupling, **section_values(shown)})
    return pd.DataFrame(rows)


def uncoupled(section: BeamSection) -> BeamSection:
    """The section without its axial-bending coupling, its layers still known."""
    return replace(section.without_coupling(), layers=section.layers)


def unit_load_profile(
    link: str, section: BeamSection, layers: LaminateSection, per_layer: int | None = None
) -> xr.Dataset:
    """Strain and stress through the thickness under an axial force, a moment, a shear force.

    The loads are 1 N along the pins' axis (not the neutral axis: with coupling it bends the
    link), 1 N m that stretches the side of lower y, and 1 N along y on the face towards
    higher x.

    Parameters
    ----------
    link : str
        Name for titles and tables.
    section : BeamSection
    layers : LaminateSection
        What it is made of.
    per_layer : int, optional
        Places in each layer, its faces included; by default enough for smooth curves.

    Returns
    -------
    xarray.Dataset
        Over (coupling, load, layer, point), with place, ply and angle of the layers.
    """
    stack = layers.laminate.layers
    if per_layer is None:
        per_layer = max(FEWEST_PLACES, 2 * (SMOOTH // (2 * len(stack))) + 1)
    place = layers.places(per_layer)
    found = [
        [_under(layers, load, place, coupled=coupling == "with") for load in LOADS]
        for coupling in COUPLINGS
    ]
    dims = ("coupling", "load", "layer", "point")
    data: dict[str, Any] = {
        name: (dims, np.array([[values[name] for values in row] for row in found]))
        for name in ("strain", "normal_stress", "shear_stress", "third_order_shear_stress")
    }
    dataset = xr.Dataset(
        {
            "place": (("layer", "point"), place),
            **data,
            "neutral_axis": ((), section.neutral_axis),
            "mass_axis": ((), section.mass_axis),
        },
        coords={
            "coupling": list(COUPLINGS),
            "load": list(LOADS),
            "layer": np.arange(1, len(stack) + 1),
            "ply": ("layer", [layer.ply.name for layer in stack]),
            "angle": ("layer", [layer.angle for layer in stack]),
        },
        attrs={"link": link},
    )
    for name, (unit, long_name) in UNITS.items():
        dataset[name].attrs = {"units": unit, "long_name": long_name}
    return dataset


def profile_frame(profiles: Iterable[xr.Dataset]) -> pd.DataFrame:
    """Tabulate profiles: one row for each link, load, coupling and place.

    Parameters
    ----------
    profiles : iterable of xarray.Dataset
        One or more of :func:`unit_load_profile`.

    Returns
    -------
    pandas.DataFrame
    """
    order = ["load", "coupling", "layer", "point"]
    frames = []
    for profile in profiles:
        frame = profile.drop_vars(["neutral_axis", "mass_axis"]).to_dataframe(dim_order=order)
        frame = frame.reset_index()
        frame.insert(0, "link", profile.attrs["link"])
        frame["angle"] = np.round(np.degrees(frame["angle"]), 9)
        frames.append(frame)
    columns = {
        "link": "link",
        "load": "load",
        "coupling": "coupling",
        "layer": "layer",
        "ply": "ply",
        "angle": "angle_deg",
        "place": "y_m",
        "strain": "strain",
        "normal_stress": "normal_stress_Pa",
        "shear_stress": "shear_stress_Pa",
        "third_order_shear_stress": "third_order_shear_stress_Pa",
    }
    return pd.concat(frames)[list(columns)].rename(columns=columns)


def in_runs(layers: LaminateSection) -> LaminateSection:
    """The same section, neighbouring layers of one ply and angle taken as one."""
    runs = groupby(layers.laminate.layers, key=lambda layer: (layer.ply, layer.angle))
    merged = (
        Layer(ply, sum(layer.thickness for layer in run), angle) for (ply, angle), run in runs
    )
    return replace(layers, laminate=Laminate(tuple(merged)))


def _shear_correction(section: BeamSection, layers: LaminateSection) -> float:
    """Factor of the section's own kGA, which need not be that of its layers (Cowper's)."""
    return layers.shear_correction * section.shear_stiffness / layers.shear_stiffness


def _under(
    layers: LaminateSection, load: str, place: FloatArray, *, coupled: bool
) -> dict[str, FloatArray]:
    """Strain and stresses (layer, point) under one unit load."""
    # Along the pins' axis a force has this lever about the neutral axis.
    lever = layers.neutral_axis if coupled else 0.0
    force, moment, shear = {
        "axial_force": (1.0, lever, 0.0),
        "bending_moment": (0.0, 1.0, 0.0),
        "shear_force": (0.0, 0.0, 1.0),
    }[load]
    classical = layers.stresses(place, force, moment, shear, coupled=coupled)
    third = layers.stresses(place, force, moment, shear, coupled=coupled, theory="third-order")
    return {
        "strain": classical.strain,
        "normal_stress": classical.normal_stress,
        "shear_stress": classical.shear_stress,
        "third_order_shear_stress": third.shear_stress,
    }
