"""What strength says in words: the part that fails first, the margins, and what is left out."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, percent, plain, rounded
from flexmech.analyses.strength.endurance import endurance_lines, fewest_turns, life_text
from flexmech.analyses.strength.margins import NO_LAYER, margin_names, part_name, pin_margins
from flexmech.analyses.strength.pins import TEARING
from flexmech.analyses.summary import CHOSEN_DAMPING, Row, Summary, Table, crank_speed_text
from flexmech.units import from_si

_MM = 1e3
# Digits of a factor: loads and strengths are known to fewer.
_DIGITS = 3
_RUNS = ("periodic", "transient")
LEFT_OUT = (
    "left out by beam theory: stresses at free edges, at the ends of links and around holes, and "
    "shear between the plies, which none of the plies' criteria counts"
)
FORCES = {
    "quasi-static": (
        "internal forces: of links at rest in their frames, bent by inertia, weight, loads and "
        "springs, in equilibrium where they are displaced to; vibration is not in them. The load "
        "factor multiplies their stresses as they are: the bending would not grow in proportion"
    ),
    "rigid": (
        "internal forces: of links that are taken as rigid; vibration of the links and what their "
        "deflection adds are not in them"
    ),
    "periodic": "internal forces: of one turn of the links' periodic vibration",
    "transient": "internal forces: of a run that begins with straight links at full speed",
}
ASKED = "crank angles asked for"
"""Where parts were judged, if not between the crank angles too."""
OF_ANGLES = "of the crank angles asked for alone: between them factors may be lower"
# Internal forces below this part of the greatest of their kind are round-off.
_NO_FORCE = 1e-6
OF_PINS = (
    "pins: mean stresses of areas by the joint forces, against the links' yield strength, or what "
    "the joint is allowed; stress concentration at holes, bending of the pin itself and Hertz's "
    "pressure are not in them"
)
TEARING_AT_EYES = (
    "net tension and shear-out: by the pin's force on the eye without what pushes the eye onto its "
    "link; across the link it counts as along it"
)
OF_BUSHES = (
    "p v: the greatest product of bearing pressure and sliding velocity; it grows with the cube of "
    "the speed where forces are inertia alone"
)
BY_RUN = (
    "internal and joint forces balance loads and the inertia of what moves; bending moments are "
    "within {} of their peaks where the curvature of the links, which does not know their damping, "
    "has them"
)


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
        part = margin_names(data)[0]
        ever = " for ever" if _text(data, "kind", 0) == "fatigue" else ""
        warning = (f"{part} does not bear its loads{ever}: its load factor is {_factor(first)}",)
    return Summary(
        _answer(data),
        _table(data),
        f"{_known(data)}{_agreement(data)}",
        tuple(_details(data)),
        warning,
        _numbers(data),
    )


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    names, load = margin_names(data), float(data["margin_load_factor"][0])
    if math.isinf(load):
        return ("No part fails, however the loads rise: nothing grows towards failure.",)
    mode, where = _text(data, "mode", 0), _text(data, "where", 0)
    layer = _layer_text(data, 0)
    place = f"{layer}, {where}" if layer else f"the {where}"
    at = plain(DEGREES * float(data["margin_crank_angle"][0]))
    how = f"{names[0]} fails first, by {mode} in {place}, crank at {at} deg"
    if load == 0:
        return (f"{how}: stresses of cure, heat or moisture alone break it.",)
    speed = float(data["margin_speed_factor"].min())
    factors = f"the loads may rise by a factor of {_factor(load)}"
    if load < 1:
        factors = f"the loads must fall to {_factor(load)} of what they are"
    if math.isfinite(speed):
        weakest = int(np.nanargmin(data["margin_speed_factor"].values))
        least = float(data["margin_speed_factor"][weakest])
        other = "" if weakest == 0 else f" ({names[weakest]})"
        factors += (
            f", the speed by {_factor(least)}{other}"
            if load >= 1
            else (f", the speed to {_factor(least)}{other}")
        )
    link = _text(data, "part", 0) if _text(data, "kind", 0) == "fatigue" else ""
    lasting = life_text(data, link) if link else ""
    return (f"{how}: {factors}.", *([f"As the loads are, {lasting}."] if lasting else []))


def _table(data: xr.Dataset) -> Table:
    rows: list[Row] = []
    for number, name in enumerate(margin_names(data)):
        factor = float(data["margin_load_factor"][number])
        speed = float(data["margin_speed_factor"][number])
        place, layer = (data[f"margin_{of}"].values[number] for of in ("position", "layer"))
        surface = _text(data, "surface", number)
        rows.append(
            (
                name,
                _text(data, "mode", number),
                surface or _text(data, "where", number),
                "-" if layer == NO_LAYER else str(int(layer)),
                "-" if math.isnan(place) else plain(_MM * float(place)),
                plain(DEGREES * float(data["margin_crank_angle"][number])),
                _factor(float(data["margin_index"][number])),
                _factor(factor),
                _factor(speed),
            )
        )
    headings = ("part", "fails by", "where", "layer", "at mm", "crank deg", "index")
    return Table(
        f"margins of {data.attrs['mechanism']} at {crank_speed_text(data.attrs)}",
        (*headings, "load factor", "speed factor"),
        (tuple(rows),),
        text_columns=3,
    )


def _details(data: xr.Dataset) -> list[str]:
    names = sorted({str(name) for name in data["criterion"].values.ravel() if str(name)})
    lines = [f"criteria: {', '.join(names)}"] if names else []
    if "tsai-wu" in names:
        lines.append("tsai-wu: F12* = -1/2, so that F12 = -sqrt(F11 F22) / 2")
    lines += _engine_lines(data)
    lines += str(data.attrs.get("of_rigid_links", "")).splitlines()
    lines.append(
        "load factor: multiplies the stresses of the loads; those of cure, heat and moisture stay"
    )
    if uncounted := str(data.attrs.get("cure_not_counted", "")):
        lines.append(
            f"stresses of cure are not counted in: {uncounted}; state stress_free_temperature of "
            "their laminates"
        )
    lines += str(data.attrs.get("environment_lines", "")).splitlines()
    if slices := str(data.attrs.get("sliced", "")):
        lines.append(f"layers are slices of the stated ones, each equally moist: {slices}")
    if missing := str(data.attrs.get("not_judged", "")):
        lines.append(f"not judged, for their layers are not known: {missing}")
    lines += [*_pin_lines(data), *endurance_lines(data), *_search_lines(data)]
    source = str(data.attrs["source_of_loads"])
    lines += [
        FORCES[source],
        *([BY_RUN.format(data.attrs["moment_gap"])] if source in _RUNS else []),
    ]
    lines += str(data.attrs.get(CHOSEN_DAMPING, "")).splitlines()
    return [*lines, LEFT_OUT]


def _pin_lines(data: xr.Dataset) -> list[str]:
    """What was checked of pins, and what was left out for want of data."""
    lines = []
    if "pin_joint" in data:
        lines = [OF_PINS]
        modes = set(data["pin_mode"].values.tolist())
        lines += [TEARING_AT_EYES] if modes & {*TEARING} else []
        lines += [OF_BUSHES] if "p v" in modes else []
    lines += str(data.attrs.get("pin_checks_left_out", "")).splitlines()
    if bare := str(data.attrs.get("pins_without_diameter", "")):
        lines.append(f"pins not judged, for they state no diameter: {bare}")
    return lines


def _search_lines(data: xr.Dataset) -> list[str]:
    """How the speed factor was found, or why there is none."""
    if "searched_speed_factor" in data:
        factor, load = (data[f"searched_{name}_factor"].values for name in ("speed", "load"))
        found = ", ".join(
            f"{_factor(one)}: {_factor(other)} ({part})"
            for one, other, part in zip(
                factor.tolist(), load.tolist(), data["searched_part"].values.tolist(), strict=True
            )
        )
        by = "runs" if str(data.attrs["source_of_loads"]) in _RUNS else "equilibria"
        told = (
            "of the part that fails first alone; a resonance narrower than their distance may lie "
            "between them"
        )
        if by == "equilibria":
            told = "of every part; where links stayed straight it would be that of rigid ones"
        lines = [
            f"speed factor: searched by {by} at other speeds, {told}",
            f"{by} by speed over that asked for, least load factor and part: {found}",
        ]
        note = str(data.attrs.get("search_note", ""))
        return [*lines, f"search of the speed: {note}"] if note else lines
    if not bool(data["margin_speed_factor"].isnull().all()):
        return []
    return [
        "speed factor: follows from loads of rigid links where the crank turns, no damper acts and "
        "no load goes over time; of elastic links that move it is searched if asked for"
    ]


def straight_line(data: xr.Dataset) -> str:
    """Load and speed factor of each part by the loads of rigid links.

    Parameters
    ----------
    data : xarray.Dataset
        Of strength.

    Returns
    -------
    str
    """
    factors = (data[f"margin_{name}_factor"].values.tolist() for name in ("load", "speed"))
    parts = zip(margin_names(data), *factors, strict=True)
    told = ", ".join(f"{name} {_factor(load)} ({_factor(speed)})" for name, load, speed in parts)
    return f"if the links were rigid, load factor (and speed factor): {told}"


def _known(data: xr.Dataset) -> str:
    """How far load factors are known, of the part of which it is least."""
    known = f"load factors are known to {percent(float(data['margin_error'].max()))}"
    return f"{known}, {OF_ANGLES}" if data.attrs.get("judged_at") == ASKED else known


def _agreement(data: xr.Dataset) -> str:
    """How far the internal forces of two engines are apart, over their peaks."""
    if data.sizes["engine"] == 1:
        return ""
    greatest = 0.0
    for name in ("axial_force", "bending_moment", "shear_force"):
        values = data[name].transpose("engine", "link", ...).values
        peak = np.nanmax(np.abs(values[0]), axis=(1, 2), initial=0.0)
        apart = np.nanmax(np.abs(values - values[0]), axis=(0, 2, 3), initial=0.0)
        acts = peak > _NO_FORCE * peak.max()
        greatest = max(greatest, float((apart[acts] / peak[acts]).max(initial=0.0)))
    both = " and ".join(data["engine"].values.tolist())
    return f"; internal forces of {both} are within {percent(greatest)} of their peaks"


def _engine_lines(data: xr.Dataset) -> list[str]:
    """Least load factor of each part by each engine, where there are several."""
    if data.sizes["engine"] == 1:
        return []
    lines = []
    kinds, parts = (data[f"margin_{name}"].values for name in ("kind", "part"))
    for kind, name in (("link", "load_factor"), ("fatigue", "fatigue_load_factor")):
        for link in parts[kinds == kind].tolist():
            least = data[name].sel(link=link).min(["station", "layer", "surface"])
            told = (
                f"{engine} {_factor(float(least.sel(engine=engine)))}"
                for engine in data["engine"].values.tolist()
            )
            lines.append(f"load factor of {part_name(link, kind)}: {', '.join(told)}")
    pins = {pin.part: pin for pin in reversed(pin_margins(data))}
    for pin in reversed(pins.values()):
        own = data["pin_load_factor"][:, data["pin_joint"].values == pin.part]
        told = (
            f"{engine} {_factor(float(own.sel(engine=engine).min()))}"
            for engine in data["engine"].values.tolist()
        )
        lines.append(f"load factor of {part_name(pin.part, pin.kind)}: {', '.join(told)}")
    return lines


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    numbers = []
    for number, part in enumerate(margin_names(data)):
        load, speed = (float(data[f"margin_{of}_factor"][number]) for of in ("load", "speed"))
        error = math.nan
        if math.isfinite(load):
            error = load * float(data["margin_error"][number])
        numbers.append(Quantity("load_factor", load, "", error, part))
        numbers.append(Quantity("speed_factor", speed, "", of=part))
        if _text(data, "kind", number) == "fatigue":
            turns = fewest_turns(data, _text(data, "part", number))
            numbers.append(Quantity("turns_to_failure", turns, "", of=part))
            # Zero of a link that lasts for ever, whose turns JSON cannot tell from unknown ones.
            numbers.append(Quantity("damage_per_turn", 1 / turns, "", of=part))
    return tuple(numbers)


def _layer_text(data: xr.Dataset, number: int) -> str:
    """Layer of a margin with its ply and angle; nothing where it has none."""
    layer = int(data["margin_layer"][number])
    if layer == NO_LAYER:
        return ""
    own = data.sel(link=_text(data, "part", number), layer=layer)
    ply = str(own["ply"].item())
    if not ply:
        return f"layer {layer}"
    return f"layer {layer} ({ply}@{from_si(float(own['angle']), 'deg'):.4g})"


def _factor(value: float) -> str:
    return "-" if not math.isfinite(value) else rounded(value, math.nan, _DIGITS)


def _text(data: xr.Dataset, name: str, number: int) -> str:
    return str(data[f"margin_{name}"].values[number])
