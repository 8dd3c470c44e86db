"""Tables of the study of Elamy et al. 2023."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.datasets import table_of
from flexmech.analyses.summary import Row, Table
from flexmech.studies.composite_crank_rockers.claims import all_models
from flexmech.studies.composite_crank_rockers.linkages import (
    CONVERGED,
    LAYERS,
    POSITIONS,
    SECOND,
    SUPPORTS,
    THIRD_ORDER,
    each_model,
    position_angles,
    published_case,
)
from flexmech.studies.composite_crank_rockers.properties import factor_uncertainty, spread_of
from flexmech.studies.composite_crank_rockers.running import CRANK_SPEED, STEEL
from flexmech.studies.composite_crank_rockers.running_claims import PEAKS

# What every column of frequencies is divided by.
_ONE = {"laminate": "C1", "case": 1, "position": "min"}
_DIMS = ("plies", "layers", "beams", "position", "laminate", "case")
_RATIOS = {name: f"{name}_ratio" for name in ("frequency", "finite_element", "measured")}
# Columns of the table, and their variables.
_COLUMNS = {
    "position": "position",
    "crank_angle_deg": "position_angle",
    **{name: name for name in ("laminate", "case", "plies", "layers", "beams")},
    "supports": "supports",
    "frequency_Hz": "frequency",
    "ratio": "frequency_ratio",
    "ratio_uncertainty": "ratio_uncertainty",
    "published_finite_element_Hz": "finite_element",
    "published_finite_element_ratio": "finite_element_ratio",
    "published_measured_Hz": "measured",
    "published_measured_ratio": "measured_ratio",
    "strain_energy_damping": "strain_energy_damping",
    "published_damping": "damping",
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
    angles = np.array([position_angles(published_case(case)) for case in study["case"].values])
    study = study.assign(position_angle=(("case", "position"), angles[:, :-1]))
    first = {"plies": [each_model()[0][0]], "layers": [each_model()[0][1]], "beams": [CONVERGED]}
    rigid = study.sel(first)
    rigid = rigid.assign(
        frequency=study["rigid_joints_frequency"].expand_dims(first),
        other_configuration=study["rigid_joints_other_configuration"].expand_dims(first),
        strain_energy_damping=np.nan * rigid["strain_energy_damping"],
    )
    hinged, welded, *_ = SUPPORTS
    frame = pd.concat([_frequency_rows(study, hinged), _frequency_rows(rigid, welded)])
    # One material a laminate lies no way: it comes once.
    return frame[(frame["plies"] != "table 2") | (frame["layers"] == next(iter(LAYERS)))]


def _frequency_rows(study: xr.Dataset, supports: str) -> pd.DataFrame:
    """Rows of linkages with these supports, at the positions compared and the second one."""
    # Known of the plies that follow from Table 1, in beams that only bend.
    relative = factor_uncertainty(study).rename(mixed_plies="plies")
    relative = relative.reindex(plies=study["plies"], layers=study["layers"])
    bent = study["beams"] != THIRD_ORDER
    study = study.assign(supports=supports, ratio_uncertainty=relative.where(bent))
    second = study.sel(position=["90"])
    angles = [position_angles(published_case(case))[-1] for case in study["case"].values]
    second = second.assign(
        frequency=study["other_configuration"],
        position_angle=("case", angles),
        strain_energy_damping=np.nan * second["strain_energy_damping"],
    ).assign_coords(position=[SECOND])
    one = study.sel(_ONE)
    ratios = [part[list(_RATIOS)] / one[list(_RATIOS)] for part in (study, second)]

    def uncertain(ratio: xr.Dataset, part: xr.Dataset) -> xr.Dataset:
        spread = ratio["frequency_ratio"] * part["ratio_uncertainty"]
        return ratio.assign(ratio_uncertainty=spread)

    return pd.concat(
        [
            table_of(part.assign(uncertain(ratio.rename(_RATIOS), part)), _DIMS, _COLUMNS)
            for part, ratio in zip((study, second), ratios, strict=True)
        ]
    )


def property_frame(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate the laminates: by Table 1, with the uncertainties that it gives, and Table 2.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    pandas.DataFrame
        A row for each laminate, plies and way that they lie.
    """
    units = {"modulus": ("GPa", 1e9), "poisson_ratio": ("", 1.0), "density": ("kg_m3", 1.0)}
    columns: dict[str, str | xr.DataArray] = {
        "laminate": "laminate",
        "plies": "mixed_plies",
        "layers": "layers",
    }
    for name, (unit, size) in units.items():
        named = f"{name}_{unit}".rstrip("_")
        columns[named] = study[name] / size
        columns[f"{named}_uncertainty"] = spread_of(study[f"{name}_change"]) / size
        columns[f"table_2_{named}"] = study[f"printed_{name}"] / size
    columns["table_2_strength_MPa"] = study["printed_strength"] / 1e6
    return table_of(study, ("laminate", "mixed_plies", "layers"), columns)


def running_frame(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate the greatest values over a turn of the linkages in motion.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    pandas.DataFrame
        A row for each case, material and model of plies; steel comes with each of them.
    """
    columns: dict[str, str | xr.DataArray] = {
        "case": "case",
        "material": "material",
        "plies": "running_plies",
    }
    columns["crank_speed_rad_s"] = xr.DataArray(CRANK_SPEED)
    for name, (size, unit, *_) in PEAKS.items():
        columns[f"{name}_{unit.replace(' ', '_')}"] = size * study[name]
    return table_of(study, ("running_plies", "case", "material"), columns)


def property_table(study: xr.Dataset) -> Table:
    """Properties of the laminates as Table 2 prints them and as they follow from Table 1.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    Table
    """
    straight = study.sel(mixed_plies="unidirectional")
    woven = study.sel(mixed_plies="woven", layers=next(iter(LAYERS)))
    own = straight.sel(layers=next(iter(LAYERS)))

    def pair(name: str, which: xr.Dataset, unit: float, decimals: int) -> list[str]:
        spread = spread_of(which[f"{name}_change"]) / unit
        both = zip((which[name] / unit).values, spread.values, strict=True)
        return [
            f"{value:.{decimals}f} \N{PLUS-MINUS SIGN} {error:.{decimals}f}"
            for value, error in both
        ]

    columns = (
        study["laminate"].values.tolist(),
        [f"{value / 1e9:.2f}" for value in study["printed_modulus"].values],
        pair("modulus", own, 1e9, 1),
        pair("modulus", straight.sel(layers="through thickness"), 1e9, 1),
        pair("modulus", woven, 1e9, 1),
        [f"{value:.2f}" for value in study["printed_poisson_ratio"].values],
        pair("poisson_ratio", own, 1.0, 3),
        [f"{value:.0f}" for value in study["printed_density"].values],
        pair("density", own, 1.0, 0),
        [f"{value / 1e6:.2f}" for value in study["printed_strength"].values],
    )
    headings = (
        "laminate",
        "E printed (GPa)",
        "straight plies in the plane",
        "stacked",
        "woven in the plane",
        "nu printed",
        "computed",
        "density printed (kg/m^3)",
        "computed",
        "strength printed (MPa)",
    )
    return Table(
        "Table 2 beside the rule of mixtures",
        headings,
        (tuple(zip(*columns, strict=True)),),
        caption="moduli in bending in the plane of motion, with the uncertainties of Table 1; "
        "no strength of fibre or resin is printed, so that none follows from Table 1",
    )


def running_table(study: xr.Dataset) -> Table:
    """Peaks of the linkages in motion, beside those with links of steel.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    Table
    """
    first = study.isel(running_plies=0)
    rows = []
    for name, (size, unit, *_) in PEAKS.items():
        values = size * first[name].transpose("case", "material").values
        heading = name.replace("_", " ")
        for case, own in zip(study["case"].values, values, strict=True):
            rows.append((f"{heading} ({unit})", f"case {case}", *(f"{v:.3f}" for v in own)))
    return Table(
        f"At {CRANK_SPEED:g} rad/s",
        ("greatest", "", *map(str, study["material"].values)),
        tuple(
            tuple(rows[n : n + study.sizes["case"]])
            for n in range(0, len(rows), study.sizes["case"])
        ),
        text_columns=2,
        caption="woven plies parallel to the plane of motion; steel of the same size with "
        f"{STEEL.youngs_modulus / 1e9:g} GPa and {STEEL.density:g} kg/m^3; speed, size and steel "
        "are assumed",
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
    ratios = xr.concat([each / each.sel(_ONE) for each in values], "source")
    headings = ("laminate", *(f"case {case}" for case in study["case"].values))
    relative = factor_uncertainty(study).isel(mixed_plies=0, layers=0)
    known = ", ".join(f"{100 * float(each):.1f}" for each in relative[1:])
    caption = (
        "ratios: computed / finite elements / measured; by Table 1 the computed ones are uncertain "
        f"by {known} % (C2 to C6)"
    )
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
