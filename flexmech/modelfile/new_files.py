"""Model files to start from: a template of a kind of linkage, with a name and with sizes."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from importlib import resources
from typing import NamedTuple

from flexmech import units
from flexmech.errors import InputError, one_line, suggestion
from flexmech.modelfile.read import mechanism_from_toml
from flexmech.units import Dimension, parse_quantity

KINDS = ("four-bar", "composite-four-bar", "rotating-arm", "slider-crank", "planar")
"""Kinds of linkages that a model file can describe."""


class Size(NamedTuple):
    """A size that is asked for.

    Parameters
    ----------
    key : str
        Dotted, in the file.
    words : str
        What it is.
    dimension : Dimension
    """

    key: str
    words: str
    dimension: Dimension


SIZES: Mapping[str, Mapping[str, Size]] = {
    "slider-crank": {
        "crank": Size("links.crank.length", "length of the crank", units.LENGTH),
        "rod": Size("links.rod.length", "length of the rod", units.LENGTH),
        "offset": Size("joints.B.offset", "offset of the slider's line", units.LENGTH),
        "mass": Size("joints.B.mass", "mass of the slider", units.MASS),
        "speed": Size("operation.crank_speeds", "crank speed", units.ANGULAR_SPEED),
    }
}
"""Sizes of each kind that has some, by the names of their options."""

_TABLE = re.compile(r"\[(?P<name>[^\[\]]+)\]")
_VALUE = re.compile(r'(?P<key>\w+) = (?P<value>"[^"]*"|\[[^\]]*\])(?P<rest>.*)')


def template(kind: str) -> str:
    """Give a commented model file that loads without change.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputError
        If the kind is unknown.
    """
    if kind not in KINDS:
        raise InputError(f"unknown kind of linkage {kind!r}; {suggestion(kind, list(KINDS))}")
    folder = resources.files("flexmech.modelfile") / "templates"
    return (folder / f"{kind}.toml").read_text(encoding="utf-8")


def new_file(
    kind: str,
    name: str,
    sizes: Mapping[str, str | None],
    ask: Callable[[str, str], str] | None = None,
) -> str:
    """Template of a kind of linkage with a name, and with sizes in place of its own.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`.
    name : str
        Name of the mechanism, which stands in titles.
    sizes : mapping of str to str or None
        Sizes of :data:`SIZES`, such as ``{"rod": "160 mm"}``; None where one is left out.
    ask : callable, optional
        Takes what a size is and the template's own, and gives the size that is left out; without
        it the template's stay.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputError
        If the kind is unknown or has no such size, a size is no quantity of its dimension, or the
        sizes make no linkage.
    """
    text, known = template(kind), SIZES.get(kind, {})
    # Of a folder that was named in place of a file nothing is left.
    values = {"name": json.dumps(one_line(name) or kind, ensure_ascii=False)}
    for option, given in sizes.items():
        if given is not None and option not in known:
            of = " and ".join(each for each, own in SIZES.items() if option in own)
            raise InputError(f"--{option} is a size of {of}, and not of {kind}; leave it out")
    for option, size in known.items():
        given = sizes.get(option)
        if given is not None:
            try:
                parse_quantity(given, size.dimension)
            except InputError as error:
                raise error.within(f"--{option}") from error
        elif ask is not None:
            given = _answered(ask, size, _stated(text)[size.key].strip('[]"'))
        else:
            continue
        quoted = json.dumps(given.strip(), ensure_ascii=False)
        values[size.key] = f"[{quoted}]" if size.dimension is units.ANGULAR_SPEED else quoted
    text = _filled(text, values)
    mechanism_from_toml(text, name)  # refuses sizes that do not go together
    return text


def _answered(ask: Callable[[str, str], str], size: Size, usual: str) -> str:
    """A size as it is answered, asked for again until it is a quantity."""
    words = size.words
    while True:
        given = ask(words, usual)
        try:
            parse_quantity(given, size.dimension)
        except InputError as error:
            words = f"{error}; {size.words}"
        else:
            return given


def _stated(text: str) -> dict[str, str]:
    """Values of a template by their dotted keys, as they are written."""
    values: dict[str, str] = {}
    _walk(text, lambda key, value: values.setdefault(key, value))
    return values


def _filled(text: str, values: Mapping[str, str]) -> str:
    """A template with other values; its comments stay where they stand."""
    return _walk(text, lambda key, value: values.get(key, value))


def _walk(text: str, change: Callable[[str, str], str]) -> str:
    table, lines = "", []
    for line in text.split("\n"):
        if match := _TABLE.match(line):
            table = f"{match['name']}."
        if match := _VALUE.match(line):
            written = f"{match['key']} = {change(table + match['key'], match['value'])}"
            # Comments stand in columns.
            blanks = len(match["rest"]) - len(match["rest"].lstrip())
            longer = len(written) - len(line) + len(match["rest"])
            rest = match["rest"].lstrip()
            line = f"{written}{' ' * max(1, blanks - longer)}{rest}" if rest else written
        lines.append(line)
    return "\n".join(lines)
