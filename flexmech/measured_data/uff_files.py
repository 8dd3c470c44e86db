"""Universal files (UFF) of modal tests, written and read through pyuff (extra ``modal-test``).

Data sets: 151 header, 164 units, 18 frames, 15 nodes, 58 functions at nodes, 55
modes at nodes. Their formats are those of the Structural Dynamics Research Laboratory, University
of Cincinnati. All is written in SI units, as text: functions with 12 digits, their first abscissa
and its step, nodes, frames and modes with 6.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError, missing_extra, one_line
from flexmech.files import given_path, moved_into
from flexmech.measured_data.record import GREATEST, MeasuredQuantity, MeasuredRecord
from flexmech.measured_data.uff_datasets import contents_of, datasets_of
from flexmech.measured_data.uff_units import UffFile, UffFunction

# Most bytes of a universal file: some hundred functions of ten thousand lines, as text.
MOST_BYTES = 200_000_000


def check_uff() -> None:
    """Refuse to begin where pyuff is missing.

    Raises
    ------
    InputError
        It says what to install.
    """
    if find_spec("pyuff") is None:
        raise missing_extra("a universal file", "pyuff", "modal-test")


def write_uff(path: str | PathLike[str], contents: UffFile) -> Path:
    """Write a universal file, whole or not at all.

    Parameters
    ----------
    path : path-like
        Replaced if it exists. Its ending is ``.uff`` or ``.unv`` by custom.
    contents : UffFile

    Returns
    -------
    Path

    Raises
    ------
    InputError
        pyuff is not installed, the folder does not exist or cannot be written, values are not
        finite, or a function is unevenly spaced.
    """
    check_uff()
    import pyuff

    target = given_path(path)
    if not target.parent.is_dir():
        raise InputError(f"{target}: there is no folder {target.parent}; make it first")
    datasets = datasets_of(contents)
    with moved_into(target.parent) as temporary:
        pyuff.UFF(str(temporary / target.name)).write_sets(datasets, mode="overwrite")
    return target


def read_uff(path: str | PathLike[str]) -> UffFile:
    """Read a universal file.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    UffFile
        In SI units; functions without a known unit as they stand.

    Raises
    ------
    InputError
        pyuff is not installed, or the file cannot be read or is no universal file.
    """
    check_uff()
    import pyuff

    file = given_path(path)
    if not file.is_file():
        raise InputError(f"{file}: there is no such file; name a universal file (.uff, .unv)")
    if file.stat().st_size > MOST_BYTES:
        raise InputError(
            f"{file}: is larger than a universal file can be here ({MOST_BYTES // 1_000_000} MB); "
            "export fewer functions or lines"
        )
    try:
        with _plain_exponents(file) as plain:
            reader = pyuff.UFF(str(plain))
            datasets = [reader.read_sets(number) for number in range(reader.get_n_sets())]
        if not datasets:
            raise InputError(
                f"{file}: holds no data set of a universal file; its lines of '    -1' are missing"
            )
        return contents_of(datasets)
    except InputError as error:
        raise error if str(file) in error.message else error.within(str(file)) from error
    except Exception as error:
        # pyuff raises bare Exceptions, and whatever NumPy raises, for what it cannot read.
        raise InputError(
            f"{file}: cannot be read as a universal file: {one_line(str(error))}; export it anew, "
            "as text (ASCII)"
        ) from error


@contextmanager
def _plain_exponents(file: Path) -> Iterator[Path]:
    """The file, or a copy whose numbers have the exponents that pyuff reads.

    Fortran writes ``1.5D-03`` for a number of double precision. A binary data set is left alone.
    """
    content = file.read_bytes()
    if _BINARY.search(content) or not _DOUBLE.search(content):
        yield file
        return
    lines = content.splitlines(keepends=True)
    with TemporaryDirectory() as folder:
        copy = Path(folder) / file.name
        copy.write_bytes(
            b"".join(
                _DOUBLE.sub(rb"\1E", line) if _NUMBERS.fullmatch(line) else line for line in lines
            )
        )
        yield copy


# Marks of a binary data set 58, an exponent of double precision, and a line of numbers alone.
_BINARY = re.compile(rb"^ *58b", re.MULTILINE | re.IGNORECASE)
_DOUBLE = re.compile(rb"(\d*\.\d*)[Dd](?=[+-]?\d)")
_NUMBERS = re.compile(rb"[\s0-9.+\-DdEe]+")


def read_uff_record(path: str | PathLike[str]) -> MeasuredRecord:
    """Read the functions of a universal file as one record.

    Frequency-response functions make a record over frequency. Without any, functions of time make
    one over time. Where functions are over several abscissae, those over the first one's are taken.

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
    responses = [
        function for function in contents.functions if function.kind == "frequency response"
    ]
    over = "frequency" if responses else "time"
    taken = [function for function in contents.functions if function.abscissa == over]
    if not taken:
        raise InputError(
            f"{path}: holds no function over time or frequency (data set 58); export the records "
            "or the frequency-response functions"
        )
    position = (responses or taken)[0].position
    quantities, unreadable = [], {}
    for name, function in zip(_names(taken), taken, strict=True):
        if function.unit is None:
            unreadable[name] = f"{path}: the function {name!r} {function.problem or 'has no unit'}"
        elif not _same(function.position, position):
            unreadable[name] = (
                f"{path}: the function {name!r} has another {over} than the first; export it alone"
            )
        elif not np.all(np.isfinite(function.values)):
            unreadable[name] = f"{path}: the function {name!r} has gaps; export it without"
        elif np.abs(function.values).max(initial=0.0) > GREATEST:
            unreadable[name] = (
                f"{path}: the function {name!r} has values beyond all that is measured; export it "
                "in other units"
            )
        else:
            quantities.append(MeasuredQuantity(name, function.unit, function.values, name))
    return MeasuredRecord(
        "frequency" if responses else "time", position, tuple(quantities), str(path), unreadable
    )


def _names(functions: list[UffFunction]) -> list[str]:
    """A name for each function."""
    names = ["_".join(function.name.split()) for function in functions]
    count = Counter(names)
    return [
        name if name and count[name] == 1 else _by_nodes(function)
        for name, function in zip(names, functions, strict=True)
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
