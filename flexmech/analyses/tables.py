"""From the variables of a dataset to a table."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd
import xarray as xr
from numpy.typing import NDArray

DEGREES = math.degrees(1.0)
"""In a radian."""


def table_over(*dims: str, **columns: xr.DataArray) -> pd.DataFrame:
    """Variables side by side, with a row for each combination of indices, the last one fastest.

    A zero has no sign.

    Examples
    --------
    >>> time = xr.DataArray([0.0, 1.0], dims="time")
    >>> link = xr.DataArray(["crank", "rocker"], dims="link")
    >>> table_over("link", "time", link=link, time_s=time)["link"].tolist()
    ['crank', 'crank', 'rocker', 'rocker']
    """
    arrays = xr.broadcast(*(column.drop_vars(column.coords) for column in columns.values()))
    values = (_unsigned_zeros(array.transpose(*dims).values.ravel()) for array in arrays)
    return pd.DataFrame(dict(zip(columns, values, strict=True)))


def _unsigned_zeros(values: NDArray[Any]) -> NDArray[Any]:
    """The same, with 0 in the place of -0; what is no number stays."""
    return values + 0.0 if values.dtype.kind == "f" else values
