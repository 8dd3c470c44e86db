"""The cases that ``flexmech verify`` computes, one test each."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.verification import VerificationCase, verification_cases

# Parts of the titles of cases that take longer: their runs are tested by default elsewhere.
LONG = (
    *("Running slider-crank", "Flexible slider-crank", "Sandwich four-bar", "first turn"),
    *("portal clamped", "both ends, exudyn"),
)


def takes_long(case: VerificationCase) -> bool:
    return case.thorough or any(part in case.title for part in LONG)


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(
            case,
            id=case.title,
            marks=[pytest.mark.thorough]
            * (case.thorough or any(map(case.title.__contains__, LONG))),
        )
        for case in verification_cases(thorough=True)
    ],
)
def test_case(case: VerificationCase) -> None:
    """Nothing is skipped here: the tests need every extra."""
    outcome = case.outcome()
    assert outcome.reason == ""
    assert np.all(outcome.deviation <= case.tolerance)
    assert outcome.verdict == "passed"
