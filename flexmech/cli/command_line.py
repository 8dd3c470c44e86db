"""The command line that is being run, as stored results name it."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

_running: ContextVar[str] = ContextVar("_running", default="")


def command_line() -> str:
    """The command line as a shell takes it; empty where none is run."""
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
