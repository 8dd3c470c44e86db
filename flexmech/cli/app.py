"""The application: its commands and its version."""

from __future__ import annotations

import sys
from io import TextIOWrapper
from typing import Annotated

import typer

from flexmech.cli import (
    check,
    coupler_curve,
    frequencies,
    moisture,
    new,
    response,
    schema,
    section,
    study,
    synthesize,
)

__all__ = ["app", "main"]

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


app.command("frequencies", help=frequencies.HELP)(frequencies.frequencies)
app.command("response", help=response.HELP)(response.response)
app.command("coupler-curve", help=coupler_curve.HELP)(coupler_curve.coupler_curve)
app.command("moisture", help=moisture.HELP)(moisture.moisture)
app.command("section", help=section.HELP)(section.section)
app.add_typer(study.study_app, name="study", help=study.HELP)
app.command("synthesize", help=synthesize.HELP)(synthesize.synthesize)
app.command("check", help=check.HELP)(check.check)
app.command("new", help=new.HELP)(new.new)
app.command("schema", help=schema.HELP)(schema.schema)


def main() -> None:
    """Entry point of the console script ``flexmech``; exits with 0, 1, 2 or 130."""
    for stream in (sys.stdout, sys.stderr):
        # A name or source that the terminal's encoding lacks is shown with "?" instead.
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")
    app(prog_name="flexmech")
