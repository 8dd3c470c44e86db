"""Standard output that says in one line why it cannot be written: it is full, or closed."""

from __future__ import annotations

import errno
import io
import os
import sys
from typing import TextIO

from flexmech.errors import InputError


class _Stream(io.RawIOBase):
    """A standard stream. Its first failure is told, after it nothing is written any more."""

    def __init__(self, name: str, descriptor: int, *, closed: bool, tells: bool) -> None:
        super().__init__()
        self.name = name
        self.descriptor = descriptor
        self.caller_closed = closed
        self.tells = tells
        self.failed = False

    def fileno(self) -> int:
        return self.descriptor

    def isatty(self) -> bool:
        return not self.caller_closed and os.isatty(self.descriptor)

    def writable(self) -> bool:
        return True

    def write(self, data: object) -> int:
        rest = memoryview(data).cast("B")  # type: ignore[arg-type]
        size = len(rest)
        try:
            while rest and not self.failed:
                rest = rest[self._written(rest) :]
        except OSError as error:
            self.failed = True
            if self.tells:
                raise InputError(
                    f"{self.name}: cannot be written ({error.strerror}); files of this run "
                    "are complete, only what it prints is missing"
                ) from error
        return size

    def _written(self, data: memoryview) -> int:
        if self.caller_closed:
            raise OSError(errno.EBADF, "it is closed")
        return os.write(self.descriptor, data)


def check_streams() -> None:
    """Let stdout fail with a message, and stderr in silence.

    A name or source that the terminal's encoding lacks is shown with "?".
    """
    # The number of a closed stream would go to the next file that is opened.
    while (free := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(free)
    sys.stdout = _checked("stdout", 1, sys.stdout, tells=True)
    sys.stderr = _checked("stderr", 2, sys.stderr, tells=False)


def _checked(name: str, descriptor: int, stream: TextIO | None, *, tells: bool) -> io.TextIOWrapper:
    raw = _Stream(name, descriptor, closed=stream is None, tells=tells)
    encoding = "utf-8" if stream is None else stream.encoding
    return io.TextIOWrapper(raw, encoding=encoding, errors="replace", write_through=True)
