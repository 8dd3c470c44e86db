"""Commands that put one question to a mechanism: made from what can be asked of its analysis."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

from flexmech import analyses
from flexmech.analyses.options import Options
from flexmech.analyses.typed import Together, TypedSpeeds
from flexmech.cli import options
from flexmech.cli.deliver import Output, deliver, mechanism_of
from flexmech.cli.reading import options_of
from flexmech.crank_values import Speeds
from flexmech.errors import InputError, naming

if TYPE_CHECKING:
    from flexmech.arrays import FloatArray
    from flexmech.mechanism import Mechanism


def speeds_or_own(
    typed: Speeds | None,
    mechanism: Mechanism,
    option: str,
    usual: Callable[[Mechanism], FloatArray],
) -> Speeds:
    """The speeds of an option; where it is left out, those of the mechanism.

    Parameters
    ----------
    typed : Speeds or None
    mechanism : Mechanism
    option : str
    usual : callable
        Takes the mechanism, and gives the speeds in rad/s that are usual.

    Returns
    -------
    Speeds
        With a remark where they are the mechanism's.
    """
    from flexmech.analyses.crank_speeds import own_speeds

    with naming(option):
        return own_speeds(mechanism, usual) if typed is None else typed


@contextmanager
def naming_options(names: dict[str, str]) -> Iterator[None]:
    """Give a message that begins with the name of a keyword the name of its option instead.

    Parameters
    ----------
    names : dict of str to str
        Names of options by the keywords of a function.
    """
    try:
        yield
    except InputError as error:
        keyword, gap, text = re.split(r"(\W+|$)", error.message, maxsplit=1)
        if keyword not in names:
            raise
        raise InputError(f"{names[keyword]}{gap}{text}") from error


def question(
    function: str, result: str, asked: type[Options], **defaults: Any
) -> Callable[..., None]:
    """The command that asks a function of the package and delivers its result.

    Parameters
    ----------
    function, result : str
        Names of the function, which is that of its folder, and of the class of its result.
    asked : type
        What can be asked; its docstring is what the help says. Further keywords are defaults of
        the command where they are not those of the function.

    Returns
    -------
    callable
    """

    def command(model: Any, keywords: dict[str, Any], output: Output) -> None:
        mechanism, speeds, marks = mechanism_of(model), None, options_of(asked)
        names = {name: m.option for name, m in marks.items() if not isinstance(m, Together)}
        for name, mark in marks.items():
            if isinstance(mark, TypedSpeeds):
                speeds = speeds_or_own(keywords[name], mechanism, mark.option, mark.usual)
                keywords |= speeds.keywords(name)

        def compute(progress: Any) -> Any:
            told = {"progress": progress} if hasattr(asked, "progress") else {}
            with naming_options(names):
                room = import_module(f"flexmech.analyses.{function}.compute")
                return getattr(room, function)(mechanism, **keywords, **told)

        deliver(getattr(analyses, result), compute, output, model=model, speeds=speeds)

    command.__name__, command.__doc__ = function, asked.__doc__
    command.__annotations__ = {
        "model": options.Model,
        "keywords": Annotated[dict[str, Any], Together(asked, defaults)],
        "output": options.AskedOutput,
    }
    return command
