"""Tables of the campaign of Elamy et al. 2023: those of its files, and those that are printed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import xarray as xr
from elamy_claims import PEAKS
from elamy_linkages import CASES, FLAT, LAYERS, POSITIONS, SECOND, position_angles, published_case
from elamy_study import (
    CONVERGED,
    CRANK_SPEED,
    CRITERION,
    SOURCE,
    STEEL,
    THIRD_ORDER,
    factor_uncertainty,
    spread_of,
)

SUPPORTS = {
    "clamped crank": "",
    "rigid joints": "rigid_joints_",
    "pinned crank, rigid joints": "literal_frame_",
}
# What every column of frequencies is divided by.
_ONE = {"laminate": "C1", "case": 1, "position": "min"}
_STRAIGHT = {"plies": "unidirectional", "layers": FLAT}
_EVERYWHERE = [*POSITIONS, SECOND]


def frequency_table(study: xr.Dataset) -> pd.DataFrame:
    """A row for each model of plies and beams, supports, position and linkage.

    Ratios are to C1, case 1, at the least transmission angle, each column to its own. The second
    crank angle with a right transmission angle stands beside the published values of that
    position too: the paper does not say which one it means. Of it there is no damping.
    """
    # Known of the plies that follow from Table 1, in beams that only bend.
    relative = factor_uncertainty(study).rename(mixed_plies="plies")
    relative = relative.reindex(plies=study["plies"]).where(study["beams"] != THIRD_ORDER)
    first = study[["plies", "layers", "beams"]].isel(plies=[0], layers=[0]).sel(beams=[CONVERGED])
    published = study[["finite_element", "measured", "damping"]]
    published = published.sel(position=[*POSITIONS, "90"]).assign_coords(position=_EVERYWHERE)
    angle = xr.DataArray(
        np.degrees([position_angles(published_case(case)) for case in CASES]),
        {"case": list(CASES), "position": _EVERYWHERE},
    )
    frames = []
    for supports, kind in SUPPORTS.items():
        other = study[f"{kind}other_configuration"].expand_dims(position=[SECOND])
        frequency = xr.concat([study[f"{kind}frequency"], other], "position")
        damping = study["strain_energy_damping"].reindex(position=_EVERYWHERE)
        if kind:
            frequency = frequency.expand_dims({dim: first[dim] for dim in first.dims})
            damping = frequency * np.nan
        ratio = frequency / frequency.sel(_ONE)
        columns = {
            "crank_angle_deg": angle,
            "supports": xr.DataArray(supports),
            "frequency_Hz": frequency,
            "ratio": ratio,
            "ratio_uncertainty": ratio * relative,
        }
        for name in ("finite_element", "measured"):
            columns[f"published_{name}_Hz"] = published[name]
            columns[f"published_{name}_ratio"] = published[name] / published[name].sel(_ONE)
        columns |= {"strain_energy_damping": damping, "published_damping": published["damping"]}
        rows = _rows(columns, "plies", "layers", "beams", "position", "laminate", "case")
        # The second crank angle comes last.
        frames += [rows[rows["position"] != SECOND], rows[rows["position"] == SECOND]]
    frame = pd.concat(frames, ignore_index=True)
    # One material a laminate lies no way: it comes once.
    return frame[(frame["plies"] != "table 2") | (frame["layers"] == FLAT)]


def property_table(study: xr.Dataset) -> pd.DataFrame:
    """The laminates: by Table 1, with the uncertainties that it gives, and Table 2."""
    columns = {}
    units = {"modulus": ("GPa", 1e9), "poisson_ratio": ("", 1.0), "density": ("kg_m3", 1.0)}
    for name, (unit, size) in units.items():
        heading = f"{name}_{unit}".rstrip("_")
        columns[heading] = study[name] / size
        columns[f"{heading}_uncertainty"] = spread_of(study[f"{name}_change"]) / size
        columns[f"table_2_{heading}"] = study[f"printed_{name}"] / size
    columns["table_2_strength_MPa"] = study["printed_strength"] / 1e6
    rows = _rows(columns, "laminate", "mixed_plies", "layers")
    return rows.rename(columns={"mixed_plies": "plies"})


def running_table(study: xr.Dataset) -> pd.DataFrame:
    """Greatest values over a turn of the linkages in motion; steel comes with each of the plies."""
    columns = {"crank_speed_rad_s": xr.DataArray(CRANK_SPEED)}
    for name, (size, unit, *_) in PEAKS.items():
        columns[f"{name}_{unit.replace(' ', '_')}"] = size * study[name]
    rows = _rows(columns, "running_plies", "case", "material")
    return rows.rename(columns={"running_plies": "plies"})


def strength_table(study: xr.Dataset) -> pd.DataFrame:
    """First-ply failure: of sections by each load, and of linkages by their speed."""
    sections = {
        "nominal_stress_MPa": study["first_ply_stress"] / 1e6,
        "table_2_strength_MPa": study["printed_strength"] / 1e6,
        "first_to_fail": study["first_ply"],
        "mode_of_failure": study["first_ply_mode"],
    }
    linkages = {
        "loaded_by": xr.DataArray("inertia"),
        "crank_speed_rad_s": study["failure_speed"],
        "first_to_fail": study["failing_link"],
        "mode_of_failure": study["failing_mode"],
    }
    of_sections = _rows(sections, "laminate", "layers", "section_load")
    of_sections = of_sections.rename(columns={"section_load": "loaded_by"})
    return pd.concat([of_sections, _rows(linkages, "laminate", "layers", "case")])


def _rows(columns: Mapping[str, xr.DataArray], *dims: str) -> pd.DataFrame:
    """Variables side by side, with a row for each combination of indices, the last one fastest."""
    found = xr.Dataset(
        {name: one.drop_vars(set(one.coords) - set(dims)) for name, one in columns.items()}
    )
    return found.to_dataframe(dim_order=list(dims)).reset_index()


def printed_tables(tables: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Some of the numbers of the files beside those of the paper, by what they are."""
    return {
        "Table 2 beside the rule of mixtures: moduli in bending in the plane of motion, with the "
        "uncertainties of Table 1; no strength of fibre or resin is printed, so that none follows "
        "from Table 1": _beside_table_2(tables["composite_properties"]),
        f"greatest at {CRANK_SPEED:g} rad/s: woven plies parallel to the plane of motion; steel of "
        f"the same size with {STEEL.youngs_modulus / 1e9:g} GPa and {STEEL.density:g} kg/m^3; "
        "speed, size and steel are assumed": _beside_steel(tables["composite_running"]),
        "first-ply failure beside the strengths of Table 2: nominal stresses in MPa at which a "
        f"straight ply fails first by {CRITERION}, with strengths from elsewhere ({SOURCE}), for "
        "comparison only: the paper prints none of its plies; at the crank speeds in rad/s the "
        "inertia forces of rigid links of the size that is assumed break the weakest case, "
        "vibration not in them": _beside_strengths(tables["composite_strength"]),
        **_ratios(tables["composites"]),
    }


def _beside_table_2(rows: pd.DataFrame) -> pd.DataFrame:
    def known(name: str, decimals: int, plies: str, layers: str) -> pd.Series:
        chosen = rows[(rows["plies"] == plies) & (rows["layers"] == layers)].set_index("laminate")
        numbers = (
            chosen[column].map(f"{{:.{decimals}f}}".format)
            for column in (name, f"{name}_uncertainty")
        )
        return next(numbers) + " \N{PLUS-MINUS SIGN} " + next(numbers)

    modulus, stacked = "modulus_GPa", next(layers for layers in LAYERS if layers != FLAT)
    printed = rows.groupby("laminate").first()
    return pd.DataFrame(
        {
            "E printed (GPa)": printed["table_2_modulus_GPa"],
            "straight, in the plane": known(modulus, 1, **_STRAIGHT),
            "stacked": known(modulus, 1, "unidirectional", stacked),
            "woven, in the plane": known(modulus, 1, "woven", FLAT),
            "nu printed": printed["table_2_poisson_ratio"],
            "computed": known("poisson_ratio", 3, **_STRAIGHT),
            "density printed (kg/m^3)": printed["table_2_density_kg_m3"],
            "density computed": known("density_kg_m3", 0, **_STRAIGHT),
            "strength printed (MPa)": printed["table_2_strength_MPa"],
        }
    )


def _beside_steel(rows: pd.DataFrame) -> pd.DataFrame:
    woven = rows[rows["plies"] == "woven"].drop(columns=["plies", "crank_speed_rad_s"])
    found = woven.set_index(["case", "material"]).stack().unstack("material").swaplevel()
    return found.sort_index(sort_remaining=True).round(3)[woven["material"].unique()]


def _beside_strengths(rows: pd.DataFrame) -> pd.DataFrame:
    stress = rows.pivot_table("nominal_stress_MPa", "laminate", ["loaded_by", "layers"])[
        ["tension", "compression", "bending"]
    ]
    linkages = rows[rows["loaded_by"] == "inertia"]
    worst = linkages.loc[linkages.groupby(["laminate", "layers"])["crank_speed_rad_s"].idxmin()]
    told = worst["crank_speed_rad_s"].map("{:.0f}".format) + worst["case"].map(
        " (case {:.0f})".format
    )
    breaks = worst.assign(told=told).pivot(index="laminate", columns="layers", values="told")
    printed = rows.groupby("laminate")["table_2_strength_MPa"].first()
    found = stress.round().astype(int)
    found.insert(0, ("Table 2", ""), printed.round().astype(int))
    for layers in breaks:
        found["breaks at", layers] = breaks[layers]
    return found


def _ratios(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """One table a position, as Tables 4 to 6 of the paper."""
    models = ["plies", "layers", "beams", "supports"]
    first = rows[(rows[models] == rows[models].iloc[0]).all(axis=1)].set_index("position")
    columns = ["ratio", "published_finite_element_ratio", "published_measured_ratio"]
    told = first[columns].map("{:.2f}".format).agg(" / ".join, axis=1)
    first = first.assign(told=told)
    relative = first.loc["min"].query("case == 1").set_index("laminate")
    relative = relative["ratio_uncertainty"] / relative["ratio"]
    known = ", ".join(f"{100 * one:.1f}" for one in relative[1:])
    return {
        f"{words}: ratios, computed / finite elements / measured; by Table 1 the computed ones are "
        f"uncertain by {known} % (C2 to C6)": first.loc[position].pivot(
            index="laminate", columns="case", values="told"
        )
        for position, words in POSITIONS.items()
    }


def weakest(tables: Mapping[str, pd.DataFrame]) -> str:
    """Which linkage of the study breaks first, and at which speed."""
    rows = tables["composite_strength"].reset_index(drop=True)
    row = rows.loc[rows["crank_speed_rad_s"].idxmin()]
    return (
        f"of all linkages case {row['case']:.0f} of {row['laminate']}, plies {row['layers']}, "
        f"breaks first as the speed rises, at {row['crank_speed_rad_s']:.0f} rad/s by "
        f"{row['mode_of_failure']} of its {row['first_to_fail']}, with strengths of plies from "
        "elsewhere and the link size that is assumed"
    )
