"""The application: its commands, its version, and the streams that it prints to."""

from __future__ import annotations

import inspect
import io
import logging
import os
import signal
import sys
import warnings
from collections.abc import Callable
from typing import Annotated, Any, NoReturn, TextIO

import typer
from typer.core import TyperCommand, TyperGroup

from flexmech.cli.deliver import running
from flexmech.cli.designs import optimize, report, sweep, uncertainty, verify
from flexmech.cli.failures import reports_failures
from flexmech.cli.laboratory import compare, hammer
from flexmech.cli.links import check, moisture, new, schema, section, strength
from flexmech.cli.maps import campbell, frequencies, stability
from flexmech.cli.reading import from_options, with_value
from flexmech.cli.rigid import balance, coupler_curve, kinematics, synthesize
from flexmech.cli.runs import export, response
from flexmech.cli.stopping import Stopped, interrupted_line
from flexmech.errors import FlexmechError, InputError, one_line

COMMANDS: tuple[Callable[..., None], ...] = (
    frequencies,
    hammer,
    campbell,
    stability,
    response,
    compare,
    export,
    kinematics,
    balance,
    coupler_curve,
    moisture,
    section,
    strength,
    synthesize,
    sweep,
    uncertainty,
    optimize,
    check,
    verify,
    report,
    new,
    schema,
)
"""In the order of the help. The docstring of a command is what its help says."""

_NAMED = {command.__name__.replace("_", "-"): command for command in COMMANDS}

_MOVED = {
    "study": "the campaign after Elamy et al. is a script of the repository: "
    "python scenarios/papers/elamy_2023.py",
    "campbell --response": "peaks of the periodic motion over crank speed are those of flexmech "
    "sweep: vary crank-speed in a study file (flexmech new study FILE) whose output is "
    "peak_deflection",
    "response --move-times": "residual vibration over the time of a move is that of flexmech "
    "sweep: vary drive.time in a study file (flexmech new study FILE) whose output is "
    "residual_amplitude",
}
"""Successors of commands and options that have left the program."""

# What typer raises on wrong command lines; it has no public name for their common base.
_UsageError: type[Exception] = typer.BadParameter.__mro__[1]


class _Commands(TyperGroup):
    """Commands that are built when they are asked for, and not for the help that lists them.

    Their usage errors are one line on stderr, as all other errors are.
    """

    def main(self, *args: Any, **settings: Any) -> NoReturn:
        """Run the command of a command line, and exit."""
        settings["standalone_mode"] = False
        try:
            given = args[0] if args else settings.get("args")
            with running(sys.argv[1:] if given is None else list(given)):
                code = super().main(*args, **settings)
        except _UsageError as error:
            code = InputError.exit_code
            typer.echo(_usage_line(error), err=True)
        except FlexmechError as error:
            # Help that cannot be printed.
            code = error.exit_code
            typer.echo(f"error: {error}", err=True)
        except typer.Abort:
            code = Stopped().exit_code
            typer.echo(interrupted_line(signal.SIGINT), err=True)
        sys.exit(code if isinstance(code, int) else 0)

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of all commands, in the order of the help."""
        return list(_NAMED)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """A command with its options; None if there is none of that name."""
        if cmd_name in _MOVED:
            raise _UsageError(_MOVED[cmd_name])
        # A name that is none is compared with all of them.
        wanted = [] if cmd_name in self.commands else [cmd_name] if cmd_name in _NAMED else _NAMED
        for name in wanted:
            alone = typer.Typer(add_completion=False, rich_markup_mode=None)
            alone.command(name)(reports_failures(from_options(_NAMED[name])))
            self.add_command(typer.main.get_command(alone), name)
        return super().get_command(ctx, cmd_name)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands with the first sentences of their docstrings."""
        commands = [TyperCommand(name, help=inspect.getdoc(each)) for name, each in _NAMED.items()]
        TyperGroup(commands=commands).format_commands(ctx, formatter)

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read a command line, in which some options of its command may stand without a value."""
        command = _NAMED.get(next(iter(args), ""))
        known = inspect.signature(from_options(command)).parameters if command else {}
        for moved in (f"{args[0]} {arg.partition('=')[0]}" for arg in args[1:]):
            if moved in _MOVED:
                raise _UsageError(f"{moved.split()[1]}: {_MOVED[moved]}")
        for number, (this, following) in enumerate(zip(args, [*args[1:], "-"], strict=False)):
            if this.removeprefix("--no").strip("-").replace("-", "_") in known:
                args[number] = with_value(this, following)
        return super().parse_args(ctx, args)


def _usage_line(error: Any) -> str:
    """Error of a command line, or the help where nothing was asked for."""
    message = error.format_message()
    if message.startswith("Usage:"):
        return str(message)
    command = error.ctx.command_path if error.ctx is not None else "flexmech"
    return f"error: {one_line(message).rstrip('.')}; see {command} --help"


app = typer.Typer(
    name="flexmech",
    cls=_Commands,
    help="Moving natural frequencies and running response of flexible linkages, by two "
    "independent engines.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    # Plain help: rich takes half a second to import, and its boxes break error messages.
    rich_markup_mode=None,
)


def _show_version(wanted: bool) -> None:
    if not wanted:
        return
    from importlib.metadata import version

    typer.echo(f"flexmech {version('flexmech')}")
    raise typer.Exit


@app.callback()
def options(
    show_version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    """Options of flexmech itself, before any command."""


class _Stream(io.FileIO):
    """Stdout or stderr. Its first failure is printed; after it nothing is written any more."""

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
                    "complete, only the printed text is missing"
                ) from error
            return memoryview(data).nbytes


def _checked(descriptor: int, stream: TextIO | None) -> TextIO:
    """A name or source that the terminal's encoding lacks is shown with "?"."""
    raw = io.BufferedWriter(_Stream(descriptor, "wb", closefd=False))
    encoding = "utf-8" if stream is None else stream.encoding
    return io.TextIOWrapper(raw, encoding=encoding, errors="replace", line_buffering=True)


def run() -> None:
    """Run the command line of this process, and exit."""
    # The number of a closed stream would go to the next file that is opened.
    while (free := os.open(os.devnull, os.O_RDONLY)) <= 2:
        pass
    os.close(free)
    # Stdout fails with a message, and stderr in silence.
    sys.stdout, sys.stderr = _checked(1, sys.stdout), _checked(2, sys.stderr)
    # Pictures are written into files: a name of a window system that is not there does not matter.
    os.environ["MPLBACKEND"] = "agg"
    # Warnings of libraries are for developers, who turn them on by -W or PYTHONWARNINGS.
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
        # Such as fonts that an old cache of Matplotlib does not list, which it says in its log.
        logging.getLogger("matplotlib").setLevel(logging.ERROR)
    app(prog_name="flexmech")
