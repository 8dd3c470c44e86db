"""Commands on a model file and its links: to begin one, what it says, sections, and water."""

from __future__ import annotations

import sys
from typing import Annotated, get_args

import typer
from typer import Argument, Option

from flexmech import studies
from flexmech.analyses.options import (
    CheckOptions,
    MoistureOptions,
    SectionOptions,
    StrengthOptions,
)
from flexmech.analyses.typed import Together
from flexmech.choices import TemplateKind
from flexmech.cli import options
from flexmech.cli.asking import question
from flexmech.errors import InputError, one_line, suggestion
from flexmech.example_models import example_model, example_names
from flexmech.files import given_path, write_whole

_KINDS = get_args(TemplateKind)
_KINDS_AND_EXAMPLES = (*_KINDS, "study", *example_names())


def _completed(incomplete: str) -> list[str]:
    return [name for name in _KINDS_AND_EXAMPLES if name.startswith(incomplete)]


check = question("check", "check.check_mechanism", CheckOptions, files=False)
section = question("section", "section_profile.section_profiles", SectionOptions, files=False)
moisture = question("moisture", "moisture.moisture_uptake", MoistureOptions)
strength = question("strength", "strength.strength", StrengthOptions, engine="reference")


def asked_sizes(
    crank: str | None = None,
    rod: str | None = None,
    offset: str | None = None,
    mass: str | None = None,
    speed: str | None = None,
) -> dict[str, str | None]:
    """Sizes of a slider-crank; those left out are asked for on a terminal.

    Options
    -------
    crank
        Crank length of a slider-crank.
    rod
        Rod length of a slider-crank.
    offset
        Offset of the slider's line from the shaft's axis.
    mass
        Mass of the slider, such as 0.15 kg.
    speed
        Its crank speed, such as 1500 rpm.
    """
    return {"crank": crank, "rod": rod, "offset": offset, "mass": mass, "speed": speed}


def new(
    start: Annotated[
        str,
        Argument(
            help=f"Kind of linkage: {', '.join(_KINDS)}; study; or an example: "
            f"{', '.join(example_names())}.",
            metavar="KIND|EXAMPLE",
            autocompletion=_completed,
        ),
    ],
    file: options.GivenPath,
    force: Annotated[bool, Option("--force")] = False,
    *,
    sizes: Annotated[dict[str, str | None], Together(asked_sizes)],
) -> None:
    """Write a commented model file: a template or an example.

    The model is named after the file; an example keeps its name. A study's model is written beside
    it.

    Options
    -------
    file : FILE
        Model file to write.
    force
        Replace a file that exists.
    """
    if start not in _KINDS_AND_EXAMPLES:
        raise InputError(
            f"there is no kind of linkage and no example {start!r}; "
            f"{suggestion(start, _KINDS_AND_EXAMPLES)}"
        )
    file = given_path(file)
    if file.exists() and not file.is_dir() and not force:
        raise InputError(f"{file}: exists already; choose another name, or --force to replace it")
    if start in _KINDS:
        from flexmech.modelfile import new_file

        on_terminal = sys.stdin.isatty() and sys.stdout.isatty()
        text = new_file(start, file.stem, sizes, typer.prompt if on_terminal else None)
    elif given := [f"--{size}" for size, own in sizes.items() if own is not None]:
        raise InputError(f"{given[0]} is of a new slider-crank; leave it out, and edit the example")
    elif start == "study":
        text = studies.new_study()
    else:
        text = example_model(start).read_text(encoding="utf-8")
    write_whole(file, text)
    written, following = str(file), "check"
    if start == "study":
        following, model = "sweep", file.with_name(f"{studies.EXAMPLE_OF_A_STUDY}.toml")
        # A study runs as it is written; a model file that is there is the user's own.
        if not model.exists():
            write_whole(model, example_model(model.stem).read_text(encoding="utf-8"))
            written += f" and {model}, its model"
    typer.echo(one_line(f"wrote {written}; next: flexmech {following} {file}"))


def schema(out: options.OptionalPath = None) -> None:
    """Print the JSON schema of model files.

    For editors that complete and check TOML.

    Options
    -------
    out : FILE
        Write it to this file instead.
    """
    import json

    from flexmech.modelfile import json_schema

    text = json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"
    if out is None:
        typer.echo(text, nl=False)
    else:
        write_whole(given_path(out), text)
        typer.echo(one_line(f"wrote {given_path(out)}"))
