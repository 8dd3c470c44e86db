"""What a result says in words: tables and lines, for a terminal, a notebook or a script."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Any

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
class Summary:
    """What a result says in words.

    Parameters
    ----------
    parts : tuple of Table or str
        Tables and lines, from the first to the last.
    verdict : str
        The line that says how far the result can be trusted, after all others; may be empty.
    warnings : tuple of str
        What limits the result though it could be computed; commands write them to stderr.
    """

    parts: tuple[Table | str, ...]
    verdict: str = ""
    warnings: tuple[str, ...] = ()

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
        return {
            "tables": [table.as_data() for table in self.tables],
            "lines": [line for part in self.lines for line in part.split("\n")],
            "warnings": list(self.warnings),
            "verdict": self.verdict,
        }

    @property
    def _warned(self) -> tuple[str, ...]:
        return tuple(f"warning: {text}" for text in self.warnings)

    def __str__(self) -> str:
        return "\n".join(str(part) for part in (*self.parts, *self._warned, self.verdict) if part)

    def _repr_html_(self) -> str:
        return "".join(
            f"<p>{escape(part)}</p>" if isinstance(part, str) else part._repr_html_()
            for part in (*self.parts, *self._warned, self.verdict)
            if part
        )
