"""Margins: a row for each part that is judged, of whatever kind, the weakest first.

A pin has two of them where one check is its weakest as loads rise, and another as the speed rises.

A further kind is a word in :data:`KINDS` and one more list of rows for :func:`margin_variables`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from operator import attrgetter
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import PLAIN_TYPES
from flexmech.analyses.digits import plain
from flexmech.arrays import ROUND_OFF

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
        Least of the part, of a pin both of one check; the latter is not a number where none
        follows.
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
        Surface of the layer.
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

    @property
    def name(self) -> str:
        """Name of the part in messages, such as ``"pin A"``: no two of a mechanism are alike."""
        return KINDS[self.kind].format(self.part)


def margins_of(dataset: xr.Dataset) -> list[Margin]:
    """Margins of a dataset of strength, in order."""
    names = [field.name for field in fields(Margin)]
    columns = (dataset[f"margin_{name}"].values.tolist() for name in names)
    return [Margin(*row) for row in zip(*columns, strict=True)]


def margin_names(dataset: xr.Dataset) -> list[str]:
    """:attr:`Margin.name` of every margin of a dataset, in order; of a second one with its mode."""
    names: list[str] = []
    for one in margins_of(dataset):
        names.append(f"{one.name}, {one.mode}" if one.name in names else one.name)
    return names


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


def link_margins(dataset: xr.Dataset, kind: str = "link") -> list[Margin]:
    """Margin of each judged link, at its worst place by whatever engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of strength; without endurance it has no margins of fatigue.
    kind : {"link", "fatigue"}
        By the criteria of its layers, or by the endurance of its material, which counts at the
        crank angle of the greatest stress.

    Returns
    -------
    list of Margin
    """
    tires, rows = kind == "fatigue", []
    load, speed = (f"{'fatigue_' * tires}{name}_factor" for name in ("load", "speed"))
    for link in dataset["link"].values.tolist() if load in dataset else ():
        own = dataset.sel(link=link)
        factor = own[load]
        if bool(factor.isnull().all()):
            continue
        places = np.unravel_index(np.nanargmin(factor.values), factor.shape)
        worst = own.isel(dict(zip(factor.dims, places, strict=True)))
        position, surface = float(worst["position"]), str(worst["surface"].item())
        least, speeds = float(worst[load]), own[speed].values
        rows.append(
            Margin(
                part=link,
                kind=kind,
                load_factor=least,
                speed_factor=math.nan if np.isnan(speeds).all() else float(np.nanmin(speeds)),
                where=f"{plain(_MM * position)} mm from its start, {surface} surface",
                crank_angle=float(worst["peak_angle" if tires else "worst_angle"]),
                mode="fatigue" if tires else str(worst["failure_mode"].item()),
                index=1 / least if tires else float(worst["failure_index"]),
                position=position,
                layer=int(worst["layer"]),
                surface=surface,
            )
        )
    return rows


@dataclass(frozen=True)
class PinFailure:
    """The check of a pin that fails first as the crank speed rises, and its speed.

    Parameters
    ----------
    check : int
        Number of the check in the dataset.
    speed_factor : float
    """

    check: int
    speed_factor: float


def pin_margins(
    dataset: xr.Dataset, failures: Mapping[str, PinFailure] | None = None
) -> list[Margin]:
    """Margins of each judged pin by its checks, and by whatever engine; each row is of one check.

    The check that fails first as the loads rise is one row. Where another one fails first as the
    speed rises, that is a second row.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of strength; without checks of pins it has no pin's margin.
    failures : mapping of str to PinFailure, optional
        Failures of joints, as a search of the speed has found them. Left out: by the speed factors
        of the checks, which loads of rigid links have.

    Returns
    -------
    list of Margin
    """
    if "pin_joint" not in dataset:
        return []
    rows = []
    names = dataset["pin_joint"].values
    load, speed = (
        dataset[f"pin_{name}_factor"].transpose("engine", "pin_check").values
        for name in ("load", "speed")
    )
    for joint in dict.fromkeys(names.tolist()):
        checks = np.flatnonzero(names == joint)
        weakest = int(checks[load[:, checks].min(axis=0).argmin()])
        fastest: PinFailure | None = None
        if failures is not None:
            fastest = failures.get(joint)
        elif not np.isnan(speed[:, checks]).all():
            least = np.nanmin(speed[:, checks], axis=0)
            first = int(least.argmin())
            fastest = PinFailure(int(checks[first]), float(least[first]))
            if least[checks == weakest][0] <= fastest.speed_factor * (1 + ROUND_OFF):
                fastest = replace(fastest, check=weakest)
        for check in dict.fromkeys([weakest, fastest.check if fastest else weakest]):
            known = fastest.speed_factor if fastest and check == fastest.check else math.nan
            if failures is None and not np.isnan(speed[:, check]).all():
                known = float(np.nanmin(speed[:, check]))
            rows.append(_pin_margin(dataset, int(load[:, check].argmin()), check, known))
    return rows


def weakest_checks(dataset: xr.Dataset) -> dict[str, int]:
    """Number of the check of each joint's pin with the least load factor, by whatever engine."""
    if "pin_joint" not in dataset:
        return {}
    names = dataset["pin_joint"].values
    load = dataset["pin_load_factor"].transpose("engine", "pin_check").values.min(axis=0)
    return {
        joint: int(np.flatnonzero(names == joint)[load[names == joint].argmin()])
        for joint in dict.fromkeys(names.tolist())
    }


def failures_of(
    speed_factors: Mapping[str, float], weakest: Mapping[float, Mapping[str, int]]
) -> dict[str, PinFailure]:
    """Checks of pins that fail at the speeds that were searched.

    Parameters
    ----------
    speed_factors : mapping of str to float
        Speed factors of parts by :attr:`Margin.name`.
    weakest : mapping of float to mapping of str to int
        :func:`weakest_checks` by the factor of the crank speed: the nearest one tells.

    Returns
    -------
    dict of str to PinFailure
    """
    found = {}
    for joint in next(iter(weakest.values())):
        factor = speed_factors.get(KINDS["pin"].format(joint), math.nan)
        if math.isfinite(factor):
            apart = {abs(own - factor): own for own in weakest}
            near = apart[min(apart)]
            found[joint] = PinFailure(weakest[near][joint], factor)
    return found


def _pin_margin(dataset: xr.Dataset, engine: int, check: int, speed_factor: float) -> Margin:
    """Margin of a pin by one check and one engine."""
    own = dataset.isel(engine=engine, pin_check=check)
    link = str(own["pin_link"].item())
    return Margin(
        part=str(own["pin_joint"].item()),
        kind="pin",
        load_factor=float(own["pin_load_factor"]),
        speed_factor=speed_factor,
        where=f"eye of the {link}" if link else "bush",
        crank_angle=float(own["pin_worst_angle"]),
        mode=str(own["pin_mode"].item()),
        index=float(own["pin_stress"] / own["pin_allowable"]),
    )
