"""A study of composite crank-rockers that found what is published, for tests of its words."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.studies import published_tables
from flexmech.studies.composite_crank_rockers.compute import composite_dataset
from flexmech.studies.composite_crank_rockers.linkages import (
    BEAMS,
    CASES,
    LAMINATES,
    LAYERS,
    PLY_MODELS,
    SECOND,
)
from flexmech.studies.composite_crank_rockers.strengths import SECTION_LOADS


def published_study() -> xr.Dataset:
    """Dataset of a study whose every frequency and damping is the published one.

    Its linkages in motion are invented: what they need rises from C1 to C6, is ten times that with
    steel, and falls from case 1 to case 4.
    """
    tables = published_tables().sel(position=["min", "90", "max", "90"])
    tables = tables.assign_coords(position=["min", "90", "max", SECOND])
    models = tables.expand_dims(plies=list(PLY_MODELS), layers=list(LAYERS), beams=list(BEAMS))
    found = models["finite_element"], models["damping"], tables["finite_element"]
    return composite_dataset(*found, invented_peaks(), invented_failures())


def invented_peaks() -> xr.Dataset:
    """Peaks of linkages in motion, the same by both models of plies."""
    material = xr.DataArray(
        [*np.linspace(1.0, 1.5, 6), 10.0], {"material": [*LAMINATES, "steel"]}, ["material"]
    )
    case = xr.DataArray([4.0, 3.0, 2.0, 1.0], {"case": list(CASES)}, ["case"])
    peaks = (material * case).expand_dims(running_plies=["woven", "table 2"])
    names = ("peak_torque", "peak_power", "peak_joint_force", "peak_deflection")
    return xr.Dataset({name: peaks.copy() for name in names})


def invented_failures() -> xr.Dataset:
    """First-ply failures: half of what Table 2 prints, and speeds that fall from case to case."""
    places = {"layers": list(LAYERS), "laminate": list(LAMINATES)}
    printed = xr.DataArray(
        [1e6 * row["strength"] for row in LAMINATES.values()],
        {"laminate": list(LAMINATES)},
        ["laminate"],
    )
    case = xr.DataArray([400.0, 300.0, 200.0, 100.0], {"case": list(CASES)}, ["case"])
    stress = (printed / 2).expand_dims(section_load=list(SECTION_LOADS), layers=list(LAYERS))
    speed = case.expand_dims(**places)
    return xr.Dataset(
        {
            "first_ply_stress": stress,
            "first_ply_mode": xr.full_like(stress, "fibre tension", dtype=object).astype(str),
            "first_ply": xr.full_like(stress, "C", dtype=object).astype(str),
            "failure_speed": speed,
            "failing_link": xr.full_like(speed, "crank", dtype=object).astype(str),
            "failing_mode": xr.full_like(speed, "fibre compression", dtype=object).astype(str),
        }
    )
