"""``flexmech new``: a commented model file to start from."""

from __future__ import annotations

import typer

from flexmech.cli import options
from flexmech.errors import InputError, one_line
from flexmech.files import given_path, write_whole


def new(kind: options.TemplateKind, file: options.NewFile, force: options.Force = False) -> None:
    """Write a commented model file to start from."""
    from flexmech.modelfile import template

    file = given_path(file)
    if file.exists() and not file.is_dir() and not force:
        raise InputError(f"{file}: exists already; choose another name, or --force to replace it")
    write_whole(file, template(kind))
    typer.echo(one_line(f"wrote {file}; next: flexmech check {file}"))
