"""The application: its commands and its version."""

from __future__ import annotations

import sys
from collections.abc import Callable
from io import TextIOWrapper
from typing import Annotated

import typer

from flexmech.cli.check import check
from flexmech.cli.coupler_curve import coupler_curve
from flexmech.cli.failures import reports_failures
from flexmech.cli.frequencies import frequencies
from flexmech.cli.moisture import moisture
from flexmech.cli.new import new
from flexmech.cli.response import response
from flexmech.cli.schema import schema
from flexmech.cli.section import section
from flexmech.cli.study import study_app
from flexmech.cli.synthesize import synthesize

# In the order of the help. The docstring of a command is what its help says.
COMMANDS: tuple[Callable[..., None], ...] = (
    frequencies,
    response,
    coupler_curve,
    moisture,
    section,
    synthesize,
    check,
    new,
    schema,
)

app = typer.Typer(
    name="flexmech",
    help="Moving natural frequencies and running response of flexible linkages, by two "
    "independent engines.",
    no_args_is_help=True,
    add_completion=False,
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


for command in COMMANDS:
    app.command()(reports_failures(command))
app.add_typer(study_app, name="study")


def main() -> None:
    """Entry point of the console script ``flexmech``; exits with 0, 1, 2 or 130."""
    for stream in (sys.stdout, sys.stderr):
        # A name or source that the terminal's encoding lacks is shown with "?" instead.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")
    app(prog_name="flexmech")
