"""The line that says how far printed numbers are known, and whether the engines agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.digits import percent
from flexmech.arrays import FloatArray

# Relative difference of engines below which nobody needs to act: materials and dimensions are known
# no better, and the numbers have no more digits than that leaves.
_LITTLE = 0.01


@dataclass(frozen=True)
class EngineDifference:
    """How far two engines differ in one number, and how much of it their errors explain.

    Parameters
    ----------
    apart : float
        Relative; not a number where one engine alone has the number.
    allowed : float
        Errors of both engines together, relative.
    of : str
        What differs, such as ``"peak driving torque"``; empty where all numbers are of a kind.
    """

    apart: float
    allowed: float
    of: str = ""

    @classmethod
    def least_explained(
        cls,
        apart: Sequence[float] | FloatArray,
        allowed: Sequence[float] | FloatArray,
        of: Sequence[str] = (),
    ) -> EngineDifference:
        """That of the number of many which errors explain least.

        Parameters
        ----------
        apart, allowed : array_like, shape (N,)
        of : sequence of str, optional
            N names.
        """
        place = least_explained(apart, allowed)
        return cls(float(apart[place]), float(allowed[place]), of[place] if of else "")

    @property
    def agree(self) -> bool:
        """Whether the engines differ by no more than their errors together."""
        return self.apart <= self.allowed

    @property
    def worth_a_warning(self) -> bool:
        """Whether they differ by more than their errors explain, and by much."""
        return not self.agree and not self.apart <= _LITTLE


def least_explained(
    apart: Sequence[float] | FloatArray, allowed: Sequence[float] | FloatArray
) -> int:
    """Which difference of two engines is farthest beyond their errors; the greatest if none is.

    Parameters
    ----------
    apart, allowed : array_like, shape (N,)
        Differences, and errors of both engines together; relative.

    Returns
    -------
    int

    Examples
    --------
    >>> least_explained([0.02, 4e-4], [0.1, 3e-4]), least_explained([0.02, 4e-4], [0.1, 5e-4])
    (1, 0)
    """
    apart = np.asarray(apart)
    beyond = apart - np.asarray(allowed)
    return int(np.argmax(beyond if (beyond > 0).any() else apart))


def trust_line(
    engines: Sequence[str], error: float, difference: EngineDifference | None = None
) -> str:
    """How far the numbers of an answer are known, in one line.

    Parameters
    ----------
    engines : sequence of str
        That ran.
    error : float
        Greatest relative error of what is printed; not a number where none is estimated.
    difference : EngineDifference, optional
        Of two engines, where errors explain it least. Left out: where one engine ran alone, or
        where the error holds the differences that errors explain.

    Returns
    -------
    str

    Examples
    --------
    >>> trust_line(["reference", "exudyn"], 2e-5, EngineDifference(1.9e-4, 2e-4))
    'numbers are known to 0.019 %; both engines agree'
    >>> trust_line(["reference", "exudyn"], 2e-5, EngineDifference(0.02, 3e-5))
    'reference and exudyn differ by 2 %, more than their errors of 0.003 % explain'
    >>> trust_line(["reference"], 2e-5)
    'numbers are known to 0.002 %; the reference engine alone ran'
    """
    apart = math.nan if difference is None else difference.apart
    greatest = max(error, apart) if math.isfinite(apart) else error
    known = f"numbers are known to {percent(greatest)}"
    if difference is not None and not difference.agree:
        said = f"{' and '.join(engines)} differ{_by(difference)}"
        return said if difference.worth_a_warning else f"{known}; {said}"
    if not math.isfinite(greatest):
        known = "errors of the numbers are not estimated"
    ran = "both engines agree" if len(engines) > 1 else f"the {engines[0]} engine alone ran"
    return f"{known}; {ran}"


def _by(difference: EngineDifference) -> str:
    if not math.isfinite(difference.apart):
        return " by more than their errors explain"
    apart, allowed = percent(difference.apart), percent(difference.allowed)
    where = f" in the {difference.of}" if difference.of else ""
    return f" by {apart}{where}, more than their errors of {allowed} explain"
