"""Imports run downward, in no circle, and scenarios use public names alone.

An import counts wherever it stands: at the top of a file, inside a function, or for type
checkers alone.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import flexmech

ROOT = Path(flexmech.__file__).parent
SCENARIOS = ROOT.parent / "scenarios"

# From the ground up. A room may import from those before it, and from nothing else.
ORDER = [
    "interruption",
    "docstrings",
    "unit_registry",
    "errors",
    "example_models",
    "arrays",
    "choices",
    "threads",
    "files",
    "units",
    "quantity_lists",
    "plausible",
    "crank_values",
    "validation",
    "model_text",
    "si",
    "plots",
    "materials",
    "dynamical_systems",
    "linkages",
    "sections",
    "mechanism",
    "modelfile",
    "hygrothermal",
    "mesh",
    "modal_testing",
    "measured_data",
    "mechanics",
    "solvers",
    "reference",
    "multibody",
    "analyses",
    "studies",
    "verification",
    "report",
    "cli",
    "__main__",
]
# What stands above another room and must not know it all the same.
STRANGERS = {
    "modelfile": {"plots"},
    "multibody": {"reference"},
    "analyses": {"reference", "multibody"},
}
# The file that takes an engine where somebody gave a mechanism alone.
CHOOSES_ENGINES = ROOT / "analyses" / "default_engines.py"
# A figure is drawn from a dataset: it knows nothing of what computed it.
PLOTS_KNOW = {"arrays", "errors", "units", "plots"}


class Import(NamedTuple):
    """A module that a file imports, and the line where it does."""

    module: str
    line: int


def files() -> list[Path]:
    return sorted(ROOT.rglob("*.py"))


@cache
def parsed(path: Path) -> ast.Module:
    """A file's syntax tree, for all tests at once."""
    return ast.parse(path.read_text(encoding="utf-8"))


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path) for path in files()}


def room_of(module: str) -> str:
    """Room of a module: ``flexmech.reference.engine`` is in ``reference``; "" is the facade."""
    return module.split(".")[1] if "." in module else ""


@cache
def imports(path: Path) -> list[Import]:
    """All imports of a file; a module named as ``from package import module`` by its own name."""
    return list(_imports(path))


def _imports(path: Path) -> Iterator[Import]:
    for node in ast.walk(parsed(path)):
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno} imports are absolute"
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield Import(full if full in MODULES else str(node.module), node.lineno)


def own_imports(path: Path) -> list[Import]:
    return [found for found in imports(path) if found.module.split(".")[0] == "flexmech"]


def refused(room: str, known: str) -> bool:
    """Whether a room may not import from another."""
    if room == "plots":
        return known not in PLOTS_KNOW
    above = ORDER.index(known) > ORDER.index(room)
    return above or known in STRANGERS.get(room, set())


def test_every_room_has_its_place():
    rooms = {room_of(module) for module in MODULES} - {""}
    assert rooms <= set(ORDER), "a room that is not in the order"
    assert set(ORDER) <= rooms, "a place in the order without a room"


def test_imports_run_downward():
    wrong = [
        f"{path.relative_to(ROOT)}:{found.line} imports {found.module}"
        for path in files()
        if (room := room_of(module_of(path)))
        for found in own_imports(path)
        if room_of(found.module) == "" or refused(room, room_of(found.module))
        if (path, room_of(found.module) in STRANGERS["analyses"]) != (CHOOSES_ENGINES, True)
    ]
    assert not wrong, "\n".join(wrong)


def test_files_of_a_room_import_each_other_in_no_circle():
    below = {
        module_of(path): {found.module for found in own_imports(path)} - {module_of(path)}
        for path in files()
        if path.name != "__init__.py"
    }
    below = {module: known & set(below) for module, known in below.items()}
    while below:
        bottom = {module for module, known in below.items() if not known & set(below)}
        assert bottom, f"a circle among {sorted(below)}"
        below = {module: known for module, known in below.items() if module not in bottom}


def test_exudyn_is_imported_in_one_place():
    assert {
        module_of(path)
        for path in files()
        if any(found.module.split(".")[0] == "exudyn" for found in imports(path))
    } == {"flexmech.multibody.items"}


def is_door(module: str) -> bool:
    """Whether a module is the facade, a room, or a file of the ground floor."""
    path = ROOT.parent.joinpath(*module.split("."))
    return path.is_dir() or len(module.split(".")) == 2


def public_names(module: str) -> set[str]:
    """What a room's door exports; of a single file, what it defines without an underscore."""
    loaded = __import__(module, fromlist=["__all__"])
    if hasattr(loaded, "__all__"):
        return set(loaded.__all__)
    tree = ast.parse(Path(str(loaded.__file__)).read_text(encoding="utf-8"))
    stored = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and n.col_offset == 0}
    defined = {n.name for n in tree.body if isinstance(n, ast.FunctionDef | ast.ClassDef)}
    return {name for name in stored | defined if not name.startswith("_")}


def test_scenarios_are_read_alone_and_listed():
    """A script of the gallery imports no module of the folder; the table has its question."""
    listed = (SCENARIOS / "README.md").read_text(encoding="utf-8")
    modules = {path.stem for path in SCENARIOS.rglob("*.py")}
    for path in sorted(SCENARIOS.rglob("*.py")):
        question = (ast.get_docstring(parsed(path)) or "").partition("\n")[0]
        if path.parent == SCENARIOS:
            known = {found.module for found in imports(path)}
            assert not {module.partition(".")[0] for module in known} & modules, path.name
        if path.parent == SCENARIOS or question.endswith("?"):
            place = path.relative_to(SCENARIOS).as_posix()
            assert f"| {question} | [{place}]({place}) |" in listed, place


def test_scenarios_use_public_names_alone():
    """Public is what the doors of ``flexmech`` and its rooms export, never a file within."""
    for path in sorted(SCENARIOS.rglob("*.py")):
        for node in ast.walk(parsed(path)):
            if not isinstance(node, ast.ImportFrom) or str(node.module).split(".")[0] != "flexmech":
                continue
            where = f"{path.name}:{node.lineno} {node.module}"
            assert is_door(str(node.module)), where
            private = {alias.name for alias in node.names} - public_names(str(node.module))
            assert not private, f"{where}: {sorted(private)}"
