"""The package as a text: docstrings that match their signatures, imports that run downward.

Where a "Parameters" section may lack: a callable with one or two parameters, or a record of
up to three fields, whose docstring has no other NumPy section either; a method that overrides
a documented one; a class that names another with a ``Parameters as for`` reference. Fields of
model-file tables and parameters of commands carry their text with them instead.
"""

from __future__ import annotations

import ast
import dataclasses
import enum
import importlib
import inspect
import pkgutil
import re
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest
from pydantic import BaseModel

import flexmech

ROOT = Path(flexmech.__file__).parent
SECTION = re.compile(r"^(\S[^\n]*)\n-{3,}\n", re.MULTILINE)
REFERENCE = re.compile(r"Parameters as for\s+:class:`([\w.]+)`")
PLAIN_PARAMETERS, PLAIN_FIELDS = 2, 3


def module_names() -> list[str]:
    found = pkgutil.walk_packages(flexmech.__path__, "flexmech.")
    return ["flexmech", *sorted(m.name for m in found)]


MODULES = module_names()
# Importing the entry point is running it.
LIBRARY = [name for name in MODULES if name != "flexmech.__main__"]


class Subject(NamedTuple):
    """A public class or callable; ``owner`` is a method's class."""

    label: str
    value: Any
    owner: type | None


def subjects() -> Iterator[Subject]:
    """What the modules' ``__all__`` name, each where it is defined, and its public methods."""
    for name in LIBRARY:
        module = importlib.import_module(name)
        for public in module.__all__:
            value = getattr(module, public)
            if getattr(value, "__module__", None) != name:
                continue
            if inspect.isclass(value):
                yield Subject(f"{name}.{public}", value, None)
                yield from methods(f"{name}.{public}", value)
            elif inspect.isfunction(value):
                yield Subject(f"{name}.{public}", value, None)


def methods(label: str, owner: type) -> Iterator[Subject]:
    for name, member in vars(owner).items():
        value = getattr(member, "__func__", member)  # of a class method
        if isinstance(value, property):
            value = value.fget
        value = getattr(value, "func", value)  # of a cached property
        if inspect.isfunction(value) and not name.startswith("_"):
            yield Subject(f"{label}.{name}", value, owner)


SUBJECTS = list(subjects())
each_subject = pytest.mark.parametrize("subject", SUBJECTS, ids=[s.label for s in SUBJECTS])
each_library_module = pytest.mark.parametrize("name", LIBRARY)


def parameters(subject: Subject) -> list[str]:
    """Names that a "Parameters" section must give."""
    if inspect.isclass(subject.value) and not has_own_parameters(subject.value):
        return []
    return [
        p.name
        for p in inspect.signature(subject.value).parameters.values()
        if p.name not in ("self", "cls")
        and not p.name.startswith("_")
        and p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)
    ]


def has_own_parameters(cls: type) -> bool:
    foreign = (enum.Enum, BaseException, dict, list, str)
    return not (issubclass(cls, foreign) or getattr(cls, "_is_protocol", False))


def sections(doc: str) -> dict[str, str]:
    parts = SECTION.split(inspect.cleandoc(doc))
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def documented(section: str) -> list[str]:
    """Names of a "Parameters" section; ``a, b : type`` gives two."""
    entries = [line for line in section.splitlines() if line and not line[0].isspace()]
    return [name.strip() for entry in entries for name in entry.split(" :")[0].split(",")]


def speaks_for_itself(subject: Subject, wanted: list[str], doc: str) -> bool:
    """Whether a docstring may do without the section."""
    value = subject.value
    if inspect.isclass(value) and issubclass(value, BaseModel):
        return all(is_described(field) for field in value.model_fields.values())
    if carries_help(value):
        return True
    if overrides(subject) or refers(value, wanted, doc):
        return True
    most = PLAIN_FIELDS if dataclasses.is_dataclass(value) else PLAIN_PARAMETERS
    return len(wanted) <= most and not sections(doc)


def is_described(field: Any) -> bool:
    """Whether a table's field has a description or holds tables or one fixed word."""
    if field.description:
        return True
    return typing.get_origin(field.annotation) is typing.Literal or holds_table(field.annotation)


def holds_table(annotation: Any) -> bool:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return bool(annotation.__doc__)
    return any(holds_table(argument) for argument in typing.get_args(annotation))


def carries_help(value: Any) -> bool:
    """Whether each parameter of a command has its help text."""
    module = getattr(value, "__module__", "")
    if not inspect.isfunction(value) or not module.startswith("flexmech.cli"):
        return False
    try:
        hints = typing.get_type_hints(value, include_extras=True)
    except NameError:  # names for type checkers only: no command
        return False
    hints.pop("return", None)
    return bool(hints) and all(
        any(getattr(extra, "help", None) for extra in getattr(hint, "__metadata__", ()))
        for hint in hints.values()
    )


def overrides(subject: Subject) -> bool:
    if subject.owner is None:
        return False
    name = subject.value.__name__
    return any(
        name in vars(base) and base.__module__.startswith("flexmech")
        for base in subject.owner.__mro__[1:]
    )


def refers(value: Any, wanted: list[str], doc: str) -> bool:
    """Whether the docstring names a class that documents the same parameters."""
    match = REFERENCE.search(doc)
    if match is None or not inspect.isclass(value):
        return False
    module, _, name = match[1].rpartition(".")
    other = getattr(importlib.import_module(module), name)
    return documented(sections(other.__doc__)["Parameters"]) == wanted


def test_there_is_something_to_check():
    assert len(LIBRARY) > 40
    assert len(SUBJECTS) > 150
    assert sum("Parameters" in sections(s.value.__doc__ or "") for s in SUBJECTS) > 60


@each_subject
def test_it_has_a_docstring_of_its_own(subject):
    doc = subject.value.__doc__
    assert doc, subject.label
    # What dataclass makes up from the fields is no docstring.
    assert not doc.startswith(f"{subject.value.__name__}(")
    assert doc.strip().splitlines()[0].rstrip()[-1] in ".:", "the first line is a sentence"


@each_subject
def test_parameters_are_those_of_the_signature(subject):
    wanted, doc = parameters(subject), subject.value.__doc__ or ""
    section = sections(doc).get("Parameters")
    if section is None:
        assert not wanted or speaks_for_itself(subject, wanted, doc), (
            f"{subject.label} needs a Parameters section for {', '.join(wanted)}"
        )
    else:
        assert sorted(documented(section)) == sorted(wanted)


@pytest.mark.parametrize(
    ("doc", "names"),
    [
        ("Do.\n\nParameters\n----------\na, b : float\n    In m.\nc\n", "abc"),
        ("Do.\n\nParameters\n----------\na : {1, 2}\n\nReturns\n-------\nb\n", "a"),
    ],
)
def test_names_are_read_from_a_section(doc, names):
    assert documented(sections(doc)["Parameters"]) == list(names)


def test_a_wrong_section_is_found():
    def scale(length: float, factor: float) -> float:
        """Scale.

        Parameters
        ----------
        length, ratio : float
        """
        return length * factor

    with pytest.raises(AssertionError):
        test_parameters_are_those_of_the_signature(Subject("scale", scale, None))


def test_a_lacking_section_is_found():
    def volume(a: float, b: float, c: float) -> float:
        """Volume."""
        return a * b * c

    def area(a: float, b: float) -> float:
        """Area.

        Returns
        -------
        float
        """
        return a * b

    for function in (volume, area):
        with pytest.raises(AssertionError, match="needs a Parameters section"):
            test_parameters_are_those_of_the_signature(Subject("it", function, None))


@pytest.mark.parametrize("name", MODULES)
def test_a_module_says_what_it_is(name):
    doc = ast.get_docstring(tree_of(name))
    assert doc
    assert doc.splitlines()[0].endswith(".")


def sort_key(name: str) -> tuple[int, str]:
    """Constants, classes, functions; ruff's order (RUF022)."""
    return (0 if name.isupper() else 1 if name[0].isupper() else 2, name)


@each_library_module
def test_all_is_sorted_and_exists(name):
    module: ModuleType = importlib.import_module(name)
    assert list(module.__all__) == sorted(set(module.__all__), key=sort_key)
    for public in module.__all__:
        assert not public.startswith("_")
        assert hasattr(module, public), public


# ---- imports -------------------------------------------------------------------------------

# What each part of the package may know of the others; all but the facade stand below it.
MAY_IMPORT: dict[str, set[str]] = {
    "errors": set(),
    "threads": set(),
    "files": {"errors"},
    "units": {"errors"},
    "mesh": {"errors"},
    "materials": {"errors"},
    "linkages": {"errors"},
    "sections": {"errors", "materials"},
    "mechanism": {"errors", "linkages", "materials", "sections"},
}
MAY_IMPORT["hygrothermal"] = {*MAY_IMPORT["mechanism"], "mechanism"}
MAY_IMPORT["linear_system"] = {*MAY_IMPORT["mechanism"], "mechanism", "mesh", "threads"}
MAY_IMPORT["time_domain"] = {*MAY_IMPORT["linear_system"], "linear_system"}
MAY_IMPORT["reference"] = {*MAY_IMPORT["linear_system"], "linear_system"}
MAY_IMPORT["multibody"] = {*MAY_IMPORT["time_domain"], "time_domain"}
MAY_IMPORT["analyses"] = {*MAY_IMPORT["time_domain"], "time_domain", "files", "modelfile", "units"}
MAY_IMPORT["plots"] = {"errors", "files", "units"}
MAY_IMPORT["modelfile"] = {*MAY_IMPORT["mechanism"], "mechanism", "units", "files"}
MAY_IMPORT["cli"] = set(MAY_IMPORT)
MAY_IMPORT["__main__"] = {"cli"}

# Drawing is a convenience of the result; the library is loaded only when asked for.
ALLOWED_LAZILY = {
    ("flexmech.analyses.result", "MovingFrequencies.plot", "flexmech.plots"),
    ("flexmech.analyses.response.result", "Response.plot", "flexmech.plots"),
    ("flexmech.analyses.hygrothermal_effect", "HygrothermalEffect.plot", "flexmech.plots"),
}


class Import(NamedTuple):
    """An import statement's module and the class and function it stands in."""

    module: str
    where: str


def path_of(name: str) -> Path:
    stem = ROOT.joinpath(*name.split(".")[1:])
    return stem / "__init__.py" if stem.is_dir() else stem.with_suffix(".py")


def tree_of(name: str) -> ast.Module:
    return ast.parse(path_of(name).read_text(encoding="utf-8"))


def imports(tree: ast.AST, where: str = "") -> Iterator[Import]:
    """All imports of a module, inside functions and for type checkers too."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, where) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found = [full if full in MODULES else str(node.module) for full in names]
            yield from (Import(module, where) for module in dict.fromkeys(found))
        elif isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield from imports(node, f"{where}.{node.name}".lstrip("."))
        else:
            yield from imports(node, where)


def part_of(module: str) -> str:
    """Part of the package: ``flexmech.reference.engine`` is of ``reference``."""
    return module.split(".")[1] if "." in module else ""


def test_every_part_has_its_place():
    assert {part_of(name) for name in MODULES} - {""} == set(MAY_IMPORT)


def test_the_parts_stand_above_each_other():
    """The table itself holds no circle."""
    below = {part: known - {part} for part, known in MAY_IMPORT.items() if part != "__main__"}
    below["cli"] = set(below) - {"cli"}
    while below:
        bottom = {part for part, known in below.items() if not known & set(below)}
        assert bottom, f"a circle among {sorted(below)}"
        below = {part: known for part, known in below.items() if part not in bottom}


@pytest.mark.parametrize("name", MODULES[1:])
def test_imports_run_downward(name):
    part = part_of(name)
    for found in imports(tree_of(name)):
        if found.module.split(".")[0] != "flexmech":
            continue
        known = part_of(found.module)
        assert known, f"{name} imports from the facade"
        if known != part and (name, found.where, found.module) not in ALLOWED_LAZILY:
            assert known in MAY_IMPORT[part], f"{name} imports {found.module}"


def test_what_is_allowed_lazily_is_used():
    for name, where, module in ALLOWED_LAZILY:
        assert Import(module, where) in list(imports(tree_of(name)))


@pytest.mark.parametrize("name", MODULES)
def test_exudyn_is_imported_in_one_place(name):
    wanted = [i for i in imports(tree_of(name)) if i.module.split(".")[0] == "exudyn"]
    if name == "flexmech.multibody.library":
        assert {i.where for i in wanted} == {"load_exudyn"}
    else:
        assert not wanted


def test_only_the_facade_imports_by_name():
    """An import that the checks above could not see."""
    for name in MODULES:
        calls = [node.func for node in ast.walk(tree_of(name)) if isinstance(node, ast.Call)]
        called = {getattr(call, "id", getattr(call, "attr", "")) for call in calls}
        assert not called & {"import_module", "__import__"} or name == "flexmech"


def test_the_facade_names_each_home():
    for name in flexmech.__all__:
        value: Callable[..., Any] = getattr(flexmech, name)
        assert value.__module__.startswith(f"flexmech.{flexmech._HOMES[name]}")
    assert set(flexmech.__all__) == set(flexmech._HOMES)
