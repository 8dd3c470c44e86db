"""Margins: a row for each part that is judged, of whatever kind, the weakest first.

A further kind is a word in :data:`KINDS` and one more list of rows for :func:`margin_variables`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import PLAIN_TYPES
from flexmech.analyses.digits import plain

KINDS = {"link": "{}", "pin": "pin {}", "fatigue": "{} (fatigue)"}
"""Kinds of parts, and what a part of each is called."""
NO_LAYER = 0
"""Number of the layer of a part that has none."""
_MM = 1e3


@dataclass(frozen=True)
class Margin:
    """How far a part is from failure, at its worst place and crank angle.

    Parameters
    ----------
    part : str
        Link or joint.
    kind : str
        One of :data:`KINDS`.
    load_factor, speed_factor : float
        Least of the part; the latter is not a number where none follows.
    where : str
        In words.
    crank_angle : float
        In rad.
    mode : str
        How the part fails first.
    index : float
        Failure index.
    position : float
        From the start of the link in m; not a number of a pin.
    layer : int
        From the lowest y on; :data:`NO_LAYER` where there is none.
    surface : str
        Of the layer.
    """

    part: str
    kind: str
    load_factor: float
    speed_factor: float
    where: str
    crank_angle: float
    mode: str
    index: float
    position: float = math.nan
    layer: int = NO_LAYER
    surface: str = ""


def part_name(part: str, kind: str) -> str:
    """What messages call a part, such as ``"pin A"``: no two of a mechanism are called alike."""
    return KINDS[kind].format(part)


def margin_names(dataset: xr.Dataset) -> list[str]:
    """:func:`part_name` of every margin of a dataset, in order."""
    parts, kinds = (dataset[f"margin_{name}"].values.tolist() for name in ("part", "kind"))
    return [part_name(part, kind) for part, kind in zip(parts, kinds, strict=True)]


def margin_variables(*of_kinds: Sequence[Margin]) -> dict[str, Any]:
    """Variables over ``margin`` of a dataset, of lists of rows, weakest part first."""
    rows = sorted((row for own in of_kinds for row in own), key=attrgetter("load_factor"))
    return {
        f"margin_{field.name}": (
            "margin",
            np.array([getattr(row, field.name) for row in rows], PLAIN_TYPES[str(field.type)]),
        )
        for field in fields(Margin)
    }


def link_margins(dataset: xr.Dataset) -> list[Margin]:
    """Margin of each judged link, at its worst place by whatever engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of strength.

    Returns
    -------
    list of Margin
    """
    return [
        Margin(
            part=name,
            kind="link",
            load_factor=float(worst["load_factor"]),
            speed_factor=_least(own["speed_factor"]),
            crank_angle=float(worst["worst_angle"]),
            mode=str(worst["failure_mode"].item()),
            index=float(worst["failure_index"]),
            **_place(worst),
        )
        for name, own, worst in _worst_places(dataset, "load_factor")
    ]


def fatigue_margins(dataset: xr.Dataset) -> list[Margin]:
    """Margin of each link that is judged for endurance, at its worst place by whatever engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of strength; without endurance it has no such margin.

    Returns
    -------
    list of Margin
        At the crank angle of the greatest stress.
    """
    if "fatigue_load_factor" not in dataset:
        return []
    return [
        Margin(
            part=name,
            kind="fatigue",
            load_factor=float(worst["fatigue_load_factor"]),
            speed_factor=_least(own["fatigue_speed_factor"]),
            crank_angle=float(worst["peak_angle"]),
            mode="fatigue",
            index=1 / float(worst["fatigue_load_factor"]),
            **_place(worst),
        )
        for name, own, worst in _worst_places(dataset, "fatigue_load_factor")
    ]


def pin_margins(dataset: xr.Dataset) -> list[Margin]:
    """Margin of each judged pin, by its worst check and by whatever engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of strength; without checks of pins it has no pin's margin.

    Returns
    -------
    list of Margin
    """
    if "pin_joint" not in dataset:
        return []
    rows = []
    joints = dataset["pin_joint"].values
    for joint in dict.fromkeys(joints.tolist()):
        own = dataset.isel(pin_check=joints == joint)
        factor = own["pin_load_factor"].transpose("engine", "pin_check").values
        engine, check = np.unravel_index(np.argmin(factor), factor.shape)
        worst = own.isel(engine=engine, pin_check=check)
        link = str(worst["pin_link"].item())
        rows.append(
            Margin(
                part=joint,
                kind="pin",
                load_factor=float(worst["pin_load_factor"]),
                speed_factor=_least(own["pin_speed_factor"]),
                where=f"eye of the {link}" if link else "bush",
                crank_angle=float(worst["pin_worst_angle"]),
                mode=str(worst["pin_mode"].item()),
                index=float(worst["pin_stress"] / worst["pin_allowable"]),
            )
        )
    return rows


def _worst_places(dataset: xr.Dataset, name: str) -> Iterator[tuple[str, xr.Dataset, xr.Dataset]]:
    """Links with a least factor of a name, what is found of them, and that at its place."""
    for link in dataset["link"].values.tolist():
        own = dataset.sel(link=link)
        factor = own[name]
        if not bool(factor.isnull().all()):
            places = np.unravel_index(np.nanargmin(factor.values), factor.shape)
            yield link, own, own.isel(dict(zip(factor.dims, places, strict=True)))


def _place(worst: xr.Dataset) -> dict[str, Any]:
    """Where on its link a margin is."""
    position, surface = float(worst["position"]), str(worst["surface"].item())
    where = f"{plain(_MM * position)} mm from its start, {surface} surface"
    layer = int(worst["layer"])
    return {"where": where, "position": position, "layer": layer, "surface": surface}


def _least(factors: xr.DataArray) -> float:
    """Least of the factors that are numbers; not a number where none is."""
    known = factors.values[~np.isnan(factors.values)]
    return float(known.min(initial=math.inf)) if known.size else math.nan
