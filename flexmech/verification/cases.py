"""The cases of the verification, as the files of the package describe them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import FlexmechError, InputError, suggestion
from flexmech.verification.methods import METHODS

Verdict = Literal["passed", "failed", "skipped"]
DeviationKind = Literal["relative", "relative to the largest", "absolute"]
"""Divisor of a difference: the expected number, the largest expected one, or none."""

# Packages of extras by the names that Python imports them by.
_EXTRAS = {"skfem": "scikit-fem, of the extra 'verify'"}


@dataclass(frozen=True)
class Computation:
    """A method with its settings.

    Parameters
    ----------
    method : str
        Name in :data:`flexmech.verification.methods.METHODS`.
    settings : mapping of str to object
        Keyword arguments of the method.
    """

    method: str
    settings: Mapping[str, Any] = field(default_factory=dict)

    def with_(self, **settings: object) -> Computation:
        """Give the same method with some settings changed."""
        return replace(self, settings={**self.settings, **settings})

    def values(self) -> FloatArray:
        """Compute: all numbers in one row."""
        return np.ravel(np.asarray(METHODS[self.method](**self.settings), dtype=float))


@dataclass(frozen=True)
class VerificationCase:
    """Numbers that flexmech computes, and what they must be.

    Parameters
    ----------
    subject : str
        Name of the group of cases that it belongs to.
    name : str
        Within its group.
    source : str
        Where the expected numbers come from: publication with table or equation, program with its
        version, or closed form.
    quantity : str
        What the numbers are.
    unit : str
        Theirs; empty where they have none.
    labels : tuple of str
        What each number belongs to; without labels they are counted.
    expected : tuple of float or Computation
        Stored numbers, or what computes them.
    measured_by : Computation
        What computes the numbers under test.
    tolerance : float
        Largest deviation with which the case passes.
    deviation_kind : {"relative", "relative to the largest", "absolute"}
        An absolute one is in ``unit``.
    thorough : bool
        Whether it takes too long for the short form.
    needs : tuple of str
        Packages of extras that it imports; without them it is skipped.
    """

    subject: str
    name: str
    source: str
    quantity: str
    unit: str
    expected: tuple[float, ...] | Computation
    measured_by: Computation
    tolerance: float
    labels: tuple[str, ...] = ()
    deviation_kind: DeviationKind = "relative"
    thorough: bool = False
    needs: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """Subject and name."""
        return f"{self.subject}: {self.name}"

    @property
    def lacking(self) -> tuple[str, ...]:
        """Packages that it needs and that are not installed."""
        return tuple(name for name in self.needs if find_spec(name) is None)

    def expected_values(self) -> FloatArray:
        """Numbers that are expected, computed where they are not stored."""
        if isinstance(self.expected, Computation):
            return self.expected.values()
        return np.array(self.expected, dtype=float)

    def outcome(self) -> Outcome:
        """Compute the case.

        Returns
        -------
        Outcome
            Numbers with their errors; without a number, and with the reason, where the computation
            fails.
        """
        nothing = np.full(1, np.nan)
        if self.lacking:
            lacking = ", ".join(_EXTRAS.get(name, name) for name in self.lacking)
            return Outcome(self, nothing, nothing, f"not installed: {lacking}")
        try:
            expected = self.expected_values()
            measured = self.measured_by.values()
        except (FlexmechError, ArithmeticError, np.linalg.LinAlgError) as error:
            return Outcome(self, nothing, nothing, f"cannot be computed: {error}")
        if expected.shape != measured.shape:
            counts = f"{measured.size} numbers were computed where {expected.size} are expected"
            return Outcome(self, nothing, nothing, counts)
        return Outcome(self, expected, measured)


@dataclass(frozen=True, eq=False)
class Outcome:
    """Outcome of a case.

    Parameters
    ----------
    case : VerificationCase
    expected, measured : ndarray, shape (n,)
        One that is not a number where nothing could be compared.
    reason : str
        Why nothing was compared; else empty.
    """

    case: VerificationCase
    expected: FloatArray
    measured: FloatArray
    reason: str = ""

    @property
    def deviation(self) -> FloatArray:
        """Size of the difference as the case counts it; shape (n,)."""
        scale: FloatArray | float = 1.0
        if self.case.deviation_kind == "relative":
            scale = np.abs(self.expected)
        elif self.case.deviation_kind == "relative to the largest":
            scale = float(np.abs(self.expected).max())
        return np.asarray(np.abs(self.measured - self.expected) / scale)

    @property
    def within(self) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether each number is near enough; one that is not a number never is."""
        return np.asarray(self.deviation <= self.case.tolerance)

    @property
    def verdict(self) -> Verdict:
        """Skipped where a package is lacking; failed where one number is not near enough."""
        if self.case.lacking:
            return "skipped"
        return "passed" if bool(self.within.all()) else "failed"


# In the order in which they are printed.
_FILES = (
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
_BOTH_ENGINES = ("reference", "exudyn")


@cache
def _all_cases() -> tuple[VerificationCase, ...]:
    folder = resources.files("flexmech.verification") / "data" / "cases"
    texts = (folder.joinpath(f"{name}.toml").read_text(encoding="utf-8") for name in _FILES)
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
    for engine in _BOTH_ENGINES:
        measured = {**given["measured_by"], "engine": engine}
        yield _case({**given, "name": f"{given['name']}, {engine}", "measured_by": measured})


def _case(table: Mapping[str, Any]) -> VerificationCase:
    lists = {key: tuple(own) for key, own in table.items() if isinstance(own, list)}
    given: dict[str, Any] = {**table, **lists, "measured_by": _computation(table["measured_by"])}
    if "expected_by" in given:
        given["expected"] = _computation(given.pop("expected_by"))
    return VerificationCase(**given)


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
