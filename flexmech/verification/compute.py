"""Computing the cases of the verification one after the other."""

from __future__ import annotations

import platform
from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import versions
from flexmech.arrays import FloatArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.threads import one_thread
from flexmech.verification.cases import Outcome, VerificationCase, verification_cases
from flexmech.verification.result import Verification


def verify(
    cases: Sequence[VerificationCase] | None = None,
    *,
    thorough: bool = False,
    progress: LabelledProgress | None = None,
) -> Verification:
    """Compare what flexmech computes on this machine with numbers from elsewhere.

    Parameters
    ----------
    cases : sequence of VerificationCase, optional
        By default those of :func:`flexmech.verification.verification_cases`.
    thorough : bool
        With those that take longer, where ``cases`` is left out.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    Verification

    Raises
    ------
    InputError
        If there is no case, or two have one title.

    Examples
    --------
    >>> cases = [flexmech.verification.verification_case("Four-bars at rest: steel, 0 deg, exudyn")]
    >>> flexmech.verify(cases).dataset["verdict"].values
    array(['passed'], dtype='<U6')
    """
    chosen = verification_cases(thorough=thorough) if cases is None else tuple(cases)
    if not chosen:
        raise InputError("cases: there is none to verify")
    titles = [case.title for case in chosen]
    if len(set(titles)) < len(titles):
        raise InputError("cases: two have the same title; a case is known by its title")
    outcomes, report = [], progress or silent
    with one_thread():
        for done, case in enumerate(chosen, start=1):
            outcomes.append(case.outcome())
            report("cases", done, len(chosen))
    return Verification(_dataset(outcomes))


def _dataset(outcomes: Sequence[Outcome]) -> xr.Dataset:
    most = max(outcome.expected.size for outcome in outcomes)
    cases = [outcome.case for outcome in outcomes]

    def padded(values: FloatArray) -> FloatArray:
        return np.pad(values, (0, most - values.size), constant_values=np.nan)

    numbers = {
        name: (("case", "number"), np.stack([padded(getattr(each, name)) for each in outcomes]))
        for name in ("expected", "measured", "deviation")
    }
    texts = {
        name: ("case", np.array([getattr(case, name) for case in cases]))
        for name in ("subject", "source", "quantity", "unit", "deviation_kind")
    }
    labels = [
        [_label(case, number, outcome.expected.size) for number in range(most)]
        for case, outcome in zip(cases, outcomes, strict=True)
    ]
    dataset = xr.Dataset(
        {
            **numbers,
            **texts,
            "label": (("case", "number"), np.array(labels)),
            "tolerance": ("case", [case.tolerance for case in cases]),
            "verdict": ("case", np.array([outcome.verdict for outcome in outcomes])),
            "reason": ("case", np.array([outcome.reason for outcome in outcomes])),
        },
        {"case": np.array([case.title for case in cases]), "number": np.arange(1, most + 1)},
    )
    for name, (unit, words) in _VARIABLES.items():
        dataset[name].attrs = {"long_name": words} | ({"units": unit} if unit else {})
    machine = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    return dataset.assign_attrs(versions("exudyn") | {"machine": machine})


def _label(case: VerificationCase, number: int, count: int) -> str:
    """What a number of a case is called; empty where there is none, or one alone."""
    if number >= count:
        return ""
    if case.labels:
        return case.labels[number] if number < len(case.labels) else ""
    return str(number + 1) if count > 1 else ""


# Units and words; numbers are in the unit that their case names.
_VARIABLES = {
    "expected": ("", "expected number, in the unit of its case"),
    "measured": ("", "number that flexmech computed, in the unit of its case"),
    "deviation": ("", "size of the difference as the case counts it"),
    "subject": ("", "group of the case"),
    "source": ("", "where the expected numbers come from"),
    "quantity": ("", "what the numbers are"),
    "unit": ("", "unit of the numbers of the case"),
    "deviation_kind": ("", "what the difference is divided by"),
    "label": ("", "what a number belongs to"),
    "tolerance": ("", "largest deviation with which the case passes"),
    "verdict": ("", "passed, failed or skipped"),
    "reason": ("", "why nothing was compared"),
    "number": ("1", "number within the case"),
}
