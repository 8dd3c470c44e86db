"""Files that appear whole or not at all, and tables in them."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from flexmech.errors import InputError

__all__ = ["check_writable", "moved_into", "write_table", "write_whole"]


def check_writable(folder: Path, names: Iterable[str]) -> None:
    """Refuse a result folder that cannot be written, before the long work.

    Nothing is left behind: not even the folder is made yet.

    Parameters
    ----------
    folder : Path
        May not exist yet.
    names : iterable of str
        Files that will be written there.

    Raises
    ------
    InputError
        If the folder or one above it is no folder or cannot be written, or a name is taken
        by a folder.
    """
    missing = [place for place in (folder, *folder.absolute().parents) if not _exists(place)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"--out: {_not_writable(folder, error)}") from error
    finally:
        for place in missing:
            with suppress(OSError):
                place.rmdir()
    for name in names:
        if (folder / name).is_dir():
            raise InputError(
                f"--out {folder}: {name} is a folder there; remove it or choose another --out"
            )


@contextmanager
def moved_into(folder: Path) -> Iterator[Path]:
    """Give a temporary folder whose files move into ``folder`` if the block ends well.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.

    Yields
    ------
    Path
        The temporary folder, on the same file system.

    Raises
    ------
    InputError
        If writing fails.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".flexmech-") as temporary:
            yield Path(temporary)
            for file in sorted(Path(temporary).iterdir()):
                file.replace(folder / file.name)
    except OSError as error:
        raise InputError(_not_writable(folder, error)) from error


def write_whole(path: Path, text: str) -> None:
    """Write a text file in UTF-8, whole or not at all.

    Parameters
    ----------
    path : Path
        In a folder that exists; replaced if it exists.
    text : str

    Raises
    ------
    InputError
        If the folder does not exist or the file cannot be written.
    """
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it first")
    with moved_into(path.parent) as temporary:
        (temporary / path.name).write_text(text, encoding="utf-8", newline="\n")


def _exists(place: Path) -> bool:
    try:
        return place.exists()
    except OSError:
        # A folder that may not be entered or a name that is too long. It is taken for
        # existing, so that it is never removed; making it then tells what is wrong.
        return True


def _not_writable(folder: Path, error: OSError) -> str:
    return (
        f"cannot write to {folder} ({error.strerror or error}); choose a folder that can be written"
    )


def write_table(file: Path, columns: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table as CSV, its columns' names first.

    Parameters
    ----------
    file : Path
    columns : iterable of str
    rows : iterable of iterable
        Values as they are to stand there.
    """
    with file.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(columns)
        table.writerows(rows)
