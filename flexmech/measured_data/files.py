"""Records from files of every known kind, identified by the ending; CSV files."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.files import bytes_of, given_path
from flexmech.measured_data.headers import Header, read_header
from flexmech.measured_data.record import GREATEST, Abscissa, MeasuredQuantity, MeasuredRecord
from flexmech.measured_data.uff_files import read_uff_record
from flexmech.units import NUMBER

UFF_ENDINGS = (".uff", ".unv", ".uf", ".bunv")

SEPARATORS = ",;\t"
_NUMBER = re.compile(NUMBER)
_EMPTY = frozenset({"", "nan", "na", "n/a", "null", "none"})
# Real and imaginary part of one complex quantity, before its unit.
_PARTS = ("_real", "_imag")
# Most bytes of a record: a million lines of a few columns. In fields a line takes ten times its
# bytes.
MOST_BYTES = 50_000_000
REMEDY = "name the unit of every column, as in 'time [s], strain (um/m)' or 'time_s'"


def read_record(path: str | PathLike[str]) -> MeasuredRecord:
    r"""Read a record: a universal file by its ending, else a CSV file.

    Parameters
    ----------
    path : path-like
        A file that ends with ``.uff`` or ``.unv`` is read as a universal file.

    Returns
    -------
    MeasuredRecord

    Raises
    ------
    InputError
        If it cannot be read, or holds no record with units.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
    ...     _ = file.write("time [ms],strain (um/m)\n0,10\n1,12\n2,9\n")
    ...     file.flush()
    ...     record = flexmech.read_record(file.name)
    >>> record.abscissa, record.quantity("strain").values.max().round(9)
    ('time', np.float64(1.2e-05))
    """
    file = given_path(path)
    return read_uff_record(file) if file.suffix.lower() in UFF_ENDINGS else read_csv_record(file)


@dataclass(frozen=True)
class _Column:
    """A column of a file: its header, and its cells as they are written."""

    text: str
    header: Header
    cells: tuple[str, ...]
    lines: Sequence[int]


def read_csv_record(path: str | Path) -> MeasuredRecord:
    """Read a record from a CSV file whose header names the units.

    Fields are separated by commas, semicolons or tabulators; numbers have a decimal point.
    Lines that begin with ``#`` are comments. The record is one over time if there is a column
    of time, a frequency-response function if there are a real and an imaginary part over a
    frequency, and otherwise one over the crank angle or over frequency.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    MeasuredRecord
        In SI units. Columns without a unit, with gaps or with text are among ``unreadable``.

    Raises
    ------
    InputError
        If the file cannot be read, has no header, or no column that a record is written over.
    """
    file = given_path(path)
    table = _table(file)
    columns = _columns(table, str(file))
    abscissa, over = _abscissa(columns, str(file))
    position = _numbers(over, str(file))
    quantities, unreadable = [], {}
    for column in columns:
        if column is over:
            continue
        try:
            if column.header.unit is None:
                raise InputError(f"{file}: the column {column.text!r} has no unit; {REMEDY}")
            values = _numbers(column, str(file))
        except InputError as error:
            unreadable[column.header.name] = error.message
            continue
        quantities.append(
            MeasuredQuantity(column.header.name, column.header.unit, values, column.text)
        )
    rounding = over.header.factor * min(map(_last_digit, over.cells))
    return MeasuredRecord(
        abscissa, position, _with_complex(quantities), str(file), unreadable, rounding
    )


def _last_digit(cell: str) -> float:
    """Value of the last digit of a number."""
    mantissa, _, exponent = cell.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(10.0 ** (int(exponent or 0) - decimals))


def _table(file: Path) -> list[tuple[int, list[str]]]:
    """Lines of a file that are neither empty nor comments, with their numbers, in fields."""
    try:
        text = bytes_of(file, str(file), "a record", MOST_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{file}: is no text in UTF-8; save it as CSV in UTF-8, or give a UFF file with the "
            "ending .uff or .unv"
        ) from error
    except InputError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{file}: cannot be read: {reason}; give the record's file") from error
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise InputError(f"{file}: holds no record; give a header with units and lines of numbers")
    separator = max(SEPARATORS, key=lines[0][1].count)
    try:
        fields = csv.reader((line for _, line in lines), delimiter=separator, strict=True)
        return [(number, row) for (number, _), row in zip(lines, fields, strict=True)]
    except (csv.Error, ValueError) as error:
        raise InputError(f"{file}: is no CSV file: {error}; write one line a sample") from error


def _columns(table: list[tuple[int, list[str]]], source: str) -> list[_Column]:
    """Columns of a table whose first line is the header."""
    (_, titles), *rows = table
    if any(_NUMBER.fullmatch(title.strip()) for title in titles):
        raise InputError(f"{source}: has no header; {REMEDY}")
    for number, row in rows:
        if len(row) != len(titles):
            hint = "; write numbers with a decimal point" if len(row) > len(titles) else ""
            raise InputError(
                f"{source}: line {number} has {len(row)} fields, the header {len(titles)}{hint}; "
                "give one number for each column"
            )
    lines = [number for number, _ in rows]
    cells = zip(*(row for _, row in rows), strict=True)
    headers = []
    for title in titles:
        try:
            headers.append(read_header(title))
        except InputError as error:
            raise error.within(source) from error
    names = [header.name for header in headers]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"{source}: two columns are named {twice!r}; name each differently")
    parts = zip(titles, headers, cells, strict=True)
    return [_Column(title.strip(), header, values, lines) for title, header, values in parts]


def _abscissa(columns: list[_Column], source: str) -> tuple[Abscissa, _Column]:
    """Abscissa of the record, and its column."""

    def first(unit: str, word: str) -> _Column | None:
        candidates = [c for c in columns if c.header.unit == unit and word in c.header.name.lower()]
        return candidates[0] if candidates else None

    time = first("s", "time") or first("s", "t")
    angle, frequency = first("rad", "angle"), first("Hz", "freq") or first("Hz", "f")
    is_complex = any(c.header.name.lower().endswith(_PARTS[1]) for c in columns)
    if time is not None:
        return "time", time
    if frequency is not None and is_complex:
        return "frequency", frequency
    if angle is not None:
        return "crank_angle", angle
    if frequency is not None:
        return "frequency", frequency
    bare = [c.text for c in columns if c.header.unit is None]
    without = f"; {', '.join(map(repr, bare[:5]))} without a unit" if bare else ""
    raise InputError(
        f"{source}: has no column of time, crank angle or frequency with a unit{without}; {REMEDY}"
    )


def _numbers(column: _Column, source: str) -> FloatArray:
    """Values of a column in SI units; gaps and text are refused with their line."""
    values = np.empty(len(column.cells))
    for index, cell in enumerate(column.cells):
        bare = cell.strip()
        if not _NUMBER.fullmatch(bare):
            line = column.lines[index]
            if bare.lower() in _EMPTY:
                raise InputError(
                    f"{source}: line {line} has no value of {column.text!r}; give a part of the "
                    "record without gaps"
                )
            raise InputError(
                f"{source}: line {line} has {bare[:60]!r} in the column {column.text!r}, which is "
                "no number; write numbers such as 12.5 or 2e-5, with a decimal point"
            )
        values[index] = float(bare)
    values *= column.header.factor
    measured = np.abs(values) <= GREATEST
    if not measured.all():
        line = column.lines[int(np.flatnonzero(~measured)[0])]
        raise InputError(
            f"{source}: line {line} has a number in {column.text!r} that is too large; correct it"
        )
    return values


def _with_complex(quantities: list[MeasuredQuantity]) -> tuple[MeasuredQuantity, ...]:
    """Real and imaginary parts become one complex quantity."""
    by_name = {quantity.name: quantity for quantity in quantities}
    found = []
    for quantity in quantities:
        stem, ending = quantity.name[:-5], quantity.name[-5:].lower()
        other = by_name.get(stem + _PARTS[1 - _PARTS.index(ending)]) if ending in _PARTS else None
        if other is None or other.unit != quantity.unit:
            found.append(quantity)
        elif ending == _PARTS[0]:
            values = np.asarray(quantity.values + 1j * other.values, dtype=complex)
            found.append(MeasuredQuantity(stem, quantity.unit, values, stem))
    return tuple(found)
