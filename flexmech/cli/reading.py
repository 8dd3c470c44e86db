"""From texts that users type to values of a command: options that read, and groups of them.

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
from dataclasses import MISSING, fields
from inspect import isclass
from typing import Annotated, Any, cast, get_args, get_type_hints

from typer import Argument, Option

from flexmech.analyses.options import declared_options
from flexmech.analyses.typed import OWN, Plain, Together, Typed
from flexmech.cli.deliver import typed_path
from flexmech.docstrings import entries

_HEADING = "Options\n-------\n"
_ANY_HEADING = r"(?m)^\w+\n-{3,}$"


ALONE = {
    "--rotation-terms": "all",
    "--no-rotation-terms": "--rotation-terms=none",
    "--running": OWN,
}
"""Values of options that stand alone: all terms or none, and the speed of the model file."""


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
    doc = inspect.cleandoc(command.__doc__ or "")
    of_command, of_library = entries(doc, _HEADING), entries(doc)
    shown: list[inspect.Parameter] = []
    readers: dict[str, tuple[list[str], Callable[..., Any]]] = {}
    for name, parameter in inspect.signature(command, eval_str=True).parameters.items():
        marks = getattr(parameter.annotation, "__metadata__", ())
        mark = next((m for m in marks if isinstance(m, Typed | Plain | Together)), None)
        if isinstance(mark, Together):
            make = from_options(_handed_on(mark) if isclass(mark.make) else mark.make)
            parameters = list(inspect.signature(make).parameters.values())
            shown += parameters
            readers[name] = [each.name for each in parameters], make
            continue
        kind = get_args(parameter.annotation)[0] if marks else parameter.annotation
        kind = getattr(mark, "kind", None) or kind
        option = next((copy(m) for m in marks if m is not mark), None) or _option(mark)
        if isinstance(mark, Typed):
            kind = str | None if parameter.default is None else str
            readers[name] = [name], mark
        if name in of_command:
            metavar, help_text = of_command[name]
            option.metavar, option.help = metavar or option.metavar, " ".join(help_text.split())
        elif name in of_library:
            option.help = " ".join(of_library[name][1].split())
        shown.append(parameter.replace(annotation=Annotated[kind, option]))

    @functools.wraps(command)
    def wrapped(**given: Any) -> Any:
        for name, (needed, make) in readers.items():
            values = {each: given.pop(each) for each in needed}
            given[name] = make(values[name]) if isinstance(make, Typed) else make(**values)
        return command(**given)

    shown = [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in shown]
    wrapped.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]
    wrapped.__annotations__ = {each.name: each.annotation for each in shown}
    wrapped.__doc__ = re.split(_ANY_HEADING, doc, maxsplit=1)[0].strip()
    return wrapped


def _option(mark: Typed | Plain | None) -> Any:
    """Typer's option for a mark."""
    if isinstance(mark, Plain):
        if not mark.option:
            return Argument(metavar=mark.metavar, parser=typed_path)
        return Option(mark.option, min=mark.least, max=mark.most, metavar=mark.metavar or None)
    if mark is None:
        return Option()
    names = filter(None, (mark.option, mark.also))
    return Option(*names, metavar=mark.metavar or None)


def _handed_on(together: Together) -> Callable[..., dict[str, Any]]:
    """A function whose parameters are the options among the fields of a class, and hands them on.

    Its docstring is that of the class with the first paragraphs of the entries, each with how its
    value is typed.
    """
    asked: Any = together.make
    hints, described = get_type_hints(asked, include_extras=True), entries(asked.__doc__ or "")
    known = {each.name: each for each in fields(asked)}
    shown, helps = [], []
    for name, declared in declared_options(asked).items():
        mark, factory = declared.mark, cast(Any, known[name].default_factory)
        default: Any = known[name].default if factory is MISSING else factory.args[0]
        default = together.defaults.get(name, default)
        default = inspect.Parameter.empty if default is MISSING else default
        if isinstance(mark, Typed) and isinstance(default, int | float):
            default = f"{default:g}"
        kind = inspect.Parameter.KEYWORD_ONLY
        shown.append(inspect.Parameter(name, kind, default=default, annotation=hints[name]))
        # Docstrings are absent where Python leaves them out (python -OO): the help is empty then.
        entry = described[name][1] if name in described else ""
        text = " ".join(entry.partition("\n\n")[0].replace("``", "").split())
        what, _, left_out = text.partition(". ")
        text = f"{what.removesuffix('.')}{getattr(mark, 'how', '') or '.'}"
        helps.append(f"{name}\n    {f'{text} {left_out}'.strip()}")

    def handed_on(**values: Any) -> dict[str, Any]:
        return values

    handed_on.__signature__ = inspect.Signature(shown)  # type: ignore[attr-defined]
    handed_on.__doc__ = _HEADING + "\n".join(helps)
    return handed_on
