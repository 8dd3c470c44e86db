"""Strength in words: the part that fails first, the margins of all, and what is left out."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.details import details_table, notes_of
from flexmech.analyses.digits import Quantity, percent, plain, rounded
from flexmech.analyses.strength.margins import NO_LAYER, Margin, margin_names, margins_of
from flexmech.analyses.strength.pins import TEARING
from flexmech.analyses.summary import CHOSEN_DAMPING, Row, Summary, Table, crank_speed_text
from flexmech.units import from_si

_MM, _MEGA = 1e3, 1e-6
# Digits of a factor: loads and strengths are known to fewer.
_DIGITS = 3
_RUNS = ("periodic", "transient")
# Hours of a turn at 1 rad/s.
_HOURS = 2 * math.pi / 3600
ASKED = "crank angles asked for"
"""Where parts were judged, if not between the crank angles too."""
# Internal forces below this part of the greatest of their kind are round-off.
_NO_FORCE = 1e-6
# Variable of the least load factors of each kind of part.
_FACTORS = {"link": "load_factor", "fatigue": "fatigue_load_factor", "pin": "pin_load_factor"}


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust, details, warnings and numbers of strength.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``Strength`` result.

    Returns
    -------
    Summary
    """
    margins = margins_of(data)
    first, warning = margins[0], list[str]()
    if first.load_factor < 1:
        ever = " for ever" if first.kind == "fatigue" else ""
        factor = _factor(first.load_factor)
        warning = [f"{first.name} does not bear its loads{ever}: its load factor is {factor}"]
    known = f"load factors are known to {percent(float(data['margin_error'].max()))}"
    if data.attrs.get("judged_at") == ASKED:
        known += f", {notes_of(__package__)['asked']}"
    return Summary(
        _answer(data, margins),
        _table(data, margins),
        f"{known}{_agreement(data)}",
        (*details_table(_quantities(data, margins)), *_notes(data)),
        tuple(warning),
        _numbers(data, margins),
    )


def _answer(data: xr.Dataset, margins: list[Margin]) -> tuple[str, ...]:
    """The part that fails first, how, where, and the factors by which loads and speed may rise."""
    first, names = margins[0], margin_names(data)
    load = first.load_factor
    if math.isinf(load):
        return ("No part fails at any multiple of the loads: no stress grows towards failure.",)
    layer = _layer(data, first)
    place = f"{layer}, {first.where}" if layer else f"the {first.where}"
    at = plain(DEGREES * first.crank_angle)
    subject = f"The {names[0]}" if first.kind != "pin" else f"P{names[0].removeprefix('p')}"
    how = f"{subject} fails first, by {first.mode} in {place}, crank at {at} deg"
    if load == 0:
        return (f"{how}: stresses of cure, heat or moisture alone exceed its strength.",)
    factors = f"the loads may rise by a factor of {_factor(load)}"
    if load < 1:
        factors = f"the loads must fall to {_factor(load)} of their values"
    speeds = np.array([one.speed_factor for one in margins])
    if not np.isnan(speeds).all() and math.isfinite(least := float(np.nanmin(speeds))):
        weakest = int(np.nanargmin(speeds))
        other = "" if weakest == 0 else f" ({names[weakest]})"
        factors += f", the speed {'by' if load >= 1 else 'to'} {_factor(least)}{other}"
    turns = _turns(data, first.part) if first.kind == "fatigue" else math.nan
    lasting: tuple[str, ...] = ()
    if math.isfinite(turns):
        speed = abs(float(data.attrs["crank_speed"]))
        hours = f", {turns * _HOURS / speed:.3g} h at this speed" if speed else ""
        lasting = (f"Under these loads it fails after {turns:.3g} turns{hours}.",)
    return (f"{how}: {factors}.", *lasting)


def _layer(data: xr.Dataset, margin: Margin) -> str:
    """Layer of a margin with its ply and angle; nothing where it has none."""
    if margin.layer == NO_LAYER:
        return ""
    of_layer = data.sel(link=margin.part, layer=margin.layer)
    ply = str(of_layer["ply"].item())
    angle = f"{from_si(float(of_layer['angle']), 'deg'):.4g}"
    return f"layer {margin.layer} ({ply}@{angle})" if ply else f"layer {margin.layer}"


def _table(data: xr.Dataset, margins: list[Margin]) -> Table:
    rows: list[Row] = [
        (
            name,
            one.mode,
            one.surface or one.where,
            "-" if one.layer == NO_LAYER else str(one.layer),
            "-" if math.isnan(one.position) else plain(_MM * one.position),
            plain(DEGREES * one.crank_angle),
            *map(_factor, (one.index, one.load_factor, one.speed_factor)),
        )
        for name, one in zip(margin_names(data), margins, strict=True)
    ]
    headings = ("part", "fails by", "where", "layer", "at mm", "crank deg", "index")
    return Table(
        f"margins of {data.attrs['mechanism']} at {crank_speed_text(data.attrs)}",
        (*headings, "load factor", "speed factor"),
        (tuple(rows),),
        text_columns=3,
    )


def _quantities(data: xr.Dataset, margins: list[Margin]) -> Iterator[Quantity]:
    """Factors by each engine, stresses of fatigue, and load factors at the speeds searched."""
    engines = data["engine"].values.astype(str).tolist()
    for one in margins if len(engines) > 1 else ():
        factors = data[_FACTORS[one.kind]]
        of_part = factors.sel(link=one.part) if "link" in factors.dims else factors
        if one.kind == "pin":
            of_part = factors.isel(pin_check=np.flatnonzero(data["pin_joint"].values == one.part))
        for engine in engines:
            least = float(of_part.sel(engine=engine).min())
            yield Quantity("load factor", least, "", of=f"{one.name}, {engine}")
    for one in (margin for margin in margins if margin.kind == "fatigue"):
        link = data.sel(link=one.part)
        worst = link.isel(link["fatigue_load_factor"].argmin(...))
        for name in ("stress_amplitude", "mean_stress", "endurance_limit"):
            yield Quantity(name, _MEGA * float(worst[name]), "MPa", of=one.part)
        yield Quantity("cycles to that limit", float(worst["endurance_cycles"]), "", of=one.part)
        yield Quantity("turns_to_failure", _turns(data, one.part), "", of=one.part)
    if "searched_speed_factor" in data:
        names = ("speed_factor", "load_factor", "part")
        columns = (data[f"searched_{name}"].values.tolist() for name in names)
        for speed, load, part in zip(*columns, strict=True):
            of = f"{part}, {_factor(speed)} times the speed"
            yield Quantity("least load factor", load, "", of=of)


def _notes(data: xr.Dataset) -> Iterator[str]:
    """How the numbers were found, and what was left out for want of data."""
    notes, attrs = notes_of(__package__), {name: str(text) for name, text in data.attrs.items()}
    source, modes = attrs["source_of_loads"], {*data.get("pin_mode", xr.DataArray("")).values.flat}
    names = sorted({str(name) for name in data["criterion"].values.flat if str(name)})
    searched, runs = "searched_speed_factor" in data, source in _RUNS
    if names:
        yield f"criteria: {', '.join(names)}"
    for key, applies in (
        ("tsai-wu", "tsai-wu" in names),
        ("load factor", True),
        ("pins", bool(modes - {""})),
        ("tearing", bool(modes & {*TEARING})),
        ("p v", "p v" in modes),
        ("fatigue", "fatigue_load_factor" in data),
        ("searched by runs", searched and runs),
        ("searched by equilibria", searched and not runs),
        ("no speed factor", bool(data["margin_speed_factor"].isnull().all()) and not searched),
        (source, True),
        ("left out", True),
    ):
        if applies:
            yield notes[key]
    if runs:
        yield notes["by run"].format(attrs["moment_gap"])
    for name in (
        *("of_rigid_links", "environment_lines", "pin_checks_left_out", "fatigue_left_out"),
        CHOSEN_DAMPING,
    ):
        yield from attrs.get(name, "").splitlines()
    for name in (
        "cure_not_counted",
        "sliced",
        "not_judged",
        "pins_without_diameter",
        "search_note",
    ):
        if attrs.get(name):
            yield notes[name].format(attrs[name])


def straight_line(data: xr.Dataset) -> str:
    """Load and speed factor of each part by the loads of rigid links.

    Parameters
    ----------
    data : xarray.Dataset
        Data of strength.

    Returns
    -------
    str
    """
    factors = ", ".join(
        f"{name} {_factor(one.load_factor)} ({_factor(one.speed_factor)})"
        for name, one in zip(margin_names(data), margins_of(data), strict=True)
    )
    return f"if the links were rigid, load factor (and speed factor): {factors}"


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


def _numbers(data: xr.Dataset, margins: list[Margin]) -> tuple[Quantity, ...]:
    numbers, errors = [], data["margin_error"].values.tolist()
    for part, one, error in zip(margin_names(data), margins, errors, strict=True):
        load = one.load_factor
        known = load * error if math.isfinite(load) else math.nan
        numbers.append(Quantity("load_factor", load, "", known, part))
        numbers.append(Quantity("speed_factor", one.speed_factor, "", of=part))
        if one.kind == "fatigue":
            turns = _turns(data, one.part)
            numbers.append(Quantity("turns_to_failure", turns, "", of=part))
            # Zero of a link that lasts for ever, whose turns JSON cannot tell from unknown ones.
            numbers.append(Quantity("damage_per_turn", 1 / turns, "", of=part))
    return tuple(numbers)


def _turns(data: xr.Dataset, link: str) -> float:
    """Turns after which a link fails at its worst place, by whatever engine.

    Infinite where it never fails; not a number where no S-N line tells of one of its places.
    """
    of_link = data.sel(link=link)
    judged = of_link["fatigue_load_factor"].notnull().values
    return float(of_link["turns_to_failure"].values[judged].min())


def _factor(value: float) -> str:
    return "-" if not math.isfinite(value) else rounded(value, math.nan, _DIGITS)
