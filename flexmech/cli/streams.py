"""Standard output that says in one line why it cannot be written: it is full, or closed."""

from __future__ import annotations

import io
import os
import sys
from typing import Any, TextIO

from flexmech.errors import InputError


class _Stream(io.FileIO):
    """Stdout or stderr. Its first failure is told, after it nothing is written any more."""

    def write(self, data: Any) -> int:
        try:
            return super().write(data)
        except OSError as error:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            if self.fileno() == 1:
                raise InputError(
                    f"stdout: cannot be written ({error.strerror}); files of this run are "
                    "complete, only what it prints is missing"
                ) from error
            return memoryview(data).nbytes


def check_streams() -> None:
    """Let stdout fail with a message, and stderr in silence.

    A name or source that the terminal's encoding lacks is shown with "?".
    """
    # The number of a closed stream would go to the next file that is opened.
    while (free := os.open(os.devnull, os.O_RDONLY)) <= 2:
        pass
    os.close(free)
    sys.stdout, sys.stderr = _checked(1, sys.stdout), _checked(2, sys.stderr)


def _checked(descriptor: int, stream: TextIO | None) -> TextIO:
    raw = io.BufferedWriter(_Stream(descriptor, "wb", closefd=False))
    encoding = "utf-8" if stream is None else stream.encoding
    return io.TextIOWrapper(raw, encoding=encoding, errors="replace", line_buffering=True)
