"""Files that appear whole or not at all, and sets of files that appear together."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from flexmech.errors import InputError, one_line
from flexmech.interruption import tidying, uninterrupted

if sys.platform != "win32":
    import fcntl


# Characters of a path shown in a message: four lines of a terminal; longer ones are what the system
# cannot reach.
_MOST_SHOWN = 200
PREFIX = ".flexmech-"
"""Prefix of the names of folders in which sets of files are made."""
# Files that are named one by one: of more, such as sections of many links, there is the number.
_MOST_FILES_NAMED = 30


def given_path(path: str | os.PathLike[str]) -> Path:
    """Path that a user gave; ``~`` at its start is the home folder. Nothing need be there.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If it is no path, or empty, there is no such home folder, or the system cannot say what is
        there: a name is too long, a folder may not be entered, or links go round in a circle.

    Examples
    --------
    >>> given_path("results/steel").parts
    ('results', 'steel')
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"path must be text or a Path, got {path!r}")
    if path == "":
        raise InputError("path is empty; name a file or folder, or write . for the working folder")
    try:
        found = Path(path).expanduser()
    except RuntimeError as error:
        raise InputError(
            f"{os.fspath(path)}: there is no such home folder; write the whole path, or ./~ for "
            "a folder of that name"
        ) from error
    try:
        found.stat()
    except (OSError, ValueError) as error:
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            # What is to be read is missed by its reader, what is to be written is made.
            return found
        reason = getattr(error, "strerror", None) or error
        shown = one_line(os.fspath(path), _MOST_SHOWN)
        raise InputError(f"{shown}: cannot be reached ({reason}); give another path") from error
    return found


def bytes_of(file: Path, shown: str, what: str, most: int) -> bytes:
    """Content of a user's file, read up to a bound.

    Parameters
    ----------
    file : Path
    shown : str
        What messages call it.
    what : str
        What it is taken for, as "a model file".
    most : int
        Bytes, more than any such file has.

    Returns
    -------
    bytes

    Raises
    ------
    InputError
        If it is a device or pipe, or larger.
    OSError
        If it cannot be read.
    """
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise InputError(f"{shown}: is a device or pipe; name {what} that is a file")
    with file.open("rb") as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise InputError(
            f"{shown}: is larger than {what} can be ({most // 1_000_000} MB); give fewer lines"
        )
    return content


def written_at() -> datetime:
    """Date of files that are written now, or that of the variable ``SOURCE_DATE_EPOCH``, in UTC.

    Returns
    -------
    datetime.datetime

    Raises
    ------
    InputError
        If that variable is no date.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not epoch:
        return datetime.now(UTC)
    try:
        return datetime.fromtimestamp(int(epoch), UTC)
    except (ValueError, OverflowError, OSError) as error:
        raise InputError(
            f"SOURCE_DATE_EPOCH: got {one_line(epoch, _MOST_SHOWN)!r}, which is no date; give "
            "seconds from 1970 on, such as 1700000000, or unset this environment variable"
        ) from error


def check_writable(folder: Path, patterns: Iterable[str]) -> None:
    """Refuse a result folder that cannot be written, before the long work.

    Nothing is left behind: the folder itself is not made yet.

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
        _check_folder(folder, place)
    for path in matching(folder, patterns):
        if path.is_dir():
            name = path.relative_to(folder)
            raise InputError(f"{folder}: {name} is a folder there; remove it or choose another one")


def _check_folder(folder: Path, place: Path) -> None:
    """Make a file without a name where the folder is, or in the one that it would be made in."""
    try:
        while not place.exists():
            # The working folder itself may be gone: its parent is itself then.
            if place == place.parent:
                break
            place = place.parent
        with tempfile.TemporaryFile(dir=place):
            pass
    except (OSError, ValueError) as error:
        raise InputError(_not_writable(folder, error)) from error


def matching(folder: Path, patterns: Iterable[str]) -> list[Path]:
    """Paths in a folder whose names match patterns, in their order; none if there is no folder."""
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


def named_files(out: Path, files: Sequence[Path], patterns: Iterable[str]) -> list[str]:
    """Name the files of a run, and those that lie beside them from an earlier one.

    The number stands in place of many names.

    Parameters
    ----------
    out : Path
    files : sequence of Path
    patterns : iterable of str
        Patterns of all files that such a run may write.

    Returns
    -------
    list of str
    """
    names = [one_line(str(file.relative_to(out))) for file in files]
    few = len(names) <= _MOST_FILES_NAMED
    lines = [f"files in {one_line(str(out))}: {', '.join(names) if few else len(names)}"]
    stale = [str(path.relative_to(out)) for path in matching(out, patterns) if path not in files]
    if stale:
        lines.append(f"from an earlier run, not of this one: {', '.join(map(one_line, stale))}")
    return lines


@contextmanager
def moved_into(folder: Path) -> Iterator[Path]:
    """Give a temporary folder whose files and folders move into ``folder`` if all ends well.

    The set takes the place of an earlier one as a whole: the files that it replaces are removed
    before the first one is moved, so that even a program that is killed at that moment leaves no
    new file beside an old one of the same set. Signals that ask to end wait for the move, and
    another program that moves a set into the same folder does so before or after it. Temporary
    folders that a killed program left there are removed.

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
        with tidying():
            missing = [place for place in (folder, *folder.parents) if not place.exists()]
            try:
                folder.mkdir(parents=True, exist_ok=True)
                with _workplace(folder) as temporary:
                    yield temporary
                    with uninterrupted(), _locked(folder):
                        _move(temporary, folder)
            finally:
                # Folders that were made for nothing; those with something in them stay.
                for place in missing:
                    with suppress(OSError):
                        place.rmdir()
    except OSError as error:
        # A set within a set: the user knows the folder around it.
        if folder.name.startswith(PREFIX):
            raise
        raise InputError(_not_writable(folder, error)) from error


@contextmanager
def _workplace(folder: Path) -> Iterator[Path]:
    """A temporary folder, locked as long as this program lives, so that others let it stand."""
    temporary, lock = None, None
    try:
        # A signal that comes meanwhile is raised at the end of this, with the folder made.
        with uninterrupted(), _locked(folder):
            _remove_left(folder)
            temporary = Path(tempfile.mkdtemp(dir=folder, prefix=PREFIX))
            lock = _lock(temporary, wait=True)
        yield temporary
    finally:
        with uninterrupted():
            if temporary is not None:
                shutil.rmtree(temporary, ignore_errors=True)
            if lock is not None:
                os.close(lock)


def _remove_left(folder: Path) -> None:
    """Remove temporary folders of programs that were killed: nobody holds their lock."""
    for left in folder.glob(f"{PREFIX}*"):
        lock = _lock(left, wait=False)
        if lock is not None:
            shutil.rmtree(left, ignore_errors=True)
            os.close(lock)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Wait until no other program moves files into the folder, and keep others waiting."""
    # Within a temporary folder, which is locked already, nobody else writes.
    lock = None if folder.name.startswith(PREFIX) else _lock(folder, wait=True)
    try:
        yield
    finally:
        if lock is not None:
            os.close(lock)


class FolderLock:
    """Lock of a folder, which no other program gets until it is released or this one has ended.

    Some file systems, and Windows, know no locks of folders: nobody is kept out there.

    Parameters
    ----------
    folder : Path
        Which may be renamed meanwhile.

    Raises
    ------
    BlockingIOError
        If another program has it.
    """

    def __init__(self, folder: Path) -> None:
        self._descriptor: int | None = None
        if sys.platform == "win32":
            return
        try:
            self._descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.release()
            raise
        except OSError:
            self.release()  # a file system without locks

    def release(self) -> None:
        """Let others have it."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None


def _lock(folder: Path, *, wait: bool) -> int | None:
    """Descriptor that holds the lock of a folder until it is closed; None if there is none.

    Some file systems, and Windows, know no locks of folders: there two programs that write into
    one folder at the same moment are not kept apart.
    """
    if sys.platform == "win32":
        return None
    descriptor = None
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        if descriptor is not None:
            os.close(descriptor)
        return None
    return descriptor


def _move(temporary: Path, folder: Path) -> None:
    paths = sorted(temporary.rglob("*"))
    targets = {path: folder / path.relative_to(temporary) for path in paths}
    for path, target in targets.items():
        if path.is_dir():
            target.mkdir(exist_ok=True)
        elif target.is_dir():
            raise IsADirectoryError(0, f"{target.relative_to(folder)} is a folder there")
    for path, target in targets.items():
        if not path.is_dir():
            target.unlink(missing_ok=True)
    for path, target in targets.items():
        if not path.is_dir():
            path.replace(target)


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


def _not_writable(folder: Path, error: Exception) -> str:
    reason = getattr(error, "strerror", None) or error
    return f"cannot write to {folder} ({reason}); choose a folder that can be written"
