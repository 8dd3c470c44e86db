"""The line that says how far printed numbers are known, and whether the engines agree."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flexmech.analyses.digits import percent

# Relative difference of engines below which nobody needs to act: materials and dimensions are known
# no better, and the numbers have no more digits than that leaves.
_LITTLE = 0.01


def worth_a_warning(apart: float, *, agree: bool) -> bool:
    """Whether two engines differ by more than their errors explain, and by much.

    Parameters
    ----------
    apart : float
        Greatest relative difference of what is printed; not a number where it cannot be told.
    agree : bool
        Whether the engines differ by no more than their errors together.

    Returns
    -------
    bool
    """
    return not agree and not apart <= _LITTLE


def trust_line(
    engines: Sequence[str], error: float, apart: float = math.nan, *, agree: bool = True
) -> str:
    """How far the numbers of an answer are known, in one line.

    Parameters
    ----------
    engines : sequence of str
        That ran.
    error : float
        Greatest relative error of what is printed; not a number where none is estimated.
    apart : float
        Greatest relative difference of two engines in what is printed.
    agree : bool
        Whether the engines differ by no more than their errors together.

    Returns
    -------
    str

    Examples
    --------
    >>> trust_line(["reference", "exudyn"], 2e-5, 1.9e-4)
    'numbers are known to 0.019 %; both engines agree'
    >>> trust_line(["reference", "exudyn"], 2e-5, 0.02, agree=False)
    'reference and exudyn differ by 2 %, more than their errors of 0.002 % explain'
    >>> trust_line(["reference"], 2e-5)
    'numbers are known to 0.002 %; the reference engine alone ran'
    """
    greatest = max(error, apart) if math.isfinite(apart) else error
    known = f"numbers are known to {percent(greatest)}"
    if len(engines) > 1 and not agree:
        what = f"differ by {percent(apart)}" if math.isfinite(apart) else "differ"
        said = f"{' and '.join(engines)} {what}, more than their errors of {percent(error)} explain"
        return said if worth_a_warning(apart, agree=agree) else f"{known}; {said}"
    if not math.isfinite(greatest):
        known = "errors of the numbers are not estimated"
    ran = "both engines agree" if len(engines) > 1 else f"the {engines[0]} engine alone ran"
    return f"{known}; {ran}"
