"""The reference of study files, from their JSON schema and the outputs that there are."""

from __future__ import annotations

from flexmech.studies.outputs import KINDS
from flexmech.studies.study_file import StudyFile
from making.tables_of_schema import TomlReference

__all__ = ["study_file_page"]

HEAD = """# Study files

A study file says what varies of a [model file](model_file.md), what is computed of every design,
which limits it must keep and what is sought: {doc}`../how_to/choose_a_design`. It is
[TOML](https://toml.io) with a unit in every value, as model files are, and all of its errors are
reported at once. `flexmech new study FILE` writes a commented file to start from.

"""
# Tables of the file, in the order in which one writes them, and what they are called there.
PLACES = {
    "VaryTable": '[vary."KEY.OF.THE.MODEL"], or [vary.NAME] with paths',
    "OutputTable": "[outputs.NAME], or NAME = { ... } in [outputs]",
    "LimitTable": "[[limits]]",
    "GoalTable": "[[goals]]",
    "CorrelationTable": "[[correlations]]",
}


def study_file_page() -> str:
    """Markdown of all tables, keys and quantities."""
    rows = ["## Quantities\n", "| quantity | what it is | SI unit |", "|-|-|-|"]
    rows += [
        f"| `{name}` | {kind.words} | {kind.dimension.unit or '1'} |"
        for name, kind in KINDS.items()
    ]
    tables = TomlReference(StudyFile.model_json_schema(), PLACES).markdown()
    return HEAD + tables + "\n".join(rows) + "\n"
