"""How much the plies of a link's section swell: in heat, and with the water in their resin."""

from __future__ import annotations

import pandas as pd
import xarray as xr

from flexmech.analyses.summary import Table

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
