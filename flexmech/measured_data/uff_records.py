"""A universal file as one record: its functions over one abscissa."""

from __future__ import annotations

from collections import Counter
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.measured_data.record import GREATEST, MeasuredQuantity, MeasuredRecord
from flexmech.measured_data.uff_contents import UffFunction
from flexmech.measured_data.uff_files import read_uff
from flexmech.types import FloatArray


def read_uff_record(path: str | PathLike[str]) -> MeasuredRecord:
    """Read the functions of a universal file as one record.

    Frequency-response functions make a record over frequency. Without any, functions of time make
    one over time. Of functions over several abscissae, those over the first one's are taken.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    MeasuredRecord
        Quantities are called by the functions' names, or by what they are and by their nodes where
        that is no name for one alone. Functions without a unit and those over another abscissa are
        among ``unreadable``.

    Raises
    ------
    InputError
        As of :func:`read_uff`; or the file holds no functions over time or frequency.
    """
    contents = read_uff(path)
    responses = [each for each in contents.functions if each.kind == "frequency response"]
    over = "frequency" if responses else "time"
    taken = [each for each in contents.functions if each.abscissa == over]
    if not taken:
        raise InputError(
            f"{path}: holds no function over time or frequency (data set 58); export the records "
            "or the frequency-response functions"
        )
    position = (responses or taken)[0].position
    quantities, unreadable = [], {}
    for name, each in zip(_names(taken), taken, strict=True):
        if each.unit is None:
            unreadable[name] = (
                f"{path}: the function {name!r} has no unit; export it with data set 164, or with "
                "the units of its axes"
            )
        elif not _same(each.position, position):
            unreadable[name] = (
                f"{path}: the function {name!r} has another {over} than the first; export it alone"
            )
        elif not np.all(np.isfinite(each.values)):
            unreadable[name] = f"{path}: the function {name!r} has gaps; export it without"
        elif np.abs(each.values).max(initial=0.0) > GREATEST:
            unreadable[name] = (
                f"{path}: the function {name!r} has values beyond all that is measured; export it "
                "in other units"
            )
        else:
            quantities.append(MeasuredQuantity(name, each.unit, _values(each), name))
    return MeasuredRecord(
        "frequency" if responses else "time", position, tuple(quantities), str(path), unreadable
    )


def _values(function: UffFunction) -> FloatArray | NDArray[np.complex128]:
    if np.iscomplexobj(function.values):
        return np.asarray(function.values, dtype=np.complex128)
    return np.asarray(function.values, dtype=np.float64)


def _names(functions: list[UffFunction]) -> list[str]:
    """A name for each function."""
    names = ["_".join(each.name.split()) for each in functions]
    count = Counter(names)
    return [
        name if name and count[name] == 1 else _by_nodes(each)
        for name, each in zip(names, functions, strict=True)
    ]


def _by_nodes(function: UffFunction) -> str:
    what = function.kind.replace(" ", "_") if function.over != "none" else function.quantity
    response, reference = function.response, function.reference
    name = f"{what}_{response.node}_{response.direction:+d}"
    return f"{name}_{reference.node}_{reference.direction:+d}" if reference.node else name


def _same(position: FloatArray, first: FloatArray) -> bool:
    if position.shape != first.shape:
        return False
    step = abs(first[1] - first[0])
    return bool(np.all(abs(position - first) <= 0.1 * step))
