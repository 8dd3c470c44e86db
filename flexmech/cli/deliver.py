"""From a computation to what the user gets: files, pictures, and the summary on the terminal."""

from __future__ import annotations

import os
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from typer import BadParameter

from flexmech.choices import PICTURE_FORMATS, PageWidth, PictureFormat
from flexmech.cli.failures import naming, telling
from flexmech.cli.printing import Printing, progress_bar, say
from flexmech.cli.typed import Speeds
from flexmech.errors import one_line
from flexmech.files import check_writable, given_path, matching, moved_into

if TYPE_CHECKING:
    from flexmech.analyses import Result
    from flexmech.arrays import LabelledProgress

# Of a folder with more files than these its own name is printed.
_MOST_FILES_NAMED = 30
Found = TypeVar("Found", bound="Result")
_running: ContextVar[str] = ContextVar("_running", default="")


def typed_path(text: str | os.PathLike[str]) -> Path:
    """Path of an option or argument; an empty one, which would be the working folder, is refused.

    A script passes one where a variable of it is not set.
    """
    if text == "":
        raise BadParameter("it is empty; name a file or folder, or write . for the working folder")
    return Path(text)


@dataclass(frozen=True)
class Pictures:
    """What pictures a command writes; no formats where none are wanted."""

    formats: tuple[PictureFormat, ...] = ("png",)
    width: PageWidth = "two-column"


@dataclass(frozen=True)
class Output:
    """A folder for the files, if any, the pictures among them, and how the summary is printed."""

    folder: Path | None
    pictures: Pictures = Pictures()
    printing: Printing = "words"


def command_line() -> str:
    """The command line that is run, as a shell takes it; empty where none is run."""
    return _running.get()


@contextmanager
def running(arguments: Sequence[str]) -> Iterator[None]:
    """Keep the command line while it is run."""
    line = shlex.join(["flexmech", *arguments])
    # Bytes of a file's name that are no text, which files of results cannot hold, as escapes.
    token = _running.set(line.encode(errors="backslashreplace").decode())
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
        Line before the summary.
    saving : mapping, optional
        Further options of the result's own way to save.

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
    with progress_bar() as progress:
        with telling(model, speeds.unit, record):
            result = compute(progress)
            # Nothing is written before everything is computed.
            summary = result.summary()
        # Files first: what is printed has been kept.
        files = []
        if out is not None:
            if formats:
                _use_plain_style()
            with naming("--out"), moved_into(out) as whole:
                files = result.save(
                    whole,
                    figures=bool(formats),
                    formats=formats,
                    width=output.pictures.width,
                    command_line=command_line(),
                    **saving or {},
                )
                if further is not None:
                    files += further(result, whole, progress)
            files = [out / file.relative_to(whole) for file in files]
    lines = () if out is None else _file_lines(out, files, kind.file_patterns(PICTURE_FORMATS))
    say(summary, files, lines, (speeds.remark, remark), output.printing)
    return result


def _use_plain_style() -> None:
    """Leave out what a ``matplotlibrc`` of the user sets, such as text by a TeX that is not there.

    The pictures of a command are the same on all machines.
    """
    import matplotlib

    matplotlib.rcdefaults()


def _file_lines(out: Path, files: list[Path], patterns: Iterable[str]) -> list[str]:
    """Name the files of a run, and those that lie beside them from an earlier one.

    A folder with many files is named instead of them. ``patterns`` are those of all files that
    such a run may write.
    """
    inside = Counter(file.parent for file in files)
    names = (
        f"{file.parent} ({inside[file.parent]} files)"
        if inside[file.parent] > _MOST_FILES_NAMED
        else str(file)
        for file in files
    )
    lines = ["files: " + ", ".join(dict.fromkeys(map(one_line, names)))]
    stale = [str(path.relative_to(out)) for path in matching(out, patterns) if path not in files]
    if stale:
        lines.append(f"from an earlier run, not of this one: {', '.join(map(one_line, stale))}")
    return lines
