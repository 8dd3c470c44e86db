"""Commands that put one question to a mechanism: made from what can be asked of its analysis."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from flexmech import analyses
from flexmech.analyses.options import Options, declared_options
from flexmech.analyses.typed import Together, TypedSpeeds
from flexmech.cli import options
from flexmech.cli.deliver import Output, deliver, mechanism_of
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
    """The speeds of an option; where it is left out or has no value, those of the mechanism.

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
        return typed if typed and typed.numbers else own_speeds(mechanism, usual)


def given_speeds(
    asked: type[Options], keywords: dict[str, Any], mechanism: Mechanism
) -> tuple[dict[str, Any], Speeds | None]:
    """Keywords of a function, those that were left out and speeds that were put in their place.

    Parameters
    ----------
    asked : type
        What can be asked.
    keywords : dict of str to object
        As typed; None where an option was left out.
    mechanism : Mechanism
        Whose speeds are taken where none are typed.

    Returns
    -------
    dict of str to object
        Without those that were left out.
    Speeds or None
    """
    given, speeds = {name: value for name, value in keywords.items() if value is not None}, None
    for name, declared in declared_options(asked).items():
        mark, typed = declared.mark, given.get(name)
        if isinstance(mark, TypedSpeeds):
            typed = speeds_or_own(typed, mechanism, mark.option, mark.usual)
        if isinstance(typed, Speeds):
            speeds = typed
            given |= speeds.keywords(name)
    return given, speeds


@contextmanager
def naming_options(asked: type[Options]) -> Iterator[None]:
    """Give a message that begins with the names of keywords the names of their options instead.

    Parameters
    ----------
    asked : type
        What can be asked.
    """
    marks = {name: declared.mark for name, declared in declared_options(asked).items()}
    names = {name: m.option for name, m in marks.items() if not isinstance(m, Together)}
    try:
        yield
    except InputError as error:
        for pattern in (r"\w+(, \w+)*", r"\w+"):
            begin = re.match(pattern, error.message)
            words = begin[0].split(", ") if begin else []
            if begin and all(names.get(word) for word in words):
                options = ", ".join(names[word] for word in words)
                raise InputError(f"{options}{error.message[begin.end() :]}") from error
        raise


def ask(
    function: str,
    asked: type[Options],
    model: Any,
    keywords: dict[str, Any],
    output: Output,
    **delivery: Any,
) -> Any:
    """Ask a function of an analysis and deliver its result.

    What else :func:`flexmech.cli.deliver.deliver` takes is handed on.

    Parameters
    ----------
    function : str
        Room and name; what it says to return is the kind of the result.
    asked : type
        What can be asked.
    model : path-like
    keywords : dict of str to object
        Values of the function's keywords, as typed; None where an option was left out.
    output : Output

    Returns
    -------
    Result
    """
    mechanism = mechanism_of(model)
    given, speeds = given_speeds(asked, keywords, mechanism)
    room, _, name = function.partition(".")
    answer = getattr(import_module(f"flexmech.analyses.{room}.compute"), name)
    kind = getattr(analyses, answer.__annotations__["return"])

    def compute(progress: Any) -> Any:
        reported = {"progress": progress} if hasattr(asked, "progress") else {}
        with naming_options(asked):
            return answer(mechanism, **given, **reported)

    return deliver(kind, compute, output, model=model, speeds=speeds, **delivery)


def question(
    name: str,
    function: str,
    asked: type[Options],
    *,
    files: bool = True,
    prepare: Callable[[Path, dict[str, Any], Output], dict[str, Any]] | None = None,
    finish: Callable[[Any], None] | None = None,
    **defaults: Any,
) -> Callable[..., None]:
    """The command that asks a function of an analysis and delivers its result.

    Further keywords are defaults of the command, where they are not those of the function.

    Parameters
    ----------
    name, function : str
        Name of the command; room and name of the function.
    asked : type
        What can be asked; its docstring is what the help says.
    files : bool
        Whether files are written where no folder is named.
    prepare : callable, optional
        Takes model, keywords and output, may change keywords, and gives what else
        :func:`flexmech.cli.deliver.deliver` takes.
    finish : callable, optional
        Takes the result when it is delivered.

    Returns
    -------
    callable
    """

    def command(model: Any, keywords: dict[str, Any], output: Output) -> None:
        further = prepare(model, keywords, output) if prepare else {}
        result = ask(function, asked, model, keywords, output, **further)
        if finish:
            finish(result)

    command.__name__, command.__doc__ = name, asked.__doc__
    command.__annotations__ = {
        "model": options.Model,
        "keywords": Annotated[dict[str, Any], Together(asked, defaults)],
        "output": options.AskedOutput if files else options.AskedOptionalOutput,
    }
    return command
