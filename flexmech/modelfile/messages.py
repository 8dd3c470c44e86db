"""From what pydantic found wrong to one message: file, dotted key, what was got, remedy."""

from __future__ import annotations

import reprlib
import typing
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from flexmech.errors import InputError, is_plain, one_line, suggestion
from flexmech.modelfile.document import ModelFile
from flexmech.si import QuantityField

# Most errors of a file in a message, as many as a screen shows, and letters of each, five lines.
MOST_TOLD = 10
MOST_CHARACTERS = 400

_WANTED_TYPES = {
    "bool_type": "true or false, without quotes",
    "string_type": "text in quotes",
    "string_too_short": "text that is not empty",
    "string_pattern_mismatch": "text that is not empty",
    "int_type": "a whole number",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "list_type": "a list in square brackets",
    "tuple_type": "a list in square brackets",
}


class Findings:
    """All that is wrong in a file, so that it is told at once.

    Parameters
    ----------
    file : str
        What messages call it.
    """

    def __init__(self, file: str) -> None:
        self.file = file
        self.found: list[str] = []
        self._kinds: list[type[InputError]] = []

    def none_at(self, key: str, check: Callable[[], None]) -> bool:
        """Whether a check finds nothing; what it finds is kept under a dotted key."""
        before = len(self.found)
        with self.at(key):
            check()
        return len(self.found) == before

    @contextmanager
    def at(self, key: str) -> Iterator[None]:
        """Keep an :class:`InputError` of the block under a dotted key; the block ends there."""
        try:
            yield
        except InputError as error:
            self.found.append(f"{key}: {error.message}")
            self._kinds.append(type(error))

    def refuse(self) -> None:
        """Raise what was found, if anything was: links that do not meet alone stay that error."""
        if not self.found:
            return
        error, kinds = together(self.file, self.found), set(self._kinds)
        if len(self._kinds) == len(self.found) and len(kinds) == 1:
            raise kinds.pop()(error.message)
        raise error


def known_name(table: str, got: str, known: Collection[str]) -> None:
    """Refuse a name that no table has.

    Parameters
    ----------
    table : str
        Name of the table of tables, such as ``materials``.
    got : str
    known : collection of str
        Names that there are.

    Raises
    ------
    InputError
        Names the nearest one.
    """
    if got not in known:
        remedy = suggestion(got, list(known)) if known else "add it"
        raise InputError(f"there is no table [{table}.{got}]; {remedy}")


def refuse_unseen_characters(data: Mapping[str, Any], file: str) -> None:
    """Refuse keys and texts with characters that would move a terminal's cursor.

    Parameters
    ----------
    data : mapping
        The file's content as parsed from TOML.
    file : str
        The file's name for the message.

    Raises
    ------
    InputError
        Names all keys.
    """
    findings = [
        f"{key}: holds a control character, {one_line(text, 60)!r}; write plain text"
        for key, text in _texts(data, "")
        if not is_plain(text)
    ]
    if findings:
        raise together(file, findings)


def _texts(value: Any, key: str) -> Iterator[tuple[str, str]]:
    """Every key and every text of a file, with its dotted key."""
    if isinstance(value, Mapping):
        for name, below in value.items():
            place = f"{key}.{name}".removeprefix(".")
            yield place, name.replace("\n", "\x00").replace("\t", "\x00")
            yield from _texts(below, place)
    elif isinstance(value, list):
        for number, below in enumerate(value):
            yield from _texts(below, f"{key}[{number}]")
    elif isinstance(value, str):
        # A name stands in titles, in one line; notes may have several.
        yield key, value.replace("\n", "\x00") if key.split(".")[-1] == "name" else value


def input_error(error: ValidationError, data: Mapping[str, Any], file: str) -> InputError:
    """Turn the findings of pydantic into one :class:`InputError`.

    Parameters
    ----------
    error : ValidationError
    data : mapping
        The file's content as parsed from TOML.
    file : str
        The file's name for the message.

    Returns
    -------
    InputError
    """
    findings = []
    for finding in error.errors(include_url=False):
        key = _dotted_key(finding, data)
        findings.append(f"{key + ': ' if key else ''}{_text(finding)}")
    return together(file, findings)


def together(file: str, findings: Sequence[str]) -> InputError:
    """One error of all that is wrong in a file.

    Parameters
    ----------
    file : str
    findings : sequence of str
        One or more, each with its key.

    Returns
    -------
    InputError
        Those beyond the first ten are counted.
    """
    messages = [one_line(finding, MOST_CHARACTERS) for finding in dict.fromkeys(findings)]
    if len(messages) == 1:
        return InputError(f"{file}: {messages[0]}")
    listed = " | ".join(messages[:MOST_TOLD])
    more = f" | and {len(messages) - MOST_TOLD} more" if len(messages) > MOST_TOLD else ""
    return InputError(f"{file}: {len(messages)} errors: {listed}{more}")


def _dotted_key(finding: ErrorDetails, data: Mapping[str, Any]) -> str:
    """Key as written in the file; pydantic also puts the tags of unions into its path."""
    key = ""
    place: Any = data
    tagged = False
    for step in finding["loc"]:
        if isinstance(step, int):
            key += f"[{step}]"
            place = place[step] if isinstance(place, list) and step < len(place) else None
        elif not tagged and isinstance(place, Mapping) and step in _tags(place):
            tagged = True  # such as "laminate" of section = "laminate", which is a key as well
        elif isinstance(place, Mapping) and step in place:
            tagged = False
            key += f".{step}"
            place = place[step]
        elif finding["type"] == "missing" and step == finding["loc"][-1]:
            key += f".{step}"
    if finding["type"] in ("union_tag_not_found", "union_tag_invalid"):
        key += f".{_tag_name(finding)}"
    elif finding["type"] == "unknown_key":
        key += f".{finding['ctx']['key']}"
    return key.removeprefix(".")


def _tags(table: Mapping[str, Any]) -> list[Any]:
    return [table.get(name) for name in ("kind", "section", "type")]


def _tag_name(finding: ErrorDetails) -> str:
    return str(finding["ctx"]["discriminator"]).strip("'")


def _text(finding: ErrorDetails) -> str:
    kind = finding["type"]
    context = finding.get("ctx", {})
    got = finding["input"]
    if kind == "value_error":
        return str(context["error"])
    if kind == "missing":
        last = finding["loc"][-1]
        # Of a list, whose length the format prescribes, an entry is missing.
        if not isinstance(last, str):
            return "is missing; give one more value"
        return _missing(last, finding["loc"])
    if kind == "union_tag_not_found":
        return _missing(_tag_name(finding), finding["loc"])
    if kind in ("union_tag_invalid", "literal_error"):
        return _not_a_choice(finding)
    if kind == "too_long":
        return f"got {len(got)} values; give {context['max_length']}"
    if kind == "greater_than_equal":
        return f"got {got!r}; give {context['ge']} or more"
    if kind in _WANTED_TYPES:
        return f"got {reprlib.repr(got)}; write {_WANTED_TYPES[kind]}"
    return f"{finding['msg']}"


def _not_a_choice(finding: ErrorDetails) -> str:
    context = finding["ctx"]
    got = str(context["tag"] if "tag" in context else finding["input"])
    listed = str(context.get("expected_tags", context.get("expected", "")))
    known = [word.strip(" '") for word in listed.replace(" or ", ",").split(",")]
    return f"got {got!r}; {suggestion(got, known)}"


def _missing(name: str, place: Collection[int | str]) -> str:
    if name in ("linkage", "links"):
        return f"is missing; add a table [{name}]"
    example = _examples(place).get(name)
    remedy = f"add it, for example {name} = {example}" if example else "add it"
    return f"is missing; {remedy}"


def _examples(place: Collection[int | str]) -> dict[str, str]:
    """Collect an example for each key of the format, by its name, as at a place of the file."""
    examples = {
        "kind": '"four-bar", "rotating-arm" or "planar"',
        "section": '"rectangle", "laminate" or "general"',
        "material": '"steel"',
        "type": '"constituents", "orthotropic" or "isotropic"',
        "points": '["A", "B"]',
        "ground": '["O2", "O4"]',
        "fibre": '"carbon"',
        "matrix": '"polyester"',
        "laminate": '"hybrid"',
        "stacking": '"[C/G/C]"',
    }
    for table in _tables(ModelFile):
        if "linkage" in place and _is_of_another_linkage(table, place):
            continue
        for name, field in table.model_fields.items():
            for mark in field.metadata:
                if isinstance(mark, QuantityField):
                    examples[name] = mark.dimension.example
    return examples


def _is_of_another_linkage(table: type[BaseModel], place: Collection[int | str]) -> bool:
    """Whether a table is one of a kind of linkage that is not at a place of the file."""
    kind = table.model_fields.get("kind")
    kinds = () if kind is None else typing.get_args(kind.annotation)
    return bool(kinds) and not any(own in place for own in kinds)


def _tables(annotation: Any) -> Iterator[type[BaseModel]]:
    """All tables in an annotation, and in theirs."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
        for field in annotation.model_fields.values():
            yield from _tables(field.annotation)
    for argument in typing.get_args(annotation):
        yield from _tables(argument)
