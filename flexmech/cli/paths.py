"""Paths on the command line."""

from __future__ import annotations

import os
from pathlib import Path

from typer import BadParameter


def typed_path(text: str | os.PathLike[str]) -> Path:
    """Path of an option or argument; an empty one, which would be the working folder, is refused.

    A script passes one where a variable of it is not set.
    """
    if text == "":
        raise BadParameter("it is empty; name a file or folder, or write . for the working folder")
    return Path(text)
