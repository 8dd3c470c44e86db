"""What is said of each link: its section, and strain and stress inside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.section_profile.properties import COUPLINGS, PROPERTIES, STORED
from flexmech.analyses.summary import Table
from flexmech.materials.stacking import stacking_text
from flexmech.types import FloatArray

STRAIN = ((1e-6, "1e-6"),)
STRESSES = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))
# What rounding leaves of a zero, over the largest value of its column.
_ZERO = 1e-9


def property_table(section: xr.Dataset) -> Table:
    """Tabulate a section, and beside it without its axial-bending coupling if it has any.

    Parameters
    ----------
    section : xarray.Dataset
        Of one link.

    Returns
    -------
    Table
    """
    title = f"{section['link'].item()}: {_composition(section)}"
    if not section["neutral_axis"].any():
        alone = section.sel(coupling=["with"])
        rows = tuple(one.row(alone[one.name].values) for one in PROPERTIES)
        return Table(title, ("property", "value"), (rows,))
    values = [(one, section[one.name].values) for one in PROPERTIES]
    rows = tuple((*one.row(both), _change(*both)) for one, both in values)
    return Table(title, ("property", "with coupling", "without coupling", "change"), (rows,))


def layer_tables(profile: xr.Dataset) -> list[Table]:
    """Tabulate strain and stress under unit loads, with and without coupling if there is any.

    Parameters
    ----------
    profile : xarray.Dataset
        Of one link whose layers are known.

    Returns
    -------
    list of Table
    """
    title = f"{profile['link'].item()} under unit loads"
    if not profile["neutral_axis"]:
        return [_layer_table(profile.sel(coupling="with"), title)]
    return [_layer_table(profile.sel(coupling=c), f"{title}, {c} coupling") for c in COUPLINGS]


def _layer_table(profile: xr.Dataset, title: str) -> Table:
    headings, columns = ["layer", "y (mm)"], [_without_noise(1e3 * profile["place"].values)]
    for heading, name, load in STORED["inside"]:
        values = _without_noise(profile[name].sel(load=load).values)
        factor, unit = _readable_unit(values, STRAIN if name == "strain" else STRESSES)
        headings.append(f"{heading} ({unit})")
        columns.append(values / factor)
    stack, runs = _stack(profile), profile["run"].values
    groups = []
    # The highest layer stands at the top, as in the link.
    for run in np.unique(runs)[::-1]:
        ply, angle = stack[(runs == run).argmax()]
        label = stacking_text([(ply, angle)])[1:-1] if ply else "one material"
        # Normal stress is linear and shear stress quadratic in a run of equal layers: its two
        # faces and its middle say it all.
        inside = np.array([values[runs == run].ravel() for values in columns])
        middle = np.abs(inside[0] - inside[0, [0, -1]].mean()).argmin()
        cells = inside[:, [-1, middle, 0]].T
        groups.append(
            tuple(
                (word, *(f"{value:.4g}" for value in row))
                for word, row in zip(("", label, ""), cells, strict=True)
            )
        )
    return Table(title, tuple(headings), tuple(groups))


def _readable_unit(values: FloatArray, units: Sequence[tuple[float, str]]) -> tuple[float, str]:
    """The greatest unit in which the largest value is one at least, or the least of them."""
    largest = np.abs(values).max()
    return next(((factor, name) for factor, name in units if largest >= factor), units[-1])


def _without_noise(values: FloatArray) -> FloatArray:
    return np.where(np.abs(values) < _ZERO * np.abs(values).max(), 0.0, values)


def _composition(section: xr.Dataset) -> str:
    """Say in one line what a section is made of, from its lowest y up."""
    reduction = section["reduction"].item()
    if not reduction:
        return "by its stiffness and mass"
    stack = _stack(section.isel(layer=section["run"].values > 0))
    if stack == [("", 0.0)]:
        return "rectangle of one material"
    tail = "" if reduction == "narrow" else f", {reduction}"
    return f"{stacking_text(stack)}, {len(stack)} layers{tail}"


def _stack(section: xr.Dataset) -> list[tuple[str, float]]:
    """Ply and angle in degrees of each layer."""
    degrees = np.round(np.degrees(section["angle"].values), 6)
    return list(zip(section["ply"].values.tolist(), degrees.tolist(), strict=True))


def _change(first: float, other: float) -> str:
    """Relative change in percent; nothing where there is none, or from or to zero."""
    ratio = other / first if first else np.nan
    return "" if np.isnan(ratio) or ratio in (0.0, 1.0) else f"{100 * (ratio - 1):+.4g} %"


DIRECTIONS = ("along", "across")
"""Of the fibres of a ply."""
# Printed in the units in which tables of resins have them.
MICROSTRAIN, MILLISTRAIN = 1e6, 1e3
CAPTION = (
    "free strain along and across the fibres; % is mass of water over the dry mass of the resin "
    "(Schapery; Singh & Sanyal 2022, eqs. 7 and 8, corrected)"
)


def expansions_of_plies(profile: xr.Dataset) -> pd.DataFrame:
    """Expansion coefficients of the different plies of one link.

    Parameters
    ----------
    profile : xarray.Dataset
        Of one link whose layers are known, with ``thermal_expansion`` in 1/K and
        ``moisture_expansion`` per unit of moisture over (layer, direction).

    Returns
    -------
    pandas.DataFrame
        One row a ply, none if nothing is stated of any; per K and per percent of moisture.
    """
    heat, water = profile["thermal_expansion"], profile["moisture_expansion"]
    columns = {"ply": profile["ply"].values}
    columns |= {
        f"thermal_expansion_{name}_per_K": heat.sel(direction=name).values for name in DIRECTIONS
    }
    columns |= {
        f"moisture_expansion_{name}_per_percent": water.sel(direction=name).values / 100
        for name in DIRECTIONS
    }
    rows = pd.DataFrame(columns).drop_duplicates(ignore_index=True)
    return rows if rows.drop(columns="ply").to_numpy().any() else rows[:0]


def expansion_table(profile: xr.Dataset) -> list[Table]:
    """Tabulate the expansion of a link's plies; no table where nothing is stated of any.

    Parameters
    ----------
    profile : xarray.Dataset
        As of :func:`expansions_of_plies`.

    Returns
    -------
    list of Table
    """
    rows = expansions_of_plies(profile)
    if rows.empty:
        return []
    headings = (
        "ply",
        *(f"heat, {name} (1e-6/K)" for name in DIRECTIONS),
        *(f"water, {name} (1e-3/%)" for name in DIRECTIONS),
    )
    cells = tuple(
        (
            str(ply) or "one material",
            *(f"{MICROSTRAIN * value:.5g}" for value in values[:2]),
            *(f"{MILLISTRAIN * value:.5g}" for value in values[2:]),
        )
        for ply, *values in rows.itertuples(index=False)
    )
    title = f"{profile['link'].item()}: swelling of its plies"
    return [Table(title, headings, (cells,), caption=CAPTION)]
