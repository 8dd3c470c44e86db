"""Labelled datasets of results: where they come from, units of their variables, and tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache
from importlib.metadata import version
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.linkages import RigidMotion
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism


@cache
def _version(package: str) -> str:
    return version(package)


def origin(mechanism: Mechanism, *packages: str) -> dict[str, str | int]:
    """Attributes that tell a mechanism, its model file, and the versions of packages."""
    source = mechanism.provenance
    return {
        "mechanism": source.name,
        "source": source.source,
        "model_file": source.file,
        "model_sha256": source.sha256,
        "model_text": source.text,
        **versions(*packages),
    }


def versions(*packages: str) -> dict[str, str]:
    """Attributes that tell the versions of flexmech, of what it computes with, and of packages."""
    return {f"{name}_version": _version(name) for name in ("flexmech", "numpy", "scipy", *packages)}


def provenance(engines: Sequence[Engine]) -> dict[str, str | int]:
    """Attributes of a result of engines, all of one mechanism."""
    packages = ["exudyn"] if any(e.name == "exudyn" for e in engines) else []
    speeds = " ".join(map(repr, map(float, engines[0].mechanism.operating_speeds)))
    named = origin(engines[0].mechanism, *packages)
    return {**named, "elements": engines[0].elements, "operating_speeds": speeds}


# In a radian.
DEGREES = math.degrees(1.0)


# Columns of a table: variables of a dataset, or values that it does not hold, by their names.
Columns = dict[str, str | xr.DataArray]


def table_of(
    dataset: xr.Dataset, dims: Sequence[str], columns: Mapping[str, str | xr.DataArray]
) -> pd.DataFrame:
    """Variables side by side, with a row for each combination of indices, the last one fastest.

    A zero has no sign.

    Parameters
    ----------
    dataset : xarray.Dataset
    dims : sequence of str
        Over which the rows go; each column is over some of them.
    columns : mapping of str to str or DataArray
        By the names of the columns: variables of the dataset, or values that it does not hold.
        A variable whose column ends in ``_deg`` is in rad, and in degrees in the table.

    Returns
    -------
    pandas.DataFrame

    Examples
    --------
    >>> data = xr.Dataset(coords={"link": ["crank", "rocker"], "time": [0.0, 1.0]})
    >>> table_of(data, ("link", "time"), {"link": "link", "time_s": "time"})["link"].tolist()
    ['crank', 'crank', 'rocker', 'rocker']
    """
    found = {
        column: column_of(dataset, column, of) if isinstance(of, str) else of
        for column, of in columns.items()
    }
    arrays = xr.broadcast(*(column.drop_vars(column.coords) for column in found.values()))
    values = (array.transpose(*dims).values.ravel() for array in arrays)
    # Zero is added to numbers so that none is -0.
    unsigned = (each + 0.0 if each.dtype.kind == "f" else each for each in values)
    return pd.DataFrame(dict(zip(columns, unsigned, strict=True)))


def with_terms(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with ``rotation_terms_counted``, where some are not."""
    counted = str(dataset.attrs.get("rotation_terms", "on"))
    return dataset if counted == "on" else dataset.assign(rotation_terms_counted=counted)


def column_of(dataset: xr.Dataset, column: str, name: str) -> xr.DataArray:
    """Values of a variable in a column's unit.

    Parameters
    ----------
    dataset : xarray.Dataset
    column, name : str
        Names of the column and of the variable.

    Returns
    -------
    xarray.DataArray
    """
    values = dataset[name]
    if not column.endswith("_deg"):
        return values
    degrees = DEGREES * values
    # Crank angles are asked for in degrees: beyond nine places stands the round-off of turning
    # them into rad and back, 1e-13 deg of a turn.
    return degrees.round(9) if name == "crank_angle" else degrees


def columns_along(form: str, variable: xr.DataArray, dim: str) -> dict[str, xr.DataArray]:
    """A column for each place along a dimension, such as a link or an axis.

    Parameters
    ----------
    form : str
        Form of the columns' names, such as ``"{}_peak_deflection_m"``.
    variable : DataArray
    dim : str
        With coordinates, which stand in the names.

    Returns
    -------
    dict of str to DataArray
    """
    return {form.format(place): variable.sel({dim: place}) for place in variable[dim].values}


Row = TypeVar("Row")
# Type of a column, and the attribute of a row or the function of it that is the value.
Column = tuple[type, str | Callable[[Row], Any]]
PLAIN_TYPES = {"int": np.intp, "float": float, "bool": bool, "str": str}


def columns_of(kind: type) -> dict[str, Column[Any]]:
    """Columns for the fields of a data class, each a number, a flag or a text."""
    return {field.name: (PLAIN_TYPES[str(field.type)], field.name) for field in fields(kind)}


def records(
    dimension: str, rows: Sequence[tuple[Engine, Row]], columns: Mapping[str, Column[Row]]
) -> dict[str, tuple[str, NDArray[Any]]]:
    """Variables over a dimension, one for each column, named like ``band_order``.

    Parameters
    ----------
    dimension : str
    rows : sequence of tuple of Engine and object
        Each with the engine that it is of, which is the column ``engine``.
    columns : mapping of str to tuple

    Returns
    -------
    dict of str to tuple of str and ndarray
    """
    names = np.array([engine.name for engine, _ in rows], dtype=str)
    found: dict[str, tuple[str, NDArray[Any]]] = {f"{dimension}_engine": (dimension, names)}
    for name, (kind, value) in columns.items():
        read = attrgetter(value) if isinstance(value, str) else value
        found[f"{dimension}_{name}"] = dimension, np.array([read(row) for _, row in rows], kind)
    return found


def filled(
    shape: tuple[int, ...], entries: Iterable[tuple[tuple[int, ...], Any]], otherwise: Any = np.nan
) -> NDArray[Any]:
    """Array with entries at places, each at the beginning of the dimensions that are left.

    Parameters
    ----------
    shape : tuple of int
    entries : iterable of tuple
        Places, of the first dimensions, and values there: numbers, arrays or texts.
    otherwise : float or str
        Where there is none.

    Returns
    -------
    ndarray

    Examples
    --------
    >>> filled((2, 3), [((1,), np.array([5.0, 6.0]))]).tolist()
    [[nan, nan, nan], [5.0, 6.0, nan]]
    """
    kind = object if isinstance(otherwise, str) else float
    array = np.full(shape, otherwise, dtype=kind)
    for place, value in entries:
        found = np.asarray(value, dtype=kind)
        index: tuple[int | slice, ...] = (*place, *(slice(size) for size in found.shape))
        array[index] = found
    return array.astype(str) if kind is object else array


def engine_coordinates(engines: Sequence[Engine]) -> dict[str, Any]:
    """Names of the engines, and the elements of each."""
    return {
        "engine": [engine.name for engine in engines],
        "element": ("engine", [engine.element for engine in engines]),
        "elements": ("engine", [engine.elements for engine in engines]),
    }


def rigid_positions(engine: Engine, motion: RigidMotion) -> FloatArray:
    """Stations of the undeformed links in ground axes.

    Parameters
    ----------
    engine : Engine
        Whose stations they are.
    motion : RigidMotion
        Batch of shape (B,).

    Returns
    -------
    ndarray, shape (B, n_links, n_stations, 2)
        In m.
    """
    parts = []
    for number, (link, body) in enumerate(
        zip(engine.links, engine.mechanism.linkage.topology.links, strict=True)
    ):
        places = np.linspace(0.0, body.length, len(link.shape))
        parts.append(np.stack([motion.position(number, float(x)) for x in places], axis=1))
    return np.stack(parts, axis=1)


def attributes_of(owner: object, *names: str) -> dict[str, Any]:
    """Some attributes of an object by their names, as those of a dataset."""
    return {name: getattr(owner, name) for name in names}


def complex_parts(name: str, values: NDArray[Any]) -> dict[str, FloatArray]:
    """Variables for the real and the imaginary part: files hold real numbers alone.

    Parameters
    ----------
    name : str
        Name of the variables, without ``_real`` and ``_imag``.
    values : ndarray of complex

    Returns
    -------
    dict of str to ndarray
    """
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def padded(rows: Sequence[FloatArray], size: int) -> FloatArray:
    """Arrays whose last axes differ in length in one, NaN beyond their ends.

    Parameters
    ----------
    rows : sequence of ndarray, shape (..., k)
        k differs from one to the next.
    size : int
        Size of the last axis.

    Returns
    -------
    ndarray, shape (n, ..., size)
    """
    kind = np.result_type(float, *rows)
    table = np.full((len(rows), *rows[0].shape[:-1], size), np.nan * np.ones(1, kind)[0], kind)
    for place, row in zip(table, rows, strict=True):
        place[..., : row.shape[-1]] = row
    return table
