"""The options of the commands that write one file: model files, their schema, the report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

from typer import Argument, Option

from flexmech import choices
from flexmech.cli.paths import typed_path
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
NewFile = Annotated[Path, Argument(help="Model file to write.", metavar="FILE", parser=typed_path)]
Force = Annotated[bool, Option("--force", help="Replace a file that exists.")]
SchemaFile = Annotated[
    Path | None,
    Option("--out", help="Write it to this file instead.", metavar="FILE", parser=typed_path),
]
ModelOrResults = Annotated[
    Path,
    Argument(
        help="Model file, or folder of results of other commands.",
        metavar="MODEL|RESULTS",
        parser=typed_path,
    ),
]
ReportFile = Annotated[
    Path, Option("--out", help="HTML file to write.", metavar="FILE", parser=typed_path)
]
