"""Files that appear whole or not at all."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from flexmech.errors import InputError

__all__ = ["check_writable", "matching", "moved_into", "write_whole"]


def check_writable(folder: Path, patterns: Iterable[str]) -> None:
    """Refuse a result folder that cannot be written, before the long work.

    Nothing is left behind: not even the folder is made yet.

    Parameters
    ----------
    folder : Path
        May not exist yet.
    patterns : iterable of str
        Files that may be written there, such as ``"dry/*.png"``.

    Raises
    ------
    InputError
        If the folder, one above it or one of a pattern is no folder or cannot be written, or
        a name is taken by a folder.
    """
    patterns = tuple(patterns)
    for place in dict.fromkeys([folder, *((folder / pattern).parent for pattern in patterns)]):
        _check_folder(place)
    for path in matching(folder, patterns):
        if path.is_dir():
            name = path.relative_to(folder)
            raise InputError(f"{folder}: {name} is a folder there; remove it or choose another one")


def _check_folder(folder: Path) -> None:
    missing = [place for place in (folder, *folder.absolute().parents) if not _exists(place)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(_not_writable(folder, error)) from error
    finally:
        for place in missing:
            with suppress(OSError):
                place.rmdir()


def matching(folder: Path, patterns: Iterable[str]) -> list[Path]:
    """Paths in a folder whose names match patterns, in their order; none if there is no folder."""
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


@contextmanager
def moved_into(folder: Path) -> Iterator[Path]:
    """Give a temporary folder whose files and folders move into ``folder`` if all ends well.

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
            for file in sorted(Path(temporary).rglob("*")):
                target = folder / file.relative_to(temporary)
                if file.is_dir():
                    target.mkdir(exist_ok=True)
                else:
                    file.replace(target)
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
