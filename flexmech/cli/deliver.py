"""From a computation to what the user gets: files, pictures, and the answer on the terminal.

Warnings come first, then the answer, its table, how far it is known, and the files; all else on
request and in a file. Programs get JSON.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import sys
import textwrap
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import typer

from flexmech.choices import PICTURE_FORMATS, PageWidth, PictureFormat
from flexmech.cli.failures import telling
from flexmech.crank_values import Speeds
from flexmech.errors import naming, one_line
from flexmech.files import check_writable, given_path, moved_into, named_files

if TYPE_CHECKING:
    from flexmech.analyses import Result, Summary, Table
    from flexmech.arrays import LabelledProgress
    from flexmech.mechanism import Mechanism

Printing = Literal["answer", "details", "json", "nothing"]
"""Printed part of a summary, and its form."""

SUMMARIES = "summary.txt"
"""File beside the others that holds all that the command has found."""

# Words of a table break into lines of this many letters at least, as most names of links have.
_SHORTEST_WORDS = 10
# Columns of the terminal between two of the table's.
_FRAME = 3
Found = TypeVar("Found", bound="Result")
# In s, of lines that tell progress where there is no terminal.
_BETWEEN_LINES = 30.0
_running: ContextVar[tuple[str, ...]] = ContextVar("_running", default=())


def typed_path(text: str | os.PathLike[str]) -> Path:
    """Path of an option or argument; an empty one, which would be the working folder, is refused.

    A script passes one where a variable of it is not set.
    """
    if text == "":
        raise typer.BadParameter(
            "it is empty; name a file or folder, or write . for the working folder"
        )
    return Path(text)


def mechanism_of(model: Path) -> Mechanism:
    """Mechanism of a model file."""
    from flexmech.modelfile import load_mechanism

    return load_mechanism(model)


@dataclass(frozen=True)
class Pictures:
    """Pictures that a command writes, details too or not; no formats where none are wanted."""

    formats: tuple[PictureFormat, ...] = ("png",)
    width: PageWidth = "two-column"
    details: bool = False


@dataclass(frozen=True)
class Output:
    """A folder for the files, if any, the pictures among them, and how the summary is printed."""

    folder: Path | None
    pictures: Pictures = Pictures()
    printing: Printing = "answer"


def command_line() -> str:
    """The command line that is run, as a shell takes it; empty where none is run."""
    line = shlex.join(_running.get())
    # Bytes of a file's name that are no text, which files of results cannot hold, as escapes.
    return line.encode(errors="backslashreplace").decode()


def command_name() -> str:
    """Name of the command that is run; empty where none is run."""
    return "".join(_running.get()[1:2])


@contextmanager
def running(arguments: Sequence[str]) -> Iterator[None]:
    """Keep the command line while it is run."""
    token = _running.set(("flexmech", *arguments))
    try:
        yield
    finally:
        _running.reset(token)


def deliver(
    kind: type[Found],
    compute: Callable[[LabelledProgress | None], Found],
    output: Output,
    *,
    model: Path | None = None,
    record: Path | None = None,
    speeds: Speeds | None = None,
    further: Callable[[Found, Path, LabelledProgress | None], list[Path]] | None = None,
    remark: str = "",
    saving: Mapping[str, Any] | None = None,
    in_lines: bool = False,
) -> Found:
    """Compute a result, write its files and print its summary.

    Parameters
    ----------
    kind : type of Result
        What will be computed: its files are checked for before the long work.
    compute : callable
        Takes what shows the progress, or None.
    output : Output
    model : Path, optional
        Model file, which messages name.
    record : Path, optional
        Another file of the user: messages that name it do not name the model.
    speeds : Speeds, optional
        In whose unit messages speak of crank speeds.
    further : callable, optional
        Writes further files of the result into a folder and gives their paths; takes the
        progress too.
    remark : str
        Line below the summary.
    saving : mapping, optional
        Further options of the result's own way to save.
    in_lines : bool
        Whether progress is printed in lines where there is no terminal for a bar.

    Returns
    -------
    Result

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    speeds = speeds or Speeds(())
    out, formats = output.folder, output.pictures.formats
    if out is not None:
        with naming("--out"):
            out = given_path(out)
            check_writable(out, kind.file_patterns(formats))
    with progress_bar(in_lines=in_lines) as progress:
        with telling(model, speeds.unit, record):
            result = compute(progress)
            # Nothing is written before everything is computed.
            summary = result.summary()
        # Files first: what is printed has been kept.
        files, models = list[Path](), list[str]()
        if out is not None:
            if formats:
                import matplotlib

                # A matplotlibrc of the user may set what is not there, such as text by a TeX: the
                # pictures of a command are the same on all machines.
                matplotlib.rcdefaults()
            with naming("--out"), moved_into(out) as whole:
                files = result.save(
                    whole,
                    figures=bool(formats),
                    details=output.pictures.details,
                    formats=formats,
                    width=output.pictures.width,
                    command_line=command_line(),
                    **saving or {},
                )
                if further is not None:
                    files += further(result, whole, progress)
                # Moved with the others: the folder holds what one run has found.
                text = f"{result.title}\n{summary}".rstrip() + "\n"
                (whole / SUMMARIES).write_text(text, encoding="utf-8", newline="\n")
            files = [out / file.relative_to(whole) for file in files] + [out / SUMMARIES]
            models = [f"model file: {one_line(str(out / name))}" for name in result.texts()]
    lines = () if out is None else named_files(out, files, kind.file_patterns(PICTURE_FORMATS))
    say(summary, files, lines, (speeds.remark, remark, *models), output.printing)
    return result


def say(
    summary: Summary,
    files: Sequence[Path] = (),
    file_lines: Sequence[str] = (),
    remarks: Sequence[str] = (),
    printing: Printing = "answer",
) -> None:
    """Print the warnings of a result to stderr, then what is to be said of it to stdout.

    Parameters
    ----------
    summary : Summary
    files : sequence of Path
        That were written.
    file_lines : sequence of str
        How the files are named, and stale ones beside them.
    remarks : sequence of str
        Below the answer; may be empty.
    printing : {"answer", "details", "json", "nothing"}
    """
    for warning in summary.warnings:
        typer.echo(f"warning: {warning}", err=True)
    said = [remark for remark in remarks if remark]
    if printing == "json":
        content = summary.as_data()
        content["details"]["lines"][:0] = said
        content["files"] = [str(file) for file in files]
        typer.echo(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))
    elif printing != "nothing":
        parts = summary.parts if printing == "details" else summary.first
        for part in (*parts, *said, *file_lines):
            if isinstance(part, str):
                _print_lines(part)
            else:
                _print_table(part)


def _page_width() -> int:
    """Columns of the terminal, or those that the environment variable COLUMNS names."""
    return shutil.get_terminal_size().columns


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
    Console(width=max(page, least), height=page).print(drawn)


@contextmanager
def progress_bar(*, in_lines: bool = False) -> Iterator[LabelledProgress | None]:
    """Show a progress bar for each label on stderr, or lines or nothing where that is no terminal.

    Parameters
    ----------
    in_lines : bool
        Whether lines, one every half minute.

    Yields
    ------
    callable or None
    """
    if not sys.stderr.isatty():
        yield _told_in_lines(time.monotonic()) if in_lines else None
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


def _told_in_lines(begun: float) -> LabelledProgress:
    """Progress in a line on stderr, every half minute."""
    last = begun

    def tell(label: str, done: int, total: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _BETWEEN_LINES:
            last = now
            typer.echo(f"{label}: {done} of {total} after {now - begun:.0f} s", err=True)

    return tell
