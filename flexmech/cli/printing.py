"""What a command prints: its summary in words, as JSON for scripts, or nothing."""

from __future__ import annotations

import functools
import inspect
import json
import shutil
import sys
import textwrap
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flexmech.errors import InputError, one_line

if TYPE_CHECKING:
    from pathlib import Path

    from flexmech.analyses import Summary, Table


# Columns where there is no terminal that has a number of them.
WIDTH = 80
# Words of a table break into lines of this many letters at least.
SHORTEST_WORDS = 10
# Columns of the terminal between two of the table's.
FRAME = 3

Quiet = Annotated[bool, typer.Option("--quiet", help="Print warnings and errors alone.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the summary as JSON, for scripts.")]


@dataclass(frozen=True)
class _Asked:
    quiet: bool = False
    as_json: bool = False


_asked: ContextVar[_Asked | None] = ContextVar("_asked", default=None)


def prints_as_asked(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options ``--quiet`` and ``--json``.

    Parameters
    ----------
    command : callable
        A typer command that delivers a result.

    Returns
    -------
    callable
        The same command with two options more.
    """
    signature = inspect.signature(command, eval_str=True)
    further = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=kind)
        for name, kind in (("quiet", Quiet), ("as_json", AsJson))
    ]

    @functools.wraps(command)
    def wrapped(*args: Any, quiet: bool = False, as_json: bool = False, **kwargs: Any) -> None:
        if quiet and as_json:
            raise InputError("--quiet and --json: give one of them")
        token = _asked.set(_Asked(quiet, as_json))
        try:
            command(*args, **kwargs)
        finally:
            _asked.reset(token)

    parameters = [*signature.parameters.values(), *further]
    wrapped.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {each.name: each.annotation for each in parameters}
    return wrapped


@dataclass(frozen=True)
class Report:
    """What is to be said of a delivered result.

    Parameters
    ----------
    summary : Summary
    files : tuple of Path
        That were written.
    file_lines : tuple of str
        How the files are named, and stale ones beside them.
    remark : str
        Line before all others; may be empty.
    """

    summary: Summary
    files: tuple[Path, ...] = ()
    file_lines: tuple[str, ...] = ()
    remark: str = ""

    def print(self) -> None:
        """Print to stdout in the way that the user asked for, and warnings to stderr."""
        asked = _asked.get() or _Asked()
        if asked.as_json:
            typer.echo(json.dumps(self._content(), indent=2, ensure_ascii=False, allow_nan=False))
        elif not asked.quiet:
            self._print_words()
        for warning in self.summary.warnings:
            typer.echo(f"warning: {warning}", err=True)
        if self.summary.verdict and not asked.as_json and not asked.quiet:
            _print_lines(self.summary.verdict)

    def _print_words(self) -> None:
        if self.remark:
            _print_lines(self.remark)
        for part in self.summary.parts:
            if isinstance(part, str):
                _print_lines(part)
            else:
                _print_table(part)
        for line in self.file_lines:
            _print_lines(line)

    def _content(self) -> dict[str, Any]:
        """What JSON says; numbers of tables are numbers, and what a cell leaves out is null."""
        lines = [line for part in self.summary.lines for line in part.split("\n")]
        return {
            "tables": [_table_content(table) for table in self.summary.tables],
            "lines": [*([self.remark] if self.remark else []), *lines],
            "warnings": list(self.summary.warnings),
            "verdict": self.summary.verdict,
            "files": [str(file) for file in self.files],
        }


def _table_content(table: Table) -> dict[str, Any]:
    return {
        "title": table.title,
        "columns": list(table.headings),
        "rows": [
            [
                cell if number < table.text_columns else _value(cell)
                for number, cell in enumerate(row)
            ]
            for group in table.groups
            for row in group
        ],
        "caption": table.caption,
    }


def _value(cell: str) -> float | str | None:
    """A number where a cell is one, else its text."""
    if cell in ("", "-"):
        return None
    try:
        return float(cell)
    except ValueError:
        return cell


def _page_width() -> int:
    """Columns of the terminal, or those that the environment variable COLUMNS names."""
    return shutil.get_terminal_size((WIDTH, 24)).columns


def _print_lines(text: str) -> None:
    """Print lines in which names cannot move the cursor.

    They wrap at words on a terminal; a pipe gets each of them whole, as scripts want it.
    """
    for line in text.split("\n"):
        shown = one_line(line, most=len(line))
        if sys.stdout.isatty() and len(shown) > _page_width():
            shown = textwrap.fill(
                shown,
                _page_width(),
                subsequent_indent="  ",
                break_long_words=False,
                break_on_hyphens=False,
            )
        typer.echo(shown)


def _print_table(table: Table) -> None:
    """Print with rich: headings and words may break into lines, numbers never."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table as RichTable

    columns = list(zip(table.headings, *chain(*table.groups), strict=True))
    page = _page_width()
    natural = sum(max(map(len, column)) + FRAME for column in columns) + 1
    drawn = RichTable(title=escape(one_line(table.title)), caption=escape(table.caption) or None)
    least = 1
    for number, (heading, *cells) in enumerate(columns):
        if number < table.text_columns:
            # A cut name would lose what stands behind it.
            shortest = min(SHORTEST_WORDS, max(map(len, (heading, *cells))))
            drawn.add_column(heading, overflow="fold", min_width=shortest)
            least += shortest + FRAME
            continue
        broken = heading.replace(" ", "\n") if natural > page else heading
        drawn.add_column(broken, justify="right", no_wrap=True)
        least += max(map(len, (*broken.split("\n"), *cells))) + FRAME
    for group in table.groups:
        for row in group:
            drawn.add_row(*(escape(one_line(cell)) for cell in row))
        drawn.add_section()
    Console(width=max(page, least)).print(drawn)
