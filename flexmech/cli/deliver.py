"""From a computation to what the user gets: files, pictures, and the summary on the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from flexmech.choices import PICTURE_FORMATS
from flexmech.cli.command_line import command_line
from flexmech.cli.failures import naming, telling
from flexmech.cli.pictures import PNG, Pictures, plain_style
from flexmech.cli.printing import Report
from flexmech.cli.progress import progress_bar
from flexmech.errors import one_line
from flexmech.files import check_writable, given_path, matching, moved_into

if TYPE_CHECKING:
    from flexmech.analyses import Result
    from flexmech.types import LabelledProgress

# Of a folder with more files than these its own name is printed.
MOST_FILES_NAMED = 30
Found = TypeVar("Found", bound="Result")


def deliver(
    kind: type[Found],
    compute: Callable[[LabelledProgress | None], Found],
    out: Path | None,
    *,
    model: Path | None = None,
    record: Path | None = None,
    pictures: Pictures = PNG,
    speed_unit: str = "rad/s",
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
    out : Path or None
        Folder for the files; None for no files.
    model : Path, optional
        Model file, which messages name.
    record : Path, optional
        Another file of the user: messages that name it do not name the model.
    pictures : Pictures
        What pictures to write.
    speed_unit : str
        In which messages speak of crank speeds.
    further : callable, optional
        Writes further files of the result into a folder and gives their paths; takes the
        progress too.
    remark : str
        Line before all others.
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
    if out is not None:
        with naming("--out"):
            out = given_path(out)
            check_writable(out, kind.file_patterns(pictures.formats))
    with progress_bar() as progress:
        with telling(model, speed_unit, record):
            result = compute(progress)
            # Nothing is written before everything is computed.
            summary = result.summary()
        # Files first: what is printed has been kept.
        files = []
        if out is not None:
            if pictures:
                plain_style()
            with naming("--out"), moved_into(out) as whole:
                files = result.save(
                    whole,
                    figures=bool(pictures),
                    formats=pictures.formats,
                    width=pictures.width,
                    command_line=command_line(),
                    **saving or {},
                )
                if further is not None:
                    files += further(result, whole, progress)
            files = [out / file.relative_to(whole) for file in files]
    lines = () if out is None else _file_lines(out, files, kind.file_patterns(PICTURE_FORMATS))
    Report(summary, tuple(files), lines, remark).print()
    return result


def _file_lines(out: Path, files: list[Path], patterns: Iterable[str]) -> tuple[str, ...]:
    """Name the files of a run, and those that lie beside them from an earlier one.

    Parameters
    ----------
    out : Path
    files : list of Path
        In ``out`` or below; a folder with many of them is named instead.
    patterns : iterable of str
        Of all files that such a run may write.
    """
    inside = Counter(file.parent for file in files)
    names = (
        f"{file.parent} ({inside[file.parent]} files)"
        if inside[file.parent] > MOST_FILES_NAMED
        else str(file)
        for file in files
    )
    lines = ["files: " + ", ".join(dict.fromkeys(map(one_line, names)))]
    stale = [str(path.relative_to(out)) for path in matching(out, patterns) if path not in files]
    if stale:
        lines.append(f"from an earlier run, not of this one: {', '.join(map(one_line, stale))}")
    return tuple(lines)
