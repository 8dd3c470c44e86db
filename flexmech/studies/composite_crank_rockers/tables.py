"""Frequencies of the study as a table of all models, and as ratios like Tables 4 to 6."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import table_over
from flexmech.analyses.summary import Row, Table
from flexmech.studies.composite_crank_rockers.claims import all_models
from flexmech.studies.composite_crank_rockers.linkages import SECOND, position_angles
from flexmech.studies.composite_crank_rockers.published import POSITIONS, published_case

# What every column of frequencies is divided by.
ONE = {"laminate": "C1", "case": 1, "position": "min"}
DIMS = ("plies", "beams", "position", "laminate", "case")


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
    angles = np.degrees([position_angles(published_case(case)) for case in study["case"].values])
    study = study.assign(crank_angle_deg=(("case", "position"), angles[:, :-1]))
    second = study.sel(position=["90"])
    second = second.assign(
        frequency=study["other_configuration"],
        crank_angle_deg=("case", angles[:, -1]),
        strain_energy_damping=np.nan * second["strain_energy_damping"],
    ).assign_coords(position=[SECOND])
    return pd.concat([_rows(part, study.sel(ONE)) for part in (study, second)])


def _rows(part: xr.Dataset, one: xr.Dataset) -> pd.DataFrame:
    """Rows of the table; ratios are to the values of one linkage."""
    return table_over(
        *DIMS,
        position=part["position"],
        crank_angle_deg=part["crank_angle_deg"],
        **{name: part[name] for name in ("laminate", "case", "plies", "beams")},
        frequency_Hz=part["frequency"],
        ratio=part["frequency"] / one["frequency"],
        published_finite_element_Hz=part["finite_element"],
        published_finite_element_ratio=part["finite_element"] / one["finite_element"],
        published_measured_Hz=part["measured"],
        published_measured_ratio=part["measured"] / one["measured"],
        strain_energy_damping=part["strain_energy_damping"],
        published_damping=part["damping"],
    )


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
