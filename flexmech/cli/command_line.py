"""The command line that is being run, as stored results name it."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["command_line", "running"]

_running: ContextVar[str] = ContextVar("_running", default="")


def command_line() -> str:
    """The command line as a shell takes it; empty where none is run."""
    return _running.get()


@contextmanager
def running(arguments: Sequence[str]) -> Iterator[None]:
    """Keep the command line while it is run."""
    token = _running.set(shlex.join(["flexmech", *arguments]))
    try:
        yield
    finally:
        _running.reset(token)
