"""Ctrl-C and SIGTERM: one line on stderr, and the exit code that shells expect."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType

from flexmech.interruption import STOPPING, work_to_tidy

_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
# A progress bar hides the cursor; the line of the bar is cleared.
_BARE_LINE = "\x1b[?25h\r\x1b[K"
# Those that were answered by an exception, the last one at the end.
_answered: list[int] = []


class Stopped(KeyboardInterrupt):
    """A signal that asked to end while there were files to tidy up."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__(number)
        self.number = number

    @property
    def exit_code(self) -> int:
        """Exit code of shells: 130 after Ctrl-C, 143 after SIGTERM."""
        return 128 + self.number


def interrupted_line(number: int) -> str:
    """Say that a signal ended the program."""
    return f"{_WORDS[signal.Signals(number)]}: files that were not complete were not written"


def answer_signals() -> None:
    """Answer signals that ask to end; those that the caller has the program ignore stay ignored."""
    for number in STOPPING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _stop)


def answered_signals() -> tuple[int, ...]:
    """Signals that this process has answered by an exception, the last one at the end.

    Compiled code may have turned that exception into one of its own.
    """
    return tuple(_answered)


def ignore_signals() -> None:
    """Let signals pass once the work is done: Python drops its handlers while it shuts down."""
    for number in STOPPING:
        signal.signal(number, signal.SIG_IGN)


def _stop(number: int, frame: FrameType | None) -> None:
    """End at once, or by an exception where there is something to tidy up.

    Imports and compiled code may swallow an exception, or turn it into another one.
    """
    if work_to_tidy():
        _answered.append(number)
        raise Stopped(number)
    bare = _BARE_LINE if sys.stderr is not None and sys.stderr.isatty() else ""
    try:
        os.write(2, f"{bare}{interrupted_line(number)}\n".encode())
    finally:
        os._exit(128 + number)
