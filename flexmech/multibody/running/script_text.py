"""Python source text of values and calls, wrapped as formatters do."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass
from types import MethodType
from typing import Any

import numpy as np

from flexmech.multibody.items import Choice, ItemNumber, Made
from flexmech.multibody.running.closure import (
    AngleGap,
    ClosedJoints,
    JoinedEnd,
    JointsClosedInTurn,
    LineGap,
    PlaceGap,
)
from flexmech.multibody.running.user_functions import (
    Shaft,
    constraint_force,
    difference_mass,
    guide_line_force,
    load_history,
    middle_deflection,
    section_couples,
    torque_history,
    turned_frame,
)

# In the order in which they need each other.
SHARED = (
    Shaft,
    JoinedEnd,
    PlaceGap,
    AngleGap,
    LineGap,
    JointsClosedInTurn,
    ClosedJoints,
    difference_mass,
    turned_frame,
    load_history,
    section_couples,
    torque_history,
    middle_deflection,
    constraint_force,
    guide_line_force,
)


# Columns of a script, as the usual formatter of Python leaves it.
WIDTH = 88
INDENT = "    "


@dataclass(frozen=True)
class Brackets:
    """Expressions between brackets, such as a list or the arguments of a call.

    Parameters
    ----------
    opening, closing : str
    parts : tuple of Expression
    prefix : str
        Before the opening bracket, such as ``"name="``.
    """

    opening: str
    parts: tuple[Expression, ...]
    closing: str
    prefix: str = ""

    @property
    def line(self) -> str:
        """All of it in one line."""
        inside = ", ".join(_line(part) for part in self.parts)
        comma = "," if self.opening == "(" and self.closing == ")" and self._is_single else ""
        return f"{self.prefix}{self.opening}{inside}{comma}{self.closing}"

    @property
    def _is_single(self) -> bool:
        return len(self.parts) == 1


Expression = str | Brackets


def _line(part: Expression) -> str:
    return part if isinstance(part, str) else part.line


def statement(lead: str, value: Expression, end: str = "", depth: int = 0) -> list[str]:
    """Lines of a statement: a lead such as ``"x = "``, an expression and what ends it.

    Parameters
    ----------
    lead : str
    value : Expression
    end : str
    depth : int
        How far it is indented.

    Returns
    -------
    list of str
    """
    whole = f"{INDENT * depth}{lead}{_line(value)}{end}"
    if len(whole) <= WIDTH or isinstance(value, str) or not value.parts:
        return [whole]
    lines = [f"{INDENT * depth}{lead}{value.prefix}{value.opening}"]
    for part in value.parts:
        lines += statement("", part, ",", depth + 1)
    return [*lines, f"{INDENT * depth}{value.closing}{end}"]


def call(function: str, *arguments: Expression) -> Brackets:
    """Call of a function."""
    return Brackets(f"{function}(", arguments, ")")


def pair(key: str, value: Expression) -> Expression:
    """Keyword argument."""
    if isinstance(value, str):
        return f"{key}={value}"
    return Brackets(value.opening, value.parts, value.closing, f"{key}={value.prefix}")


def expression(value: Any) -> Expression:
    """A value of an item as an expression; numbers of items by their names.

    Parameters
    ----------
    value : object
        Number, text, array, list, one of the values of :mod:`flexmech.multibody.items`, method
        or function that a script holds, or record whose class it holds.

    Returns
    -------
    Expression
    """
    if isinstance(value, Made):
        return call(value.function.__name__, *map(expression, value.arguments))
    if isinstance(value, ItemNumber):
        return f"{value.kind}s[{quoted(value.name)}]"
    if isinstance(value, Choice):
        return f"exu.{value.enumeration}.{value.name}"
    if isinstance(value, MethodType):
        return f"{type(value.__self__).__name__.lower()}.{value.__name__}"
    if isinstance(value, np.generic):
        return expression(value.item())
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, list):
        return Brackets("[", tuple(map(expression, value)), "]")
    if isinstance(value, tuple):
        return Brackets("(", tuple(map(expression, value)), ")")
    if is_dataclass(value):
        given = (pair(f.name, expression(getattr(value, f.name))) for f in fields(value))
        return call(type(value).__name__, *given)
    if callable(value):
        return str(value.__name__)
    return quoted(value) if isinstance(value, str) else repr(value)


def _array(value: np.ndarray) -> Expression:
    """Vectors as lists; matrices as arrays, by their diagonal where that is all."""
    if value.ndim == 1:
        return expression(value.tolist())
    diagonal = np.diag(value)
    if np.array_equal(value, np.diag(diagonal)):
        return call("np.diag", expression(diagonal.tolist()))
    return call("np.array", expression(value.tolist()))


def quoted(text: str) -> str:
    """Text in quotes: double ones, unless that needs more of them to be escaped."""
    return repr(text) if '"' in text else json.dumps(text, ensure_ascii=False)


def columns(rows: Sequence[Sequence[Expression]]) -> tuple[Expression, ...]:
    """Rows of a table as tuples; those of one column as they are."""
    return tuple(row[0] if len(row) == 1 else Brackets("(", tuple(row), ")") for row in rows)
