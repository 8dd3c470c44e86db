"""Bands of growth of small systems: Mathieu's equation (V5) and combination resonances (V11).

The numbers are cases of the verification; here they must come with another number of steps too.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.verification import VerificationCase, verification_case, verification_cases
from flexmech.verification.methods.periodic_systems import combination_modes, resonance_modulus

EDGES = [
    case
    for case in verification_cases()
    if case.measured_by.method in ("mathieu_boundaries", "combination_edges")
]


@pytest.mark.parametrize("case", [pytest.param(case, id=case.title) for case in EDGES])
def test_edges_of_bands_are_those_of_any_number_of_steps(case: VerificationCase) -> None:
    found = case.measured_by.with_(steps=97).values()
    assert found == pytest.approx(case.expected_values(), abs=case.tolerance)


@pytest.mark.parametrize("kind", ["sum", "difference"])
def test_coupled_oscillators_grow_between_the_edges_alone(kind: str) -> None:
    """Damped ones; undamped ones have quadruples of multipliers inside."""
    case = verification_case(f"Combination resonances of two oscillators: {kind}")
    lower, upper = case.expected_values()
    middle = (lower + upper) / 2

    def growth(drive: float) -> float:
        return float(combination_modes(kind, drive, 0.02, 128).exponent[0].real)  # type: ignore[arg-type]

    assert growth(middle) > 0.01
    assert max(growth(lower - 0.02), growth(upper + 0.02)) < 0
    log = np.sort(combination_modes(kind, middle, 0.0, 128).log_modulus)  # type: ignore[arg-type]
    assert log == pytest.approx(-log[::-1], abs=1e-12)
    assert log[-1] > 0.05


@pytest.mark.parametrize(("kind", "resonance"), [("sum", "difference"), ("difference", "sum")])
def test_a_coupling_has_no_band_of_the_other_kind(kind: str, resonance: str) -> None:
    modulus = resonance_modulus(kind=kind, resonance=resonance, steps=33)  # type: ignore[arg-type]
    assert modulus == pytest.approx([1.0], abs=1e-12)
