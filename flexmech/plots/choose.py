"""Choice of what a figure shows: engines, modes, speeds and links of a dataset."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.errors import InputError

DIMENSIONS = {
    "engine": "engine",
    "modes": "mode",
    "speeds": "crank_speed",
    "links": "link",
    "branches": "branch",
    "orders": "order",
}
SAME_SPEED = 1e-9
"""Relative difference up to which two speeds are the same."""


def chosen(
    dataset: xr.Dataset,
    *,
    engine: ArrayLike | None = None,
    modes: ArrayLike | None = None,
    speeds: ArrayLike | None = None,
    links: ArrayLike | None = None,
    branches: ArrayLike | None = None,
    orders: ArrayLike | None = None,
) -> xr.Dataset:
    """Part of a dataset that a figure shall show, in the order asked for.

    Parameters
    ----------
    dataset : Dataset
        Of a result.
    engine : str or sequence of str, optional
        Names, such as ``"exudyn"``.
    modes : int or sequence of int, optional
        Numbers from 1.
    speeds : float or sequence of float, optional
        Crank speeds in rad/s.
    links : str or sequence of str, optional
        Names, such as ``"coupler"``.
    branches, orders : int or sequence of int, optional
        Numbers from 1.

    Returns
    -------
    Dataset
        With all its dimensions; what is not chosen by is whole.

    Raises
    ------
    InputError
        If the dataset has no such engine, mode, speed or link.
    """
    asked = {"engine": engine, "modes": modes, "speeds": speeds, "links": links}
    asked |= {"branches": branches, "orders": orders}
    places = {}
    for argument, wanted in asked.items():
        if wanted is not None:
            places[DIMENSIONS[argument]] = _places(dataset, argument, wanted)
    return dataset.isel(places)


def _places(dataset: xr.Dataset, argument: str, wanted: ArrayLike) -> list[int]:
    """Positions along a dimension of the values asked for."""
    dimension = DIMENSIONS[argument]
    if dimension not in dataset.dims:
        raise InputError(f"{argument}: this result has none to choose from")
    known = dataset[dimension].values.tolist()
    values = np.atleast_1d(np.asarray(wanted)).tolist()
    there = ", ".join(map(_text, known)) + (" rad/s" if dimension == "crank_speed" else "")
    if not values:
        raise InputError(f"{argument}: nothing is chosen; choose from {there}")
    places = []
    for value in values:
        found = [place for place, each in enumerate(known) if _same(each, value)]
        if not found:
            raise InputError(f"{argument}: this result has no {value!r}; choose from {there}")
        places += found
    return places


def _text(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _same(one: object, other: object) -> bool:
    if isinstance(one, float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=SAME_SPEED)
    return one == other
