"""The application: its commands and its version."""

from __future__ import annotations

import logging
import os
import signal
import sys
import warnings
from collections.abc import Callable
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from flexmech.cli.campbell import campbell
from flexmech.cli.check import check
from flexmech.cli.command_line import running
from flexmech.cli.compare import compare
from flexmech.cli.coupler_curve import coupler_curve
from flexmech.cli.export import export
from flexmech.cli.failures import reports_failures
from flexmech.cli.frequencies import frequencies
from flexmech.cli.hammer import hammer
from flexmech.cli.kinematics import kinematics
from flexmech.cli.moisture import moisture
from flexmech.cli.new import new
from flexmech.cli.printing import prints_as_asked
from flexmech.cli.report import report
from flexmech.cli.response import response
from flexmech.cli.schema import schema
from flexmech.cli.section import section
from flexmech.cli.stability import stability
from flexmech.cli.stopping import Stopped, interrupted_line
from flexmech.cli.streams import check_streams
from flexmech.cli.study import study_app
from flexmech.cli.synthesize import synthesize
from flexmech.cli.verify import verify
from flexmech.errors import FlexmechError, InputError, one_line

# In the order of the help. The docstring of a command is what its help says.
DELIVERING: tuple[Callable[..., None], ...] = (
    frequencies,
    hammer,
    campbell,
    stability,
    response,
    compare,
    export,
    kinematics,
    coupler_curve,
    moisture,
    section,
    synthesize,
    check,
    verify,
    report,
)
WRITING: tuple[Callable[..., None], ...] = (new, schema)

# What typer raises on wrong command lines; it has no public name for their common base.
_UsageError: type[Exception] = typer.BadParameter.__mro__[1]


class _Commands(TyperGroup):
    """Commands whose usage errors are one line on stderr, as all other errors are."""

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


def _usage_line(error: Any) -> str:
    """What is wrong with a command line, or the help where nothing was asked for."""
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
    from importlib.metadata import PackageNotFoundError, version

    try:
        number = version("flexmech")
    except PackageNotFoundError:
        number = "(not installed, running from a source folder)"
    typer.echo(f"flexmech {number}")
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


for command in DELIVERING:
    app.command()(reports_failures(prints_as_asked(command)))
for command in WRITING:
    app.command()(reports_failures(command))
app.add_typer(study_app, name="study")


def run() -> None:
    """Run the command line of this process, and exit."""
    check_streams()
    # Pictures are written into files: a name of a window system that is not there does not matter.
    os.environ["MPLBACKEND"] = "agg"
    # Warnings of libraries are for developers, who turn them on by -W or PYTHONWARNINGS.
    if not sys.warnoptions:
        warnings.simplefilter("ignore")
        # Such as fonts that an old cache of Matplotlib does not list, which it says in its log.
        logging.getLogger("matplotlib").setLevel(logging.ERROR)
    app(prog_name="flexmech")
