"""Tables of first-ply failure in the study of Elamy et al. 2023."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import table_of
from flexmech.analyses.summary import Row, Table
from flexmech.studies.composite_crank_rockers.linkages import LAYERS
from flexmech.studies.composite_crank_rockers.strengths import CRITERION, SECTION_LOADS, SOURCE


def strength_frame(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate first-ply failure: of sections by each load, and of linkages by their speed.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    pandas.DataFrame
        A row for each laminate, way that plies lie, and load of the section or case.
    """
    of_sections = table_of(
        study,
        ("laminate", "layers", "section_load"),
        {
            "laminate": "laminate",
            "layers": "layers",
            "loaded_by": "section_load",
            "nominal_stress_MPa": study["first_ply_stress"] / 1e6,
            "table_2_strength_MPa": study["printed_strength"] / 1e6,
            "first_to_fail": "first_ply",
            "mode_of_failure": "first_ply_mode",
        },
    )
    of_linkages = table_of(
        study,
        ("laminate", "layers", "case"),
        {
            "laminate": "laminate",
            "layers": "layers",
            "case": "case",
            "crank_speed_rad_s": "failure_speed",
            "first_to_fail": "failing_link",
            "mode_of_failure": "failing_mode",
        },
    )
    of_linkages.insert(2, "loaded_by", "inertia")
    return pd.concat([of_sections, of_linkages], ignore_index=True)


def strength_table(study: xr.Dataset) -> Table:
    """First-ply failure of each stacking beside the strength that Table 2 prints.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    Table
    """
    stress = (study["first_ply_stress"] / 1e6).transpose("laminate", "section_load", "layers")
    speed = study["failure_speed"].transpose("laminate", "layers", "case")
    rows: list[Row] = []
    for laminate, printed in zip(
        study["laminate"].values.tolist(), study["printed_strength"].values, strict=True
    ):
        own, turning = stress.sel(laminate=laminate), speed.sel(laminate=laminate)
        cells = [f"{printed / 1e6:.0f}"]
        for load in SECTION_LOADS:
            # Stretched, a section is the same whichever way its plies lie.
            values = own.sel(section_load=load).values
            cells += [f"{value:.0f}" for value in (values if load == "bending" else values[:1])]
        least = turning.min("case")
        cells += [
            f"{float(value):.0f} (case {int(turning['case'][int(cases.argmin())])})"
            for value, cases in zip(least, turning.values, strict=True)
        ]
        rows.append((laminate, *cells))
    first, second = LAYERS
    headings = (
        "laminate",
        "Table 2 (MPa)",
        "tension",
        "compression",
        f"bending, {first}",
        second,
        f"breaks at (rad/s), {first}",
        second,
    )
    return Table(
        "First-ply failure beside the strengths of Table 2",
        headings,
        (tuple(rows),),
        caption=f"nominal stresses in MPa at which a straight ply fails first by {CRITERION}, with "
        f"strengths from elsewhere ({SOURCE}), for comparison only: the paper prints none of its "
        "plies. At the crank speeds the inertia forces of rigid links of the size that is assumed "
        "break the weakest case; vibration is not in them",
    )


def strength_answer(study: xr.Dataset) -> str:
    """Which linkage of the study breaks first, and at which speed.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    str
    """
    speed = study["failure_speed"].transpose("layers", "laminate", "case")
    at = dict(zip(speed.dims, np.unravel_index(speed.values.argmin(), speed.shape), strict=True))
    own = study.isel(at)
    return (
        f"of all linkages case {int(own['case'])} of {own['laminate'].item()}, plies "
        f"{own['layers'].item()}, breaks first as the speed rises, at "
        f"{float(own['failure_speed']):.0f} rad/s by {own['failing_mode'].item()} of its "
        f"{own['failing_link'].item()}, with strengths of plies from elsewhere and the link size "
        "that is assumed"
    )
