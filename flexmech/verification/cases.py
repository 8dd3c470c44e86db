"""The cases of the verification, as the files of the package describe them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import resources
from typing import Any

from flexmech.errors import InputError, suggestion
from flexmech.verification.case import Computation, VerificationCase

# In the order in which they are told.
FILES = (
    "four_bars",
    "rotating_arm",
    "drawn_linkages",
    "running",
    "floquet",
    "engines",
    "composites",
    "coupler_curves",
    "transmission_angles",
    "moisture",
)
BOTH_ENGINES = ("reference", "exudyn")


@cache
def _all_cases() -> tuple[VerificationCase, ...]:
    folder = resources.files("flexmech.verification") / "data" / "cases"
    texts = (folder.joinpath(f"{name}.toml").read_text(encoding="utf-8") for name in FILES)
    return tuple(case for text in texts for case in _cases_of(tomllib.loads(text)))


def verification_cases(*, thorough: bool = False) -> tuple[VerificationCase, ...]:
    """Give the cases of the verification.

    Parameters
    ----------
    thorough : bool
        Whether to add those that take longer.

    Returns
    -------
    tuple of VerificationCase
    """
    return tuple(case for case in _all_cases() if thorough or not case.thorough)


def verification_case(title: str) -> VerificationCase:
    """Give the case of a title, be it thorough or not.

    Parameters
    ----------
    title : str
        Subject and name, as in ``"Four-bars at rest: steel, 0 deg, reference"``.

    Returns
    -------
    VerificationCase

    Raises
    ------
    InputError
        If there is none.
    """
    known = {case.title: case for case in _all_cases()}
    if title not in known:
        raise InputError(f"there is no case {title!r}; {suggestion(title, list(known))}")
    return known[title]


def _cases_of(document: Mapping[str, Any]) -> Iterator[VerificationCase]:
    """Cases of a file, in its order: each has what its group says, and its own besides."""
    for group in document["groups"]:
        shared = {key: value for key, value in group.items() if key != "cases"}
        for own in group["cases"]:
            yield from _by_engine(_merged(shared, own))


def _by_engine(table: Mapping[str, Any]) -> Iterator[VerificationCase]:
    """One case, or one for each engine where ``each_engine`` is set."""
    given = dict(table)
    if not given.pop("each_engine", False):
        yield _case(given)
        return
    for engine in BOTH_ENGINES:
        measured = {**given["measured_by"], "engine": engine}
        yield _case({**given, "name": f"{given['name']}, {engine}", "measured_by": measured})


def _case(table: Mapping[str, Any]) -> VerificationCase:
    given = dict(table)
    expected = given.pop("expected_by", None)
    if expected is not None:
        given["expected"] = _computation(expected)
    else:
        given["expected"] = tuple(given["expected"])
    for name in ("labels", "needs"):
        given[name] = tuple(given.get(name, ()))
    return VerificationCase(**{**given, "measured_by": _computation(given["measured_by"])})


def _computation(table: Mapping[str, Any]) -> Computation:
    settings = {key: value for key, value in table.items() if key != "method"}
    return Computation(table["method"], settings)


def _merged(shared: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """One table over another; tables within them likewise."""
    merged = {**shared, **own}
    for key in shared.keys() & own.keys():
        if isinstance(shared[key], Mapping):
            merged[key] = {**shared[key], **own[key]}
    return merged
