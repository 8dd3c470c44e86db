"""What a result says in words: tables and lines, for a terminal, a notebook or a script."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from flexmech.analyses.digits import Quantity

Row = tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A table of texts.

    Parameters
    ----------
    title : str
    headings : tuple of str
    groups : tuple of tuple of tuple of str
        Rows, in groups with a line between them.
    text_columns : int
        How many columns hold words, on the left; the others hold numbers.
    caption : str
    """

    title: str
    headings: Row
    groups: tuple[tuple[Row, ...], ...]
    text_columns: int = 1
    caption: str = ""

    def __str__(self) -> str:
        rows = [self.headings, *(row for group in self.groups for row in group)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        rule = "-" * (sum(widths) + 2 * (len(widths) - 1))
        lines = [self.title, self._line(self.headings, widths)]
        for group in self.groups:
            lines += [rule, *(self._line(row, widths) for row in group)]
        return "\n".join([*lines, self.caption] if self.caption else lines)

    def _line(self, row: Row, widths: list[int]) -> str:
        cells = [
            text.ljust(width) if number < self.text_columns else text.rjust(width)
            for number, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        return "  ".join(cells).rstrip()

    def _repr_html_(self) -> str:
        caption = f"<p>{escape(self.caption)}</p>" if self.caption else ""
        heading = "".join(f"<th>{escape(text)}</th>" for text in self.headings)
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(text)}</td>" for text in row) + "</tr>"
            for group in self.groups
            for row in group
        )
        return (
            f"<table><caption>{escape(self.title)}</caption><thead><tr>{heading}</tr></thead>"
            f"<tbody>{rows}</tbody></table>{caption}"
        )

    def as_data(self) -> dict[str, Any]:
        """The same for JSON: what is a number is one, and what a cell leaves out is None."""
        words = self.text_columns
        rows = [row for group in self.groups for row in group]
        return {
            "title": self.title,
            "columns": list(self.headings),
            "rows": [[*row[:words], *map(_number, row[words:])] for row in rows],
            "caption": self.caption,
        }


def _number(cell: str) -> float | str | None:
    """A number where a cell is one, else its text."""
    if cell in ("", "-"):
        return None
    try:
        return float(cell)
    except ValueError:
        return cell


@dataclass(frozen=True)
class Aspect:
    """What a result says of one thing, such as a motor: its share of a summary.

    Parameters
    ----------
    answer, details, warnings, numbers : tuple
        As those of a :class:`Summary`; all are empty where there is no such thing.
    leads : bool
        Whether its answer stands before those of the others.
    """

    answer: tuple[str, ...] = ()
    details: tuple[Table | str, ...] = ()
    warnings: tuple[str, ...] = ()
    numbers: tuple[Quantity, ...] = ()
    leads: bool = False


@dataclass(frozen=True)
class Summary:
    """What a result says in words: the answer first, and all else on request.

    Parameters
    ----------
    answer : tuple of str
        One to three sentences that say what the user came for.
    table : Table, optional
        The one table that the answer rests on.
    trust : str
        The line that says how far the numbers above are known; may be empty.
    details : tuple of Table or str
        Everything else that is known, from the first to the last.
    warnings : tuple of str
        What the user must act on; commands write them to stderr, before all else.
    numbers : tuple of Quantity
        The numbers of the answer, for programs.
    """

    answer: tuple[str, ...]
    table: Table | None = None
    trust: str = ""
    details: tuple[Table | str, ...] = ()
    warnings: tuple[str, ...] = ()
    numbers: tuple[Quantity, ...] = ()

    @classmethod
    def of(
        cls,
        aspects: Sequence[Aspect],
        table: Table | None = None,
        trust: str = "",
        most: int | None = None,
    ) -> Summary:
        """The summary of what a result says of one thing after the other.

        Parameters
        ----------
        aspects : sequence of Aspect
        table : Table, optional
        trust : str
        most : int, optional
            Sentences of the answer at most: the last ones stay, and those of aspects that lead.
        """
        lead = [said for aspect in aspects if aspect.leads for said in aspect.answer]
        others = [said for aspect in aspects if not aspect.leads for said in aspect.answer]
        dropped = 0 if most is None else max(len(lead) + len(others) - most, 0)
        return cls(
            (*lead, *others[dropped:]),
            table,
            trust,
            tuple(detail for aspect in aspects for detail in aspect.details),
            tuple(warning for aspect in aspects for warning in aspect.warnings),
            tuple(number for aspect in aspects for number in aspect.numbers),
        )

    @property
    def first(self) -> tuple[Table | str, ...]:
        """Answer, table and trust: what a command prints."""
        parts = (*self.answer, self.table, self.trust)
        return tuple(part for part in parts if part)

    @property
    def parts(self) -> tuple[Table | str, ...]:
        """All of it but the warnings: what a command prints with details."""
        return (*self.first, *self.details)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The tables among the parts."""
        return tuple(part for part in self.parts if not isinstance(part, str))

    @property
    def lines(self) -> tuple[str, ...]:
        """The lines among the parts."""
        return tuple(part for part in self.parts if isinstance(part, str))

    def as_data(self) -> dict[str, Any]:
        """The same for JSON: numbers of tables are numbers, and what a cell leaves out is None."""
        lines = (part for part in self.details if isinstance(part, str))
        tables = (part for part in self.details if not isinstance(part, str))
        return {
            "answer": list(self.answer),
            "numbers": [number.as_data() for number in self.numbers],
            "table": None if self.table is None else self.table.as_data(),
            "trust": self.trust,
            "warnings": list(self.warnings),
            "details": {
                "tables": [table.as_data() for table in tables],
                "lines": [line for part in lines for line in part.split("\n")],
            },
        }

    @property
    def _whole(self) -> tuple[Table | str, ...]:
        return (*(f"warning: {text}" for text in self.warnings), *self.parts)

    def __str__(self) -> str:
        return "\n".join(map(str, self._whole))

    def _repr_html_(self) -> str:
        return "".join(
            f"<p>{escape(part)}</p>" if isinstance(part, str) else part._repr_html_()
            for part in self._whole
        )
