"""Frequencies of the study as a table of all models, and as ratios like Tables 4 to 6."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.summary import Row, Table
from flexmech.studies.composite_crank_rockers.claims import all_models
from flexmech.studies.composite_crank_rockers.linkages import position_angles
from flexmech.studies.composite_crank_rockers.published import published_case

__all__ = ["SECOND", "frequency_table", "ratio_tables"]

# What every column of frequencies is divided by.
ONE = {"laminate": "C1", "case": 1, "position": "min"}
SECOND = "90, second crank angle"
DIMS = ("plies", "beams", "position", "laminate", "case")
POSITIONS = {
    "min": "least transmission angle, crank at 0 deg",
    "90": "transmission angle 90 deg, first of two crank angles",
    "max": "greatest transmission angle, crank at 180 deg",
}


def frequency_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate the study: one row for each model of plies and beams, position and linkage.

    Ratios are to C1, case 1, at the least transmission angle, each column to its own. The
    second crank angle with a right transmission angle stands beside the published values of
    that position too: the paper does not say which one it means. Of it there is no damping.

    Parameters
    ----------
    study : Dataset
        Of :class:`flexmech.studies.CompositeStudy`.

    Returns
    -------
    pandas.DataFrame
    """
    second = study.sel(position=["90"])
    second = second.assign(
        frequency=second["other_posture"].expand_dims("position"),
        strain_energy_damping=np.nan * second["strain_energy_damping"],
    ).assign_coords(position=[SECOND])
    angles = np.degrees([position_angles(published_case(case)) for case in study["case"].values])
    places = {"case": study["case"].values, "position": [*study["position"].values, SECOND]}
    crank_angle = xr.DataArray(angles, places, dims=("case", "position"))
    one = study.sel(ONE, drop=True)
    return pd.concat([_rows(part, crank_angle, one) for part in (study, second)])


def _rows(part: xr.Dataset, crank_angle: xr.DataArray, one: xr.Dataset) -> pd.DataFrame:
    """Rows of the table; ratios are to the values of one linkage."""
    columns = {
        "crank_angle_deg": crank_angle.sel(position=part["position"]),
        "frequency_Hz": part["frequency"],
        "ratio": part["frequency"] / one["frequency"],
    }
    for name in ("finite_element", "measured"):
        columns[f"published_{name}_Hz"] = part[name]
        columns[f"published_{name}_ratio"] = part[name] / one[name]
    columns["strain_energy_damping"] = part["strain_energy_damping"]
    columns["published_damping"] = part["damping"]
    rows = xr.Dataset(columns).to_dataframe(dim_order=list(DIMS)).reset_index()
    order = ("position", "crank_angle_deg", "laminate", "case", "plies", "beams")
    return rows[list(dict.fromkeys((*order, *columns)))]


def ratio_tables(study: xr.Dataset) -> list[Table]:
    """One table a position, as Tables 4 to 6 of the paper, of ratios.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    list of Table
        Computed, published finite-element and measured frequency over those of C1, case 1,
        at the least transmission angle.
    """
    values = (all_models(study)[0], study["finite_element"], study["measured"])
    ratios = xr.concat([each / each.sel(ONE) for each in values], "source")
    headings = ("laminate", *(f"case {case}" for case in study["case"].values))
    caption = "ratios: computed / finite elements / measured"
    return [
        Table(words, headings, (_ratio_rows(ratios.sel(position=position)),), caption=caption)
        for position, words in POSITIONS.items()
    ]


def _ratio_rows(ratios: xr.DataArray) -> tuple[Row, ...]:
    """One row a laminate, from ratios over source, laminate and case."""
    cells = ratios.transpose("laminate", "case", "source").values
    return tuple(
        (str(laminate), *(" / ".join(f"{ratio:.2f}" for ratio in cell) for cell in row))
        for laminate, row in zip(ratios["laminate"].values, cells, strict=True)
    )
