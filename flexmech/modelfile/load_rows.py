"""Rows of loads that vary: of a table in the model file, or of a CSV file beside it."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path

from flexmech.errors import InputError
from flexmech.modelfile.attachment_tables import LoadTable
from flexmech.plausible import LOAD, Plausible, check_plausible, of_dimension
from flexmech.units import ANGLE, FORCE, NUMBER, TIME, TORQUE, Dimension, parse_quantity

Rows = list[tuple[float, float, float]]
"""Force along x and y, and torque, of each place."""

COLUMNS = {"crank_angle": ("crank_angle_deg", "deg"), "time": ("time_s", "s")}
FORCE_COLUMNS = ("force_x_N", "force_y_N")
TORQUE_COLUMN = "torque_Nm"
MOST_BYTES = 10_000_000
# Of a cell in a message.
MOST_SHOWN = 60


def load_rows(table: LoadTable, folder: Path) -> tuple[tuple[float, ...], Rows]:
    """Places of a load, and force and torque of each.

    Parameters
    ----------
    table : LoadTable
    folder : Path
        Of the model file.

    Returns
    -------
    tuple of float
        In rad or s; empty for a load that does not vary.
    list of (float, float, float)
        In N, N and N m.

    Raises
    ------
    InputError
        If a row is none, its values have other units or sizes that none has, or the file cannot
        be read; names the row or the line.
    """
    if table.over is None:
        return (), [(*(table.force or (0.0, 0.0)), table.torque or 0.0)]
    dimensions = (ANGLE if table.over == "crank_angle" else TIME, FORCE, FORCE, TORQUE)
    if table.file is not None:
        return _of_file(folder / table.file, table.file, table.over, dimensions)
    assert table.table is not None
    if not table.table:
        raise InputError("table is empty; give at least one row")
    at: list[float] = []
    rows: Rows = []
    for number, row in enumerate(table.table):
        if len(row) not in (3, 4):
            raise InputError(
                f"table[{number}]: got {len(row)} values; give {table.over}, force along x and y, "
                "and a torque if there is one"
            )
        _append(at, rows, row, dimensions, f"table[{number}]")
    return tuple(at), rows


def _append(
    at: list[float],
    rows: Rows,
    row: Sequence[object],
    dimensions: Sequence[Dimension],
    where: str,
) -> None:
    """Add a row of quantities, each with its unit."""
    try:
        place, x, y, *torque = (
            _sized(value, dimension) for value, dimension in zip(row, dimensions, strict=False)
        )
    except InputError as error:
        raise error.within(where) from error
    at.append(place)
    rows.append((x, y, *(torque or [0.0])))  # type: ignore[arg-type]


def _sized(value: object, dimension: Dimension) -> float:
    found = parse_quantity(value, dimension)
    plausible: Plausible | None = LOAD if dimension is FORCE else of_dimension(dimension)
    if plausible is not None:
        check_plausible(found, value, plausible)
    return found


def _of_file(
    path: Path, shown: str, over: str, dimensions: Sequence[Dimension]
) -> tuple[tuple[float, ...], Rows]:
    column, unit = COLUMNS[over]
    head = [column, *FORCE_COLUMNS, TORQUE_COLUMN]
    titles, *lines = _lines(path, shown) or [[]]
    titles = [title.strip() for title in titles]
    if titles not in (head, head[:3]):
        raise InputError(f"file {shown}: its first line must be {','.join(head)}")
    if not lines:
        raise InputError(f"file {shown}: there is no row below its first line; give at least one")
    at: list[float] = []
    rows: Rows = []
    for number, line in enumerate(lines, start=2):
        where = f"file {shown}: line {number}"
        if len(line) != len(titles):
            raise InputError(f"{where} has {len(line)} fields, the first line {len(titles)}")
        wrong = next((c for c in line if not re.fullmatch(NUMBER, c.strip())), None)
        if wrong is not None:
            raise InputError(
                f"{where} has {wrong[:MOST_SHOWN]!r}, which is no number; write numbers such as "
                "12.5 or 2e-5, with a decimal point"
            )
        own = zip(line, (unit, "N", "N", "N m"), strict=False)
        _append(at, rows, [f"{cell} {of}" for cell, of in own], dimensions, where)
    return tuple(at), rows


def _lines(path: Path, shown: str) -> list[list[str]]:
    """Lines of a CSV file in fields, without empty ones at its end."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(f"file {shown}: is larger than any load; give fewer rows")
        text = path.read_text(encoding="utf-8-sig")
        lines = [*csv.reader(text.rstrip().splitlines(), strict=True)]
    except UnicodeDecodeError as error:
        raise InputError(f"file {shown}: is no text in UTF-8; save it as CSV in UTF-8") from error
    except (OSError, ValueError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"file {shown}: cannot be read: {reason}; give a CSV file") from error
    return lines
