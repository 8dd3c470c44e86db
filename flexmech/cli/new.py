"""``flexmech new``: a commented model file to start from."""

from __future__ import annotations

from typing import get_args

import typer

from flexmech.choices import TemplateKind
from flexmech.cli import file_options
from flexmech.errors import InputError, one_line, suggestion
from flexmech.example_models import example_model, example_names
from flexmech.files import given_path, write_whole


def new(
    start: file_options.KindOrExample, file: file_options.NewFile, force: file_options.Force = False
) -> None:
    """Write a commented model file to start from: of a kind of linkage, or an example."""
    text = _text(start)
    file = given_path(file)
    if file.exists() and not file.is_dir() and not force:
        raise InputError(f"{file}: exists already; choose another name, or --force to replace it")
    write_whole(file, text)
    typer.echo(one_line(f"wrote {file}; next: flexmech check {file}"))


def _text(start: str) -> str:
    """Text of the template of a kind, or of an example with its comments."""
    if start in get_args(TemplateKind):
        from flexmech.modelfile import template

        return template(start)
    known = (*get_args(TemplateKind), *example_names())
    if start not in known:
        raise InputError(
            f"there is no kind of linkage and no example {start!r}; {suggestion(start, known)}"
        )
    return example_model(start).read_text(encoding="utf-8")
