"""Validation V2: what speed does to four-bars; the numbers are those of the verification."""

import numpy as np
import pytest

from flexmech.verification import verification_case

NAME = "aluminium, 0 deg, 20 rad/s, reference"


def test_classical_form_misses_part_of_the_effect():
    """Aluminium at 20 rad/s: posture adds more than half of what tension does."""
    rest = verification_case("Four-bars at rest: aluminium, 0 deg, reference")
    axial = verification_case(f"Four-bars with axial forces alone: {NAME}")
    whole = verification_case(f"Four-bars at equilibrium under their inertia forces: {NAME}")
    expected, measured = (
        np.array([values(case)[0] for case in (rest, axial, whole)])
        for values in (
            lambda case: case.expected_values(),
            lambda case: case.measured_by.values(),
        )
    )
    parts = [(row[1] - row[0]) / (row[2] - row[0]) for row in (measured, expected)]
    assert parts[0] == pytest.approx(parts[1], abs=2e-3)
    assert 1 - parts[0] > parts[0] / 2
