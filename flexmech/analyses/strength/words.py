"""What strength says in words: the part that fails first, the margins, and what is left out."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, plain, rounded
from flexmech.analyses.remarks import CHOSEN_DAMPING, crank_speed_text
from flexmech.analyses.summary import Row, Summary, Table
from flexmech.units import from_si

_MM = 1e3
# Digits of a factor: loads and strengths are known to fewer.
_DIGITS = 3
LEFT_OUT = (
    "left out by beam theory: stresses at free edges, at the ends of links and around holes, and "
    "shear between the plies, which none of the plies' criteria counts; pins and fatigue are not "
    "judged, nor is fatigue of composites"
)
FORCES = {
    "quasi-static": (
        "internal forces: quasi-static, of links that move as rigid ones; vibration of the links "
        "and what their deflection adds are not in them"
    ),
    "periodic": "internal forces: of one turn of the links' periodic vibration",
    "transient": "internal forces: of a run that begins with straight links at full speed",
}
BY_RUN = (
    "bending moments: by the curvature of the links; axial and shear forces: by the joint forces "
    "of the run and the inertia of links that move as rigid ones"
)


def where_text(data: xr.Dataset, number: int) -> str:
    """Place of a margin: distance from the link's start, and surface of the layer."""
    place = _MM * float(data["margin_position"][number])
    surface = _text(data, "surface", number)
    return f"{plain(place)} mm from its start, {surface} surface"


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust and details of a dataset of strength.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``Strength`` result.

    Returns
    -------
    Summary
    """
    first = float(data["margin_load_factor"][0])
    warning: tuple[str, ...] = ()
    if first < 1:
        part = _text(data, "part", 0)
        warning = (f"{part} does not bear its loads: its load factor is {_factor(first)}",)
    return Summary(
        _answer(data),
        _table(data),
        "of the places and crank angles asked for alone: between them factors may be lower",
        tuple(_details(data)),
        warning,
        _numbers(data),
    )


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    part, load = _text(data, "part", 0), float(data["margin_load_factor"][0])
    if math.isinf(load):
        return ("No part fails, however the loads rise: nothing grows towards failure.",)
    mode = _text(data, "mode", 0)
    layer = _layer_text(data, 0)
    at = plain(DEGREES * float(data["margin_crank_angle"][0]))
    how = f"{part} fails first, by {mode} in {layer}, {where_text(data, 0)}, crank at {at} deg"
    if load == 0:
        return (f"{how}: stresses of cure, heat or moisture alone break it.",)
    speed = float(data["margin_speed_factor"].min())
    factors = f"the loads may rise by a factor of {_factor(load)}"
    if load < 1:
        factors = f"the loads must fall to {_factor(load)} of what they are"
    if math.isfinite(speed):
        weakest = int(np.nanargmin(data["margin_speed_factor"].values))
        least = float(data["margin_speed_factor"][weakest])
        other = "" if weakest == 0 else f" ({_text(data, 'part', weakest)})"
        factors += (
            f", the speed by {_factor(least)}{other}"
            if load >= 1
            else (f", the speed to {_factor(least)}{other}")
        )
    return (f"{how}: {factors}.",)


def _table(data: xr.Dataset) -> Table:
    rows: list[Row] = []
    for number in range(data.sizes["margin"]):
        factor = float(data["margin_load_factor"][number])
        speed = float(data["margin_speed_factor"][number])
        place = _MM * float(data["margin_position"][number])
        rows.append(
            (
                _text(data, "part", number),
                _text(data, "mode", number),
                _text(data, "surface", number),
                str(int(data["margin_layer"][number])),
                plain(place),
                plain(DEGREES * float(data["margin_crank_angle"][number])),
                _factor(float(data["margin_index"][number])),
                _factor(factor),
                _factor(speed),
            )
        )
    headings = ("part", "fails by", "surface", "layer", "at mm", "crank deg", "index")
    return Table(
        f"margins of {data.attrs['mechanism']} at {crank_speed_text(data.attrs)}",
        (*headings, "load factor", "speed factor"),
        (tuple(rows),),
        text_columns=3,
    )


def _details(data: xr.Dataset) -> list[str]:
    names = sorted({str(name) for name in data["criterion"].values.ravel() if str(name)})
    lines = [f"criteria: {', '.join(names)}"]
    if "tsai-wu" in names:
        lines.append("tsai-wu: F12* = -1/2, so that F12 = -sqrt(F11 F22) / 2")
    lines += _engine_lines(data)
    lines.append(
        "load factor: multiplies the stresses of the loads; those of cure, heat and moisture stay"
    )
    if uncounted := str(data.attrs.get("cure_not_counted", "")):
        lines.append(
            f"stresses of cure are not counted in: {uncounted}; state stress_free_temperature of "
            "their laminates"
        )
    lines += str(data.attrs.get("environment_lines", "")).splitlines()
    if missing := str(data.attrs.get("not_judged", "")):
        lines.append(f"not judged, for their layers are not known: {missing}")
    lines += _search_lines(data)
    source = str(data.attrs["source_of_loads"])
    lines += [FORCES[source], *([] if source == "quasi-static" else [BY_RUN])]
    lines += str(data.attrs.get(CHOSEN_DAMPING, "")).splitlines()
    return [*lines, LEFT_OUT]


def _search_lines(data: xr.Dataset) -> list[str]:
    """How the speed factor was found, or why there is none."""
    if "searched_speed_factor" in data:
        factor, load = (data[f"searched_{name}_factor"].values for name in ("speed", "load"))
        runs = ", ".join(
            f"{_factor(one)}: {_factor(other)} ({part})"
            for one, other, part in zip(
                factor.tolist(), load.tolist(), data["searched_part"].values.tolist(), strict=True
            )
        )
        lines = [
            "speed factor: searched by runs at higher speeds, of the part that fails first alone; "
            "a resonance narrower than their distance may lie between them",
            f"runs by speed over that asked for, least load factor and part: {runs}",
        ]
        note = str(data.attrs.get("search_note", ""))
        return [*lines, f"search of the speed: {note}"] if note else lines
    if not bool(data["margin_speed_factor"].isnull().all()):
        return []
    return [
        "speed factor: follows from quasi-static loads where the crank turns, no damper acts and "
        "no load goes over time; of elastic links it is searched if asked for"
    ]


def _engine_lines(data: xr.Dataset) -> list[str]:
    """Least load factor of each link by each engine, where there are several."""
    if data.sizes["engine"] == 1:
        return []
    least = data["load_factor"].min(["station", "layer", "surface"])
    lines = []
    for link in data["margin_part"].values.tolist():
        told = (
            f"{engine} {_factor(float(least.sel(engine=engine, link=link)))}"
            for engine in data["engine"].values.tolist()
        )
        lines.append(f"load factor of {link}: {', '.join(told)}")
    return lines


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    numbers = []
    for number in range(data.sizes["margin"]):
        part = _text(data, "part", number)
        for name in ("load_factor", "speed_factor"):
            numbers.append(Quantity(name, float(data[f"margin_{name}"][number]), "", of=part))
    return tuple(numbers)


def _layer_text(data: xr.Dataset, number: int) -> str:
    """Layer of a margin with its ply and angle."""
    layer = int(data["margin_layer"][number])
    own = data.sel(link=_text(data, "part", number), layer=layer)
    ply = str(own["ply"].item())
    if not ply:
        return f"layer {layer}"
    return f"layer {layer} ({ply}@{from_si(float(own['angle']), 'deg'):.4g})"


def _factor(value: float) -> str:
    return "-" if math.isnan(value) else rounded(value, math.nan, _DIGITS)


def _text(data: xr.Dataset, name: str, number: int) -> str:
    return str(data[f"margin_{name}"].values[number])
