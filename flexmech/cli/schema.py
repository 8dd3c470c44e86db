"""``flexmech schema``: the JSON schema of model files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexmech.cli.failures import reports_failures

__all__ = ["HELP", "schema"]

HELP = "Print the JSON schema of model files. For editors that complete and check TOML."


@reports_failures
def schema(
    out: Annotated[
        Path | None, typer.Option("--out", help="Write it to this file instead.", metavar="FILE")
    ] = None,
) -> None:
    """Print the JSON schema, or write it to a file."""
    import json

    from flexmech.files import write_whole
    from flexmech.modelfile import json_schema

    text = json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"
    if out is None:
        typer.echo(text, nl=False)
    else:
        write_whole(out, text)
        typer.echo(f"wrote {out}")
