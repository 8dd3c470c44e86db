"""Validation V1: four-bars at rest; the numbers are those of the verification's cases."""

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ReferenceEngine, natural_frequencies
from flexmech.verification import verification_cases

AT_REST = [case for case in verification_cases() if case.subject == "Four-bars at rest"]


@pytest.mark.parametrize("case", AT_REST, ids=lambda case: case.name)
def test_eight_elements_a_link(case):
    coarse = replace(case, measured_by=case.measured_by.with_(elements=8), tolerance=3e-4)
    assert coarse.outcome().verdict == "passed"


def test_frequencies_stay_below_the_pinned_links(aluminium):
    """The lowest two modes lie below those of coupler and rocker held at their pins."""
    angles = np.radians(np.arange(0, 360, 15))
    frequency = natural_frequencies(ReferenceEngine(aluminium, 16, "euler"), angles, modes=2)
    assert np.all(frequency[:, 0] < 45.1223)
    assert np.all(frequency[:, 1] < 49.5220 * (1 + 2e-6))
