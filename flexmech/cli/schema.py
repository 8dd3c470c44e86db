"""``flexmech schema``: the JSON schema of model files."""

from __future__ import annotations

import typer

from flexmech.cli import file_options


def schema(out: file_options.SchemaFile = None) -> None:
    """Print the JSON schema of model files.

    For editors that complete and check TOML.
    """
    import json

    from flexmech.errors import one_line
    from flexmech.files import given_path, write_whole
    from flexmech.modelfile import json_schema

    text = json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"
    if out is None:
        typer.echo(text, nl=False)
    else:
        write_whole(given_path(out), text)
        typer.echo(one_line(f"wrote {given_path(out)}"))
