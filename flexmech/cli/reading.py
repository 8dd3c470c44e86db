"""From texts that users type to what a command takes: options that read, and groups of them.

An annotation of a command's parameter says how: ``Annotated[float, STEP]`` is an option whose text
``STEP`` reads, ``Annotated[Output, Together(output)]`` stands for all options that are the
parameters of ``output``, which makes one value of them. What the help says of an option that no
other command has stands in the docstring, below "Options", as parameters do: its name, what stands
for its value, and its text.
"""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from typing import Annotated, Any, get_args

from typer import Option

from flexmech.cli.failures import naming

_HEADING = "Options\n-------\n"
_ENTRY = re.compile(r"^(\w+)(?: : (.+))?\n((?:    .+(?:\n|$))+)", re.MULTILINE)


OWN = "model"
ALONE = {
    "--rotation-terms": "all",
    "--no-rotation-terms": "--rotation-terms=none",
    "--running": OWN,
}
"""What options are without a value: all terms or none, and the speed of the model file."""


@dataclass(frozen=True)
class Typed:
    """An option's own way to read its text.

    Parameters
    ----------
    option : str
        Which messages name.
    read : callable
        Takes the text; raises InputError where it cannot be read.
    """

    option: str
    read: Callable[[str], Any]

    def __call__(self, text: str | None) -> Any:
        """What the text says; None where the option was left out."""
        if text is None:
            return None
        with naming(self.option):
            return self.read(text)


@dataclass(frozen=True)
class Together:
    """Options of which one value is made: the parameters of a function that makes it."""

    make: Callable[..., Any]


def with_value(this: str, following: str) -> str:
    """An argument of a command line: an option of :data:`ALONE` without its value gets one.

    It has none where another option follows, or a file, if that does not begin with a number.
    """
    if this.startswith("--no-"):
        return ALONE.get(this, this)
    bare = re.search(r"^-(?![.0-9])|^(?![-+]?\.?[0-9]).*[./\\]", following)
    return f"{this}={ALONE[this]}" if bare and this in ALONE else this


def from_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The same command as typer takes it: with an option of plain text for all that is read."""
    words, _, section = inspect.cleandoc(command.__doc__ or "").partition(_HEADING)
    told = {name: (metavar or None, text) for name, metavar, text in _ENTRY.findall(section)}
    shown: list[inspect.Parameter] = []
    readers: dict[str, tuple[list[str], Callable[..., Any]]] = {}
    for name, parameter in inspect.signature(command, eval_str=True).parameters.items():
        marks = getattr(parameter.annotation, "__metadata__", ())
        kind = get_args(parameter.annotation)[0] if marks else parameter.annotation
        option = next((copy(m) for m in marks if not isinstance(m, Typed | Together)), Option())
        if name in told:
            option.metavar, option.help = told[name][0], " ".join(told[name][1].split())
        own: list[inspect.Parameter] = []
        for mark in marks:
            if isinstance(mark, Together):
                make = from_options(mark.make)
                own = list(inspect.signature(make).parameters.values())
                readers[name] = [each.name for each in own], make
            elif isinstance(mark, Typed):
                kind = str | None if parameter.default is None else str
                readers[name] = [name], mark
        shown += own or [parameter.replace(annotation=Annotated[kind, option])]

    @functools.wraps(command)
    def wrapped(**given: Any) -> Any:
        for name, (needed, make) in readers.items():
            values = {each: given.pop(each) for each in needed}
            given[name] = make(values[name]) if isinstance(make, Typed) else make(**values)
        return command(**given)

    shown = [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in shown]
    wrapped.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {each.name: each.annotation for each in shown}
    wrapped.__doc__ = words.strip()
    return wrapped
