"""The package as a text: docstrings that match their signatures.

Where a "Parameters" section may lack: a callable with one or two parameters, or a record of
up to three fields, whose docstring has no other NumPy section either; a method that overrides
a documented one; a class that names another with a ``Parameters as for`` reference. Fields of
model-file tables and parameters of commands carry their text with them instead.
"""

from __future__ import annotations

import dataclasses
import enum
import importlib
import inspect
import pkgutil
import re
import typing
from collections.abc import Iterator, Mapping
from types import ModuleType
from typing import Any, NamedTuple

from pydantic import BaseModel

import flexmech
from flexmech.cli.reading import from_options

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


def public_names(module: ModuleType) -> list[str]:
    """What a module exports: the ``__all__`` of a room, and of a file what is not private."""
    if hasattr(module, "__all__"):
        return list(module.__all__)
    return [name for name in vars(module) if not name.startswith("_")]


def subjects() -> Iterator[Subject]:
    """What the modules export, each where it is defined, and its public methods."""
    for name in LIBRARY:
        module = importlib.import_module(name)
        for public in public_names(module):
            value = getattr(module, public)
            if getattr(value, "__module__", None) != name:
                continue
            if inspect.isclass(value):
                yield Subject(f"{name}.{public}", value, None)
                yield from methods(f"{name}.{public}", value)
            elif inspect.isfunction(value):
                yield Subject(f"{name}.{public}", value, None)


def methods(label: str, owner: type) -> Iterator[Subject]:
    for name, member in list(vars(owner).items()):
        value = getattr(member, "__func__", member)  # of a class method
        if isinstance(value, property):
            value = value.fget
        value = getattr(value, "func", value)  # of a cached property
        if inspect.isfunction(value) and not name.startswith("_"):
            yield Subject(f"{label}.{name}", value, owner)


SUBJECTS = list(subjects())


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
    if issubclass(cls, BaseException):
        return "__init__" in vars(cls)
    foreign = (enum.Enum, dict, list, str)
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
        # A table of a record has the descriptions of its fields in the schema alone.
        shown = value.model_json_schema()["properties"]
        fields = value.model_fields.items()
        return all(is_described(field, shown[name]) for name, field in fields)
    if carries_help(value):
        return True
    if overrides(subject) or refers(value, wanted, doc):
        return True
    most = PLAIN_FIELDS if dataclasses.is_dataclass(value) else PLAIN_PARAMETERS
    return len(wanted) <= most and not sections(doc)


def is_described(field: Any, shown: Mapping[str, Any]) -> bool:
    """Whether a table's field has a description or holds tables or one fixed word."""
    if shown.get("description"):
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
        shown = inspect.signature(from_options(value)).parameters.values()
    except NameError:  # names for type checkers only: no command
        return False
    return bool(shown) and all(each.annotation.__metadata__[0].help for each in shown)


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


def without_a_docstring(subject: Subject) -> str | None:
    doc = subject.value.__doc__
    # What dataclass makes up from the fields is no docstring.
    if not doc or doc.startswith(f"{subject.value.__name__}("):
        return f"{subject.label} has no docstring of its own"
    sentence = doc.strip().splitlines()[0].rstrip()[-1] in ".:"
    return None if sentence else f"{subject.label}: the first line is no sentence"


def with_wrong_parameters(subject: Subject) -> str | None:
    wanted, doc = parameters(subject), subject.value.__doc__ or ""
    section = sections(doc).get("Parameters")
    if section is None:
        fine = not wanted or speaks_for_itself(subject, wanted, doc)
        return None if fine else f"{subject.label} needs Parameters: {', '.join(wanted)}"
    found = documented(section)
    return None if sorted(found) == sorted(wanted) else f"{subject.label}: {found}, not {wanted}"


def test_parameters_of_docstrings_are_those_of_the_signatures():
    wrong = (without_a_docstring, with_wrong_parameters)
    assert not [text for of in SUBJECTS for check in wrong if (text := check(of))]


def test_a_module_says_what_it_is():
    for name in LIBRARY:
        doc = importlib.import_module(name).__doc__
        assert doc, name
        assert doc.splitlines()[0].endswith("."), name
