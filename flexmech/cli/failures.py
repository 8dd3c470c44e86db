"""How a command fails: one line on stderr and an exit code, never a traceback."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec

import typer

from flexmech.errors import FlexmechError, InputError

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it: 128 + SIGINT."""

Parameters = ParamSpec("Parameters")


def reports_failures(command: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """Turn a command's :class:`FlexmechError` into a message and its exit code.

    Parameters
    ----------
    command : callable
        A typer command.

    Returns
    -------
    callable
        The same command; it exits with 2 after an InputError, 1 after a ComputationError
        and 130 after an interrupt.
    """

    @functools.wraps(command)
    def wrapped(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except FlexmechError as error:
            typer.echo(f"error: {error}", err=True)
            raise typer.Exit(error.exit_code) from error
        except KeyboardInterrupt as error:
            typer.echo("interrupted: files that were not complete were not written", err=True)
            raise typer.Exit(INTERRUPTED) from error

    return wrapped


@contextmanager
def naming(option: str) -> Iterator[None]:
    """Put the name of an option in front of the message where its value is refused."""
    try:
        yield
    except InputError as error:
        raise error.within(option) from error
