"""The options that several commands share, with the library's own words as choices."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from flexmech import choices
from flexmech.analyses import typed
from flexmech.analyses.typed import Together
from flexmech.cli.deliver import Output, Pictures, Printing, command_name, typed_path
from flexmech.errors import InputError

# Defaults as users type them.
AUTO: Any = "auto"
ALL: Any = "all"
PNG: Any = "png"

Model = Annotated[Path, Argument(help="Model file.", metavar="MODEL", parser=typed_path)]
TypedPath = Annotated[Path, Option(parser=typed_path)]
OptionalPath = Annotated[Path | None, Option(parser=typed_path)]
GivenPath = Annotated[Path, Argument(parser=typed_path)]


def asked_pictures(
    no_plots: Annotated[bool, Option("--no-plots")] = False,
    formats: Annotated[tuple[choices.PictureFormat, ...], typed.FORMATS] = PNG,
    width: choices.PageWidth = "two-column",
    every: Annotated[bool, Option("--all")] = False,
) -> Pictures:
    """Which pictures are written, their formats and width.

    Options
    -------
    no_plots
        Write no pictures.
    formats : LIST
        Formats of the pictures: png, pdf, svg or several.
    width
        Width of the pictures on a journal's page: 88 mm or 180 mm.
    every
        Write all pictures. Left out: those that the answer needs.
    """
    if no_plots and every:
        raise InputError("--no-plots and --all: give one of them")
    return Pictures(() if no_plots else formats, width, every)


def asked_printing(
    details: Annotated[bool, Option("--details")] = False,
    quiet: Annotated[bool, Option("--quiet")] = False,
    as_json: Annotated[bool, Option("--json")] = False,
) -> Printing:
    """How the summary is printed.

    Options
    -------
    details
        Print all that is known, as summary.txt beside the files has it.
    quiet
        Print warnings and errors alone.
    as_json
        Print answer, numbers, units and errors as JSON, for programs.
    """
    asked: dict[Printing, bool] = {"details": details, "nothing": quiet, "json": as_json}
    chosen = [printing for printing, wanted in asked.items() if wanted]
    if len(chosen) > 1:
        raise InputError("--details, --quiet and --json: give one of them")
    return chosen[0] if chosen else "answer"


AskedPictures = Annotated[Pictures, Together(asked_pictures)]
AskedPrinting = Annotated[Printing, Together(asked_printing)]


def asked_output(
    *, out: TypedPath = Path("results"), pictures: AskedPictures, printing: AskedPrinting
) -> Output:
    """Files, pictures and what is printed.

    Options
    -------
    out : DIR
        The files go into a folder of the command's name within DIR.
    """
    return Output(out / command_name(), pictures, printing)


def asked_optional_output(
    *, out: OptionalPath = None, pictures: AskedPictures, printing: AskedPrinting
) -> Output:
    """Files and pictures if a folder is named, and what is printed.

    Options
    -------
    out : DIR
        The files go into a folder of the command's name within DIR. Left out: no files.
    """
    return Output(out and out / command_name(), pictures, printing)


AskedOutput = Annotated[Output, Together(asked_output)]
AskedOptionalOutput = Annotated[Output, Together(asked_optional_output)]
