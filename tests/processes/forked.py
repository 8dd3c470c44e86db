"""Command lines in processes of their own, in which something happens at a named place.

A place is an audit event of Python (``open``, ``os.rename``, ``tempfile.mkdtemp``,
``shutil.rmtree``) on a path: it comes at the same step of the work however fast the machine is.
Processes are split off from this one, which has imported everything, and take SIGINT and SIGTERM
as those of a terminal do, also where the tests run in the background.
"""

from __future__ import annotations

import functools
import os
import re
import signal
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import flexmech.cli
from tests.support.command import run_command

TEMPORARY = ".flexmech-"
"""Start of the names of folders in which sets of files are made."""
PATIENCE = 300.0
"""In s; what takes longer hangs."""


class Place(NamedTuple):
    """A step of the work: an audit event, and a pattern of a path that it names."""

    event: str
    path: str


@dataclass(frozen=True)
class Ended:
    """How a process ended: its exit code, or the negative number of the signal that killed it."""

    code: int
    stdout: str
    stderr: str


@dataclass(frozen=True)
class Process:
    """A process that runs a command line, and the folder of what it prints."""

    pid: int
    printed: Path

    def wait(self) -> Ended:
        """Wait for its end."""
        until(
            "it ends", lambda: os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        )
        _, status = os.waitpid(self.pid, 0)
        stdout, stderr = ((self.printed / name).read_text() for name in ("stdout", "stderr"))
        return Ended(os.waitstatus_to_exitcode(status), stdout, stderr)

    def wait_until_stopped(self) -> None:
        """Wait until it has stopped itself."""
        options = os.WSTOPPED | os.WNOHANG
        until("it stops", lambda: os.waitid(os.P_PID, self.pid, options))


def until(words: str, holds: Callable[[], Any]) -> None:
    """Wait until something holds."""
    last = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < last, f"waited {PATIENCE:g} s until {words}"
        time.sleep(0.01)


def start(
    folder: Path,
    *words: object,
    at: Place | None = None,
    do: Callable[[], object] | None = None,
    first: Callable[[], object] | None = None,
) -> Process:
    """Start ``flexmech WORDS`` in a folder; something is done at a place, or at first."""
    _import_everything()
    printed = Path(tempfile.mkdtemp(prefix="printed-"))
    process = os.fork()
    if not process:
        _run(folder, printed, [str(word) for word in words], at, do, first)
    return Process(process, printed)


def run(folder: Path, *words: object, **options: Any) -> Ended:
    """Run ``flexmech WORDS`` in a folder to its end, as `start` starts it."""
    return start(folder, *words, **options).wait()


def send(number: int) -> Callable[[], None]:
    """Something to do at a place: the process sends itself a signal."""
    return lambda: os.kill(os.getpid(), number)


def files_of(folder: Path) -> list[str]:
    """All files of a folder and those below it."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


@functools.cache
def _import_everything() -> None:
    """Run a command here, so that no process needs to import what all of them do."""
    quick = ("--engine", "reference", "--elements", "1", "--angles", "0", "--speeds", "0")
    with tempfile.TemporaryDirectory() as folder:
        run_command(Path(folder), "frequencies", "models/steel_fourbar.toml", *quick)


def _run(
    folder: Path,
    printed: Path,
    words: list[str],
    at: Place | None,
    do: Callable[[], object] | None,
    first: Callable[[], object] | None,
) -> NoReturn:
    code: Any = 70
    try:
        for number, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(printed / name, os.O_WRONLY | os.O_CREAT), number)
        sys.stdout, sys.stderr = (os.fdopen(number, "w", closefd=False) for number in (1, 2))
        # What pytest has set in their place tells this process's tests nothing.
        sys.unraisablehook, threading.excepthook = sys.__unraisablehook__, threading.__excepthook__
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        os.chdir(folder)
        if at is not None and do is not None:
            _do_at(at, do)
        if first is not None:
            first()
        sys.argv = ["flexmech", *words]
        flexmech.cli.main()
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException:
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)


def _do_at(place: Place, do: Callable[[], object]) -> None:
    left = [do]

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if left and event == place.event and any(re.search(place.path, str(a)) for a in arguments):
            left.pop()()

    sys.addaudithook(watch)
