"""The options of the commands that write model files and their schema."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

from typer import Argument, Option

from flexmech import choices
from flexmech.example_models import example_names

_KINDS_AND_EXAMPLES = (*get_args(choices.TemplateKind), *example_names())
KindOrExample = Annotated[
    str,
    Argument(
        help=f"Kind of linkage: {', '.join(get_args(choices.TemplateKind))}; or an example: "
        f"{', '.join(example_names())}.",
        metavar="KIND|EXAMPLE",
        autocompletion=lambda incomplete: [
            name for name in _KINDS_AND_EXAMPLES if name.startswith(incomplete)
        ],
    ),
]
NewFile = Annotated[Path, Argument(help="Model file to write.", metavar="FILE")]
Force = Annotated[bool, Option("--force", help="Replace a file that exists.")]
SchemaFile = Annotated[
    Path | None, Option("--out", help="Write it to this file instead.", metavar="FILE")
]
