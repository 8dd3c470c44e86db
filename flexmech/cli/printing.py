"""What a command prints: a summary in words, as JSON for scripts, or nothing; its progress."""

from __future__ import annotations

import json
import shutil
import sys
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Literal

import typer

from flexmech.errors import one_line

if TYPE_CHECKING:
    from pathlib import Path

    from flexmech.analyses import Summary, Table
    from flexmech.arrays import LabelledProgress

Printing = Literal["words", "json", "nothing"]
"""How a summary is printed."""

# Columns where there is no terminal that has a number of them.
_WIDTH = 80
# Words of a table break into lines of this many letters at least.
_SHORTEST_WORDS = 10
# Columns of the terminal between two of the table's.
_FRAME = 3


def say(
    summary: Summary,
    files: Sequence[Path] = (),
    file_lines: Sequence[str] = (),
    remarks: Sequence[str] = (),
    printing: Printing = "words",
) -> None:
    """Print what is to be said of a result to stdout, and its warnings to stderr.

    Parameters
    ----------
    summary : Summary
    files : sequence of Path
        That were written.
    file_lines : sequence of str
        How the files are named, and stale ones beside them.
    remarks : sequence of str
        Before all others; may be empty.
    printing : {"words", "json", "nothing"}
    """
    remark = "\n".join(filter(None, remarks))
    if printing == "json":
        content = summary.as_data()
        content["lines"][:0] = filter(None, [remark])
        content["files"] = [str(file) for file in files]
        typer.echo(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))
    elif printing == "words":
        for part in (*filter(None, [remark]), *summary.parts, *file_lines):
            if isinstance(part, str):
                _print_lines(part)
            else:
                _print_table(part)
    for warning in summary.warnings:
        typer.echo(f"warning: {warning}", err=True)
    if summary.verdict and printing == "words":
        _print_lines(summary.verdict)


def _page_width() -> int:
    """Columns of the terminal, or those that the environment variable COLUMNS names."""
    return shutil.get_terminal_size((_WIDTH, 24)).columns


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
    natural = sum(max(map(len, column)) + _FRAME for column in columns) + 1
    drawn = RichTable(title=escape(one_line(table.title)), caption=escape(table.caption) or None)
    least = 1
    for number, (heading, *cells) in enumerate(columns):
        if number < table.text_columns:
            # A cut name would lose what stands behind it.
            shortest = min(_SHORTEST_WORDS, max(map(len, (heading, *cells))))
            drawn.add_column(heading, overflow="fold", min_width=shortest)
            least += shortest + _FRAME
            continue
        broken = heading.replace(" ", "\n") if natural > page else heading
        drawn.add_column(broken, justify="right", no_wrap=True)
        least += max(map(len, (*broken.split("\n"), *cells))) + _FRAME
    for group in table.groups:
        for row in group:
            drawn.add_row(*(escape(one_line(cell)) for cell in row))
        drawn.add_section()
    Console(width=max(page, least)).print(drawn)


@contextmanager
def progress_bar() -> Iterator[LabelledProgress | None]:
    """Show a progress bar for each label on stderr; None where that is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich import progress
    from rich.console import Console

    columns = (
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeElapsedColumn(),
    )
    with progress.Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, progress.TaskID] = {}

        def show(label: str, done: int, total: int) -> None:
            if label not in tasks:
                tasks[label] = bars.add_task(label, total=total)
            bars.update(tasks[label], completed=done, total=total)

        yield show
