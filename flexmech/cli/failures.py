"""How a command fails: one line on stderr and an exit code, never a traceback."""

from __future__ import annotations

import functools
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import ParamSpec

import typer

from flexmech.cli.stopping import Stopped, answered_signals, interrupted_line
from flexmech.errors import ComputationError, FlexmechError, one_line
from flexmech.files import written_at

Parameters = ParamSpec("Parameters")


def reports_failures(command: Callable[Parameters, None]) -> Callable[Parameters, None]:
    """The same command with one line and an exit code where it fails.

    It exits with 2 after an InputError, 1 after a ComputationError, 130 after an interrupt and 143
    after SIGTERM.
    """

    @functools.wraps(command)
    def wrapped(*args: Parameters.args, **kwargs: Parameters.kwargs) -> None:
        earlier = len(answered_signals())
        try:
            # A date that is none is refused before the long work, and before others read it.
            written_at()
            command(*args, **kwargs)
        except typer.Exit:
            raise
        except (Exception, KeyboardInterrupt) as error:
            if stopped := _stopped(error, answered_signals()[earlier:]):
                typer.echo(interrupted_line(stopped.number), err=True)
                raise typer.Exit(stopped.exit_code) from error
            if isinstance(error, MemoryError):
                error = ComputationError(
                    f"the memory does not suffice ({one_line(str(error)) or 'none is left'}); "
                    "lower --elements or --modes, or ask for fewer --angles, --speeds or --samples"
                )
            if isinstance(error, FlexmechError):
                typer.echo(f"error: {error}", err=True)
                raise typer.Exit(error.exit_code) from error
            raise

    return wrapped


def _stopped(error: BaseException, answered: tuple[int, ...]) -> Stopped | None:
    """The signal that ended a command, even if compiled code made another exception of it."""
    if isinstance(error, Stopped):
        return error
    if answered:
        return Stopped(answered[-1])
    return Stopped(signal.SIGINT) if isinstance(error, KeyboardInterrupt) else None


@contextmanager
def telling(model: object, speed_unit: str, record: object = None) -> Iterator[None]:
    """Put the model file in front of a message that names neither it nor an option.

    Parameters
    ----------
    model : path-like or None
        As the user gave it; None where there is none.
    speed_unit : str
        In which messages speak of crank speeds.
    record : path-like, optional
        Another file of the user: messages that name it are about it.
    """
    import numpy as np

    try:
        yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise ComputationError(
            f"{model or 'the input'}: the computation breaks down ({error}); lengths, stiffnesses "
            "or masses differ too much in magnitude: check their units"
        ) from error
    except FlexmechError as error:
        printed = type(error)(error.in_unit(speed_unit))
        files = (str(file) for file in (model, record) if file is not None)
        named = model is None or any(file in printed.message for file in files)
        named = named or printed.message.startswith("--")
        raise (printed if named else printed.within(str(model))) from error
