"""Bands of growth of small systems: Mathieu's equation (V5) and combination resonances (V11).

The numbers are cases of the verification; here they must come with other steps too.
"""

import numpy as np
import pytest

from flexmech.verification import verification_case, verification_cases
from flexmech.verification.methods.periodic_systems import combination_modes, resonance_modulus

EDGES = [
    case
    for case in verification_cases()
    if case.measured_by.method in ("mathieu_boundaries", "combination_edges")
]


@pytest.mark.parametrize("case", [pytest.param(case, id=case.title) for case in EDGES])
@pytest.mark.parametrize("steps", [96, 129])
def test_edges_are_those_of_any_number_of_steps(case, steps):
    found = case.measured_by.with_(steps=steps).values()
    assert found == pytest.approx(case.expected_values(), abs=case.tolerance)


@pytest.mark.parametrize("kind", ["sum", "difference"])
def test_damped_oscillators_grow_between_the_edges_alone(kind):
    lower, upper = verification_case(
        f"Combination resonances of two oscillators: {kind}"
    ).expected_values()

    def growth(drive):
        return float(combination_modes(kind, drive, 0.02, 128).exponent[0].real)

    assert growth((lower + upper) / 2) > 0.01
    assert max(growth(lower - 0.02), growth(upper + 0.02)) < 0


@pytest.mark.parametrize(("kind", "resonance"), [("sum", "difference"), ("difference", "sum")])
@pytest.mark.parametrize("steps", [32, 255])
def test_no_band_where_there_is_none(kind, resonance, steps):
    modulus = resonance_modulus(kind=kind, resonance=resonance, steps=steps)
    assert modulus == pytest.approx([1.0], abs=1e-12)


@pytest.mark.parametrize("kind", ["sum", "difference"])
def test_multipliers_inside_a_band_are_quadruples(kind):
    edges = verification_case(f"Combination resonances of two oscillators: {kind}")
    modes = combination_modes(kind, float(edges.expected_values().mean()), 0.0, 128)
    log = np.sort(modes.log_modulus)
    assert log == pytest.approx(-log[::-1], abs=1e-12)
    assert log[-1] > 0.05
    assert modes.liouville_defect < 1e-12
