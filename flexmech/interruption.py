"""When a signal comes: stretches of work that it may not cut in two, and those that tidy up.

This file imports nothing heavy, so that the command line can answer a signal from its first line
on.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

STOPPING = (signal.SIGINT, signal.SIGTERM)
"""Signals that ask a program to end: Ctrl-C, and what ``kill`` and ``timeout`` send."""

_open: list[object] = []


@contextmanager
def tidying() -> Iterator[None]:
    """Mark a stretch that tidies up when an exception passes: a signal must come as one there."""
    mark = object()
    _open.append(mark)
    try:
        yield
    finally:
        _open.remove(mark)


def work_to_tidy() -> bool:
    """Whether there is something that only an exception would tidy up."""
    return bool(_open)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let signals that ask to end wait until the stretch is done; it must be short.

    Python runs the handlers of signals in its main thread alone: elsewhere nothing is to be
    done.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    waiting: list[int] = []

    def wait(number: int, frame: FrameType | None) -> None:
        waiting.append(number)

    # A handler that was not set from Python is None, and cannot be set again.
    handlers = {number: signal.getsignal(number) for number in STOPPING}
    handlers = {number: handler for number, handler in handlers.items() if handler is not None}
    try:
        for number in handlers:
            signal.signal(number, wait)
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if waiting:
            signal.raise_signal(waiting[0])
