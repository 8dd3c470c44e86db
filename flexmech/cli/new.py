"""``flexmech new``: a commented model file to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexmech.choices import TemplateKind
from flexmech.cli.failures import reports_failures
from flexmech.errors import InputError
from flexmech.files import write_whole

__all__ = ["HELP", "new"]

HELP = "Write a commented model file to start from."


@reports_failures
def new(
    kind: Annotated[TemplateKind, typer.Argument(help="Kind of linkage.")],
    file: Annotated[Path, typer.Argument(help="Model file to write.", metavar="FILE")],
    force: Annotated[bool, typer.Option("--force", help="Replace a file that exists.")] = False,
) -> None:
    """Write the template of a kind of linkage, but never over a file without ``--force``."""
    from flexmech.modelfile import template

    if file.exists() and not file.is_dir() and not force:
        raise InputError(f"{file}: exists already; choose another name, or --force to replace it")
    write_whole(file, template(kind))
    typer.echo(f"wrote {file}; next: flexmech check {file}")
