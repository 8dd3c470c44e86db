"""Details of a result: table of quantities, notes, and how far two engines are apart."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import SupportsFloat

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.summary import Table, speed_text
from flexmech.arrays import FloatArray
from flexmech.plots.reading import speed_unit

Range = tuple[float, float]
"""From one crank speed to another in rad/s."""


def details_table(quantities: Iterable[Quantity]) -> tuple[Table, ...]:
    """Table of quantities with units, errors and what each is of; none without quantities.

    Parameters
    ----------
    quantities : iterable of Quantity
        Those that are not finite are left out; counts, which are integers, have all digits.

    Returns
    -------
    tuple of Table

    Examples
    --------
    >>> print(*details_table([Quantity("mesh_error", 0.0123, "%", of="f1")]))
    details
    quantity    of    value  unit  error
    ------------------------------------
    mesh error  f1  0.01230     %
    """
    rows = tuple(
        (
            one.name.replace("_", " "),
            one.of,
            str(one.value) if isinstance(one.value, int) else rounded(one.value, one.error),
            one.unit,
            f"{one.error:.1g}" if math.isfinite(one.error) and one.error else "",
        )
        for one in quantities
        if math.isfinite(one.value)
    )
    headings = ("quantity", "of", "value", "unit", "error")
    return (Table("details", headings, (rows,), text_columns=2),) if rows else ()


@cache
def notes_of(package: str) -> Mapping[str, str]:
    """Notes on how numbers were found and what they leave out, by their keys.

    Parameters
    ----------
    package : str
        Folder of an analysis, whose ``schema.toml`` has a table ``notes``.

    Returns
    -------
    mapping of str to str
    """
    text = resources.files(package).joinpath("schema.toml").read_text("utf-8")
    return {key: " ".join(note.split()) for key, note in tomllib.loads(text)["notes"].items()}


def engines_line(
    dataset: xr.Dataset, apart: FloatArray, what: str, names: Sequence[str] = ()
) -> str:
    """How far two engines differ at most and at which crank speed, or that one alone ran.

    Parameters
    ----------
    dataset : xarray.Dataset
    apart : ndarray, shape (S, ...)
        Difference of the first two engines at the crank speeds; empty of a single engine.
    what : str
        What differs, such as ``"frequencies"``.
    names : sequence of str, optional
        Places along the second dimension, such as branches.

    Returns
    -------
    str
    """
    engines = [str(name) for name in dataset["engine"].values]
    if len(engines) < 2:
        return f"engines: no comparison was made, only the {engines[0]} engine ran"
    if not np.isfinite(apart).any():
        return "engines: no comparison is possible, at no speed have both a result"
    place = np.unravel_index(int(np.nanargmax(apart)), apart.shape)
    where = [speed_name(dataset, dataset["crank_speed"][int(place[0])])]
    where += [names[int(place[1])]] if names else []
    return (
        f"engines: {what} of {engines[0]} and {engines[1]} differ by at most "
        f"{float(np.nanmax(apart)):.1e}, at {', '.join(where)}"
    )


def speed_name(dataset: xr.Dataset, speed: SupportsFloat) -> str:
    """A crank speed in rad/s, to six digits in the unit in which a result speaks of speeds."""
    unit = speed_unit(dataset)
    return f"{speed_text(speed, unit)} {unit}"


def ranges_text(ranges: Sequence[Range], unit: str) -> str:
    """Ranges of crank speed in words, such as ``"from 100 to 500 and at 600 rpm"``."""
    texts = ([speed_text(speed, unit) for speed in dict.fromkeys(ends)] for ends in ranges)
    said = (f"{'from' if ends[1:] else 'at'} {' to '.join(ends)}" for ends in texts)
    return f"{' and '.join(said)} {unit}"
