"""Command line: the only place that prints, shows progress or exits.

Heavy modules are imported inside the commands, so that ``flexmech --help`` answers at once, and
after the handlers of signals stand, so that Ctrl-C ends an import in one line as well.
"""

from __future__ import annotations

import gc
from typing import TYPE_CHECKING

from flexmech.cli.stopping import answer_signals, ignore_signals

if TYPE_CHECKING:
    from typer import Typer

__all__ = ["app", "main"]


def __getattr__(name: str) -> Typer:
    """The application, imported when it is first asked for."""
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from flexmech.cli.application import app

    return app


def main() -> None:
    """Entry point of the console script ``flexmech``; exits with 0, 1, 2, 130 or 143."""
    answer_signals()
    # Nearly all that a command makes lives to its end, its modules above all: searches for what
    # does not cost a tenth. Small commands make a million objects.
    gc.set_threshold(1_000_000)
    gc.callbacks.append(_search_more_often)
    from flexmech.cli.application import run

    try:
        run()
    finally:
        ignore_signals()
        gc.freeze()  # the process gives back its memory without a last search


def _search_more_often(phase: str, info: dict[str, int]) -> None:
    """Have searches for garbage follow each other sooner once a command has made a million objects.

    Python calls it at both ends of every search.
    """
    if phase == "stop" and info["generation"] == 0:
        gc.callbacks.remove(_search_more_often)
        gc.set_threshold(50_000)
