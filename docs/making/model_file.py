"""The reference of model files, from their JSON schema."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from flexmech.modelfile import json_schema

__all__ = ["model_file_page"]

HEAD = """# Model files

A model file is [TOML](https://toml.io). Every value with a dimension is text with its unit:
`"279.4 mm"`, `"70 GPa"`, `"190 rpm"`. Unknown keys are refused, and all errors of a file are told
at once, each with the place and the remedy. `flexmech new four-bar FILE` writes a commented file to
start from, `flexmech check FILE` says what was understood, and `flexmech schema` prints the schema
from which this page is made, for editors that complete and check TOML.

"""
# Tables of the file, in the order in which one writes them, and what they are called there.
PLACES = {
    "FourBarTable": "[linkage], kind four-bar",
    "RotatingArmTable": "[linkage], kind rotating-arm",
    "PlanarTable": "[linkage], kind planar",
    "CouplerPointTable": "coupler_point of [linkage]",
    "MaterialTable": "[materials.NAME]",
    "RectangleLinkTable": "[links.NAME], section rectangle",
    "LaminateLinkTable": "[links.NAME], section laminate",
    "GeneralLinkTable": "[links.NAME], section general",
    "RigidLinkTable": "[links.NAME], rigid = true, without section",
    "PointMassTable": "[[links.NAME.point_masses]]",
    "BodyTable": "[[links.NAME.bodies]]",
    "JointTable": "[joints.NAME]",
    "ShaftTable": "[shaft]",
    "LoadTable": "[loads.NAME]",
    "SpringTable": "[springs.NAME]",
    "FibreTable": "[fibres.NAME]",
    "MatrixTable": "[matrices.NAME]",
    "OrthotropicPlyTable": "[plies.NAME], type orthotropic",
    "ConstituentPlyTable": "[plies.NAME], type constituents",
    "IsotropicPlyTable": "[plies.NAME], type isotropic",
    "LaminateTable": "[laminates.NAME]",
    "EnvironmentTable": "[environment]",
    "OperationTable": "[operation]",
}


def model_file_page() -> str:
    """Markdown of all tables and keys."""
    schema = json_schema()
    definitions = schema["$defs"]
    parts = [HEAD, "## Top of the file\n", _table(schema, schema), ""]
    others = sorted(set(definitions) - set(PLACES))
    for name in [*PLACES, *others]:
        table = definitions[name]
        title = PLACES.get(name, f"{name.removesuffix('Table')} (a table inside others)")
        parts += [f"## {_code(title)}\n", table.get("description", ""), ""]
        parts += [_table(table, schema), ""]
    return "\n".join(parts) + "\n"


def _code(title: str) -> str:
    """The table's name as code, what follows as text."""
    name, comma, rest = title.partition(",")
    return f"`{name}`{comma}{rest}" if name.startswith(("[", "coupler")) else title


def _table(table: dict[str, Any], schema: dict[str, Any]) -> str:
    required = set(table.get("required", ()))
    rows = ["| key | value | what it is |", "|-|-|-|"]
    keys = table.get("properties", {})
    # What has to be there stands first; the order is the schema's otherwise.
    for key, entry in sorted(keys.items(), key=lambda item: item[0] not in required):
        value = " or ".join(dict.fromkeys(_values(entry, schema)))
        if key in required:
            value += "; required"
        elif entry.get("default") not in (None, "", [], {}):
            value += f"; left out: `{entry['default']}`"
        rows.append(f"| `{key}` | {value} | {entry.get('description', '')} |".replace("\n", " "))
    return "\n".join(rows)


def _values(entry: dict[str, Any], schema: dict[str, Any]) -> Iterator[str]:
    """What may stand behind a key, in words."""
    if "$ref" in entry:
        name = entry["$ref"].rpartition("/")[2]
        yield f"a table {_code(PLACES.get(name, name.removesuffix('Table')))}"
    elif "const" in entry:
        yield f'`"{entry["const"]}"`'
    elif "enum" in entry:
        yield " or ".join(f'`"{choice}"`' for choice in entry["enum"])
    elif branches := entry.get("anyOf") or entry.get("oneOf"):
        for branch in branches:
            yield from _values(branch, schema)
    elif entry.get("type") == "array":
        inside = " or ".join(dict.fromkeys(_values(entry.get("items", {}), schema)))
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
