"""Columns of CSV files, pictures and variables of NetCDF files, as the schemas have them."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

from flexmech.analyses.schema import EACH, schema_of

__all__ = ["PAGE", "variable_page", "with_columns"]

PAGE = Path(__file__).parents[1] / "files.md"
# What stands between these two comments of the page is generated.
_BLOCK = re.compile(r"<!-- columns of (\w+) -->\n.*?<!-- end of columns -->", re.DOTALL)
_AXES = ("x", "y")


def with_columns(page: str) -> str:
    """The text of the page with the tables that the schemas give."""
    return _BLOCK.sub(
        lambda found: (
            f"<!-- columns of {found[1]} -->\n{_tables(found[1])}\n<!-- end of columns -->"
        ),
        page,
    )


def _tables(analysis: str) -> str:
    schema = schema_of(f"flexmech.analyses.{analysis}")
    rows = ["| file | columns |", "|-|-|"]
    for name, table in schema.tables.items():
        when = f", {schema.when[name]}" if name in schema.when else ""
        usual = [column for dim in table.over for column in schema.index[dim]]
        if "position" in table.over:
            usual.remove("time_s")
        further = dict[str, list[str]]()
        for group in table.columns:
            is_usual = group == name or group not in schema.when
            columns = usual if is_usual else further.setdefault(schema.when[group], [])
            columns += schema.columns[group]
        cells = [_code(usual), *(f"{words} {_code(columns)}" for words, columns in further.items())]
        rows.append(f"| `{name}.csv`{when} | {'; '.join(cells)} |")
    pictures = [(f"`{name}.png`", one.detail) for name, one in schema.pictures.items()]
    shown, more = (", ".join(n for n, one in pictures if one is d) for d in (False, True))
    if shown:
        rows += ["", f"Pictures: {shown}" + (f"; with `--all` {more}." if more else ".")]
    return "\n".join(rows)


def _code(columns: list[str]) -> str:
    return f"`{', '.join(name for column in columns for name in _names(column))}`"


def _names(column: str) -> list[str]:
    """A column for each axis; of other things their word in angle brackets."""
    if "{component}" in column:
        return [column.replace("{component}", axis) for axis in _AXES]
    return [EACH.sub(r"<\1>", column)]


HEAD = """# Variables of NetCDF files

What the dataset of each result holds, where there is such a thing: `result.dataset` in Python.
Among the dimensions `position` is the crank angle, or the time under a law of motion. What several
engines compute is over `engine` too, and with heat and moisture over `state`. The columns of CSV
files stand in {doc}`../files`.

"""


def variable_page() -> str:
    """Markdown of all variables: what they are over, their units, and what they are."""
    folder = resources.files("flexmech.analyses")
    analyses = sorted(one.name for one in folder.iterdir() if one.joinpath("schema.toml").is_file())
    parts = [HEAD]
    for analysis in analyses:
        rows = [f"## `{analysis}`\n", "| variable | over | unit | what it is |", "|-|-|-|-|"]
        rows += [
            f"| `{name}` | {', '.join(one.over)} | {one.unit} | {one.long_name} |"
            for name, one in schema_of(f"flexmech.analyses.{analysis}").variables.items()
        ]
        parts.append("\n".join(rows) + "\n\n")
    return "".join(parts)
