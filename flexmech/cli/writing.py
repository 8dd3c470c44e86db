"""Commands that write one text: a model file to start from, and the schema of model files."""

from __future__ import annotations

from typing import Annotated, get_args

import typer
from typer import Argument, Option

from flexmech.choices import TemplateKind
from flexmech.cli import options
from flexmech.errors import InputError, one_line, suggestion
from flexmech.example_models import example_model, example_names
from flexmech.files import given_path, write_whole

_KINDS = get_args(TemplateKind)
_KINDS_AND_EXAMPLES = (*_KINDS, *example_names())


def _completed(incomplete: str) -> list[str]:
    return [name for name in _KINDS_AND_EXAMPLES if name.startswith(incomplete)]


def new(
    start: Annotated[
        str,
        Argument(
            help=f"Kind of linkage: {', '.join(_KINDS)}; or an example: "
            f"{', '.join(example_names())}.",
            metavar="KIND|EXAMPLE",
            autocompletion=_completed,
        ),
    ],
    file: options.GivenPath,
    force: Annotated[bool, Option("--force")] = False,
) -> None:
    """Write a commented model file to start from: of a kind of linkage, or an example.

    Options
    -------
    file : FILE
        Model file to write.
    force
        Replace a file that exists.
    """
    if start in _KINDS:
        from flexmech.modelfile import template

        text = template(start)
    elif start in _KINDS_AND_EXAMPLES:
        text = example_model(start).read_text(encoding="utf-8")
    else:
        raise InputError(
            f"there is no kind of linkage and no example {start!r}; "
            f"{suggestion(start, _KINDS_AND_EXAMPLES)}"
        )
    file = given_path(file)
    if file.exists() and not file.is_dir() and not force:
        raise InputError(f"{file}: exists already; choose another name, or --force to replace it")
    write_whole(file, text)
    typer.echo(one_line(f"wrote {file}; next: flexmech check {file}"))


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
