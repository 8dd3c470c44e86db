"""Tables of results as a page shows them: without rows none, and no wider than they must be."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from flexmech.analyses import Table

# What a cell has where there is nothing to tell.
_NOTHING = ("", "-")
_FIXED = "\N{NO-BREAK SPACE}"


def shown_tables(tables: Iterable[Table]) -> list[Table]:
    """Tables that have rows, each as narrow as it can be without loss.

    Parameters
    ----------
    tables : iterable of Table

    Returns
    -------
    list of Table
    """
    return [narrowed(table) for table in tables if any(table.groups)]


def narrowed(table: Table) -> Table:
    """A table whose columns all tell something.

    A column of words that is the same in every row goes into the title, and a column of empty cells
    is left out. A number may be parted from its error, and nowhere else.

    Parameters
    ----------
    table : Table

    Returns
    -------
    Table

    Examples
    --------
    >>> rows = (("dry", "crank", "1 ± 0.1"), ("dry", "rod", "2 ± 0.1"))
    >>> table = Table("Peaks", ("state", "of", "force (N)"), (rows,), text_columns=2)
    >>> narrowed(table).title, narrowed(table).headings
    ('Peaks (state: dry)', ('of', 'force (N)'))
    """
    rows = [row for group in table.groups for row in group]
    words = table.text_columns
    columns = [{row[number] for row in rows} for number in range(len(table.headings))]
    empty = {number for number, cells in enumerate(columns) if cells <= set(_NOTHING)}
    same = {number for number in range(words) if len(rows) > 1 and len(columns[number]) == 1}
    kept = [number for number in range(len(columns)) if number not in empty | same]
    told = [f"{table.headings[n]}: {rows[0][n]}" for n in sorted(same - empty)]
    return replace(
        table,
        title=f"{table.title} ({', '.join(told)})" if told else table.title,
        headings=tuple(table.headings[number] for number in kept),
        groups=tuple(
            tuple(tuple(row[n] if n < words else _unbroken(row[n]) for n in kept) for row in group)
            for group in table.groups
        ),
        text_columns=sum(number < words for number in kept),
    )


def _unbroken(cell: str) -> str:
    """A number that a line breaks before its error alone."""
    return cell.replace(" ", _FIXED).replace(f"{_FIXED}±", " ±")
