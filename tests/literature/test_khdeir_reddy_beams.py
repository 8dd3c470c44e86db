"""Free vibration of cross-ply beams, Khdeir & Reddy 1994, beyond the cases of the verification."""

from __future__ import annotations

import numpy as np

from flexmech.verification import verification_case

CASE = verification_case(
    "Cross-ply beams of five and ten thicknesses, third-order theory: [0/90/0]"
)


def test_first_order_theory_errs_where_the_layers_shear_differently() -> None:
    """With the stack's own shear correction it is 11 % low between clamps."""
    published = CASE.expected_values()
    clamped = CASE.labels.index("L/h 5, clamped")
    third, first = (
        CASE.measured_by.with_(element=element).values()[clamped] / published[clamped] - 1
        for element in ("reddy", "timoshenko")
    )
    assert np.abs(third) < 1e-3
    assert first < -0.1
