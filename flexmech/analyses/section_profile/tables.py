"""What is said of each link: its section, and strain and stress inside it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.section_profile.properties import COUPLINGS, PROPERTIES
from flexmech.analyses.summary import Table
from flexmech.materials.stacking import stacking_text

__all__ = ["LOADS_IN_WORDS", "layer_tables", "property_table"]

LOADS_IN_WORDS = (
    "unit loads: N = 1 N along the pins' axis (y = 0), M = 1 N m that stretches the side of "
    "lower y, V = 1 N along y; y points to the left of a link when looking from its first "
    "joint along it",
    "what stands without coupling does not balance the loads: it shows what the coupling does, "
    "kGA and damping are those of the section with it",
)
# Heading, quantity and load of a column.
_COLUMNS = (
    ("N: strain", "strain", "axial_force"),
    ("N: stress (Pa)", "normal_stress", "axial_force"),
    ("M: strain", "strain", "bending_moment"),
    ("M: stress (Pa)", "normal_stress", "bending_moment"),
    ("V: shear (Pa)", "shear_stress", "shear_force"),
)
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
    couplings = COUPLINGS if section["neutral_axis"].any() else COUPLINGS[:1]
    rows = []
    for one in PROPERTIES:
        values = [float(section[one.name].sel(coupling=coupling)) for coupling in couplings]
        rows.append((one.label, *map(one.text, values), *_change(*values)))
    two = ("with coupling", "without coupling", "change")
    headings = ("property", *(two if len(couplings) > 1 else ("value",)))
    return Table(f"{section['link'].item()}: {_stack(section)}", headings, (tuple(rows),))


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
    columns = [1e3 * profile["place"].values]
    columns += [profile[name].sel(load=load).values for _, name, load in _COLUMNS]
    largest = [float(np.abs(values).max()) for values in columns]
    # The highest layer stands at the top, as in the link.
    groups = []
    for number in np.unique(profile["run"])[::-1]:
        run = profile["run"].values == number
        first = profile.isel(layer=int(run.argmax()))
        label = stacking_text([(str(first["ply"].item()), _degrees(first["angle"]))])[1:-1]
        # Normal stress is linear and shear stress quadratic in a run of equal layers: its two
        # faces and its middle say it all.
        inside = [values[run].ravel() for values in columns]
        middle = int(np.abs(inside[0] - (inside[0][0] + inside[0][-1]) / 2).argmin())
        rows = [
            ("" if place != middle else label, *map(_number, [v[place] for v in inside], largest))
            for place in (-1, middle, 0)
        ]
        groups.append(tuple(rows))
    headings = ("layer", "y (mm)", *(heading for heading, *_ in _COLUMNS))
    return Table(title, headings, tuple(groups))


def _stack(section: xr.Dataset) -> str:
    """Say in one line what a section is made of, from its lowest y up."""
    known = section.isel(layer=section["run"].values > 0)
    degrees = [_degrees(angle) for angle in known["angle"]]
    stack = list(zip(known["ply"].values.tolist(), degrees, strict=True))
    if not stack:
        return "by its stiffness and mass"
    if stack == [("", 0.0)]:
        return "rectangle of one material"
    reduction = str(section["reduction"].item())
    tail = "" if reduction == "narrow" else f", {reduction}"
    return f"{stacking_text(stack)}, {len(stack)} layers{tail}"


def _degrees(angle: xr.DataArray) -> float:
    return round(float(np.degrees(angle)), 6)


def _number(value: float, largest: float) -> str:
    return f"{0.0 if abs(value) < _ZERO * largest else value:.4g}"


def _change(first: float, *others: float) -> list[str]:
    """Relative changes in percent; nothing where there is none, or from or to zero."""
    ratios = [other / first if first else np.nan for other in others]
    return [
        "" if np.isnan(ratio) or ratio in (0.0, 1.0) else f"{100 * (ratio - 1):+.4g} %"
        for ratio in ratios
    ]
