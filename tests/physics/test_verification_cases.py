"""The cases that ``flexmech verify`` computes, one test each."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.verification import VerificationCase, verification_case, verification_cases

# Parts of the titles of cases that take longer.
LONG = (
    "Running slider-crank",
    "first turn: from undeformed links, exudyn",
    "Flexible slider-crank of Simeon: state at 0.1 s by the test set's own model",
    "Sandwich four-bar at rest, elasticity computed here: zigzag beams, reference",
)
CASES = [
    pytest.param(
        case,
        id=case.title,
        marks=[pytest.mark.thorough] * (case.thorough or any(part in case.title for part in LONG)),
    )
    for case in verification_cases(thorough=True)
]


@pytest.mark.parametrize("case", CASES)
def test_case(case: VerificationCase) -> None:
    """Nothing is skipped here: the tests need every extra."""
    outcome = case.outcome()
    assert outcome.reason == ""
    assert np.all(outcome.deviation <= case.tolerance)
    assert outcome.verdict == "passed"


@pytest.mark.parametrize("frame", ["L clamped at both ends", "portal clamped at both feet"])
def test_still_frames_by_component_modes_are_those_of_all_coordinates(frame: str) -> None:
    case = verification_case(f"Still frames: {frame}, reference")
    found = case.measured_by.with_(reduced=True).values()
    np.testing.assert_allclose(found, case.expected_values(), rtol=1e-6)


def test_first_order_theory_errs_where_layers_shear_differently() -> None:
    """Khdeir & Reddy's [0/90/0] clamped beam of five thicknesses: 11 % low by Timoshenko."""
    title = "Cross-ply beams of five and ten thicknesses, third-order theory: [0/90/0]"
    case = verification_case(title)
    clamped, published = case.labels.index("L/h 5, clamped"), case.expected_values()
    third, first = (
        case.measured_by.with_(element=element).values()[clamped] / published[clamped] - 1
        for element in ("reddy", "timoshenko")
    )
    assert np.abs(third) < 1e-3
    assert -0.12 < first < -0.1
