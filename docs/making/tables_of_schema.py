"""The reference of a kind of TOML file, from the JSON schema that checks it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["TomlReference"]

# Short lists of a fixed length are described as such.
COUNTS = {1: "one", 2: "two", 3: "three"}


@dataclass(frozen=True)
class TomlReference:
    """Tables and keys of a kind of file.

    Parameters
    ----------
    schema : mapping
        JSON schema (draft 2020-12), as pydantic writes it.
    places : mapping of str to str
        Where each table stands in the file, by its name in the schema, in the order in which one
        writes them.
    """

    schema: Mapping[str, Any]
    places: Mapping[str, str]

    def markdown(self) -> str:
        """A section for each table, a row for each of its keys."""
        definitions = self.schema["$defs"]
        parts = ["## Top of the file\n", self._table(self.schema), ""]
        for name in [*self.places, *sorted(set(definitions) - set(self.places))]:
            table = definitions[name]
            title = self.places.get(name, f"{name.removesuffix('Table')} (a table inside others)")
            parts += [f"## {_code(title)}\n", table.get("description", ""), ""]
            parts += [self._table(table), ""]
        return "\n".join(parts) + "\n"

    def _table(self, table: Mapping[str, Any]) -> str:
        required = set(table.get("required", ()))
        rows = ["| key | value | what it is |", "|-|-|-|"]
        keys = table.get("properties", {})
        # What has to be there stands first; the order is the schema's otherwise.
        for key, entry in sorted(keys.items(), key=lambda item: item[0] not in required):
            value = " or ".join(dict.fromkeys(self._values(entry)))
            if key in required:
                value += "; required"
            elif entry.get("default") not in (None, "", [], {}):
                value += f"; left out: `{entry['default']}`"
            rows.append(
                f"| `{key}` | {value} | {entry.get('description', '')} |".replace("\n", " ")
            )
        return "\n".join(rows)

    def _values(self, entry: Mapping[str, Any]) -> Iterator[str]:
        """What may stand behind a key, in words."""
        if "$ref" in entry:
            name = entry["$ref"].rpartition("/")[2]
            yield f"a table {_code(self.places.get(name, name.removesuffix('Table')))}"
        elif "const" in entry:
            yield f'`"{entry["const"]}"`'
        elif "enum" in entry:
            yield " or ".join(f'`"{choice}"`' for choice in entry["enum"])
        elif branches := entry.get("anyOf") or entry.get("oneOf"):
            for branch in branches:
                yield from self._values(branch)
        elif "prefixItems" in entry:
            parts = entry["prefixItems"]
            inside = " or ".join(
                dict.fromkeys(each for part in parts for each in self._values(part))
            )
            yield f"a list of {COUNTS[len(parts)]}: {inside}"
        elif entry.get("type") == "array":
            inside = " or ".join(dict.fromkeys(self._values(entry.get("items", {}))))
            yield f"a list of: {inside or 'values'}"
        elif entry.get("type") == "object":
            yield "tables by name"
        elif "examples" in entry:
            yield f'text such as `"{entry["examples"][0]}"`'
        elif "pattern" in entry or entry.get("type") == "string":
            yield "text"
        elif entry.get("type") in ("number", "integer"):
            yield "a number"
        elif entry.get("type") == "boolean":
            yield "`true` or `false`"


def _code(title: str) -> str:
    """The table's name as code, what follows as text."""
    name, comma, rest = title.partition(",")
    return f"`{name}`{comma}{rest}" if name.startswith(("[", "coupler")) else title
