"""Derivatives of natural frequencies against closed forms and against central differences."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    InputError,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    frequency_derivatives,
    natural_frequencies,
)
from flexmech.modelfile import mechanism_with
from tests.support.mechanisms import model

THICKNESS, LENGTH = "links.coupler.in_plane_thickness", "linkage.coupler"


def engine_of(mechanism: Mechanism) -> ReferenceEngine:
    return ReferenceEngine(mechanism, 4, "euler", component_modes=False)


def differences(
    mechanism: Mechanism, key: str, value: float, angles: Any, speed: float, **options: Any
) -> Any:
    """Central differences of frequencies, extrapolated from two steps (Richardson)."""

    def at(factor: float) -> Any:
        changed = mechanism_with(mechanism, key, factor * value)
        return natural_frequencies(engine_of(changed), angles, speed, modes=3, **options)

    coarse, fine = ((at(1 + h) - at(1 - h)) / (2 * h * value) for h in (4e-4, 2e-4))
    return (4 * fine - coarse) / 3


@pytest.mark.parametrize(
    ("prestress", "speed", "key", "value"),
    [
        ("none", 0.0, THICKNESS, 1.6e-3),
        ("none", 20.0, LENGTH, 0.2794),
        ("axial", 20.0, THICKNESS, 1.6e-3),
        ("equilibrium", 20.0, LENGTH, 0.2794),
    ],
)
def test_derivatives_are_what_central_differences_tend_to(
    aluminium: Mechanism, prestress: Any, speed: float, key: str, value: float
) -> None:
    mechanism = mechanism_with(aluminium, THICKNESS, 1.6e-3)
    angles, options = np.radians([10.0, 130.0]), {"prestress": prestress}
    (found,) = frequency_derivatives(engine_of(mechanism), [key], angles, speed, modes=3, **options)
    expected = differences(mechanism, key, value, angles, speed, **options)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_slopes_change_places_through_a_veering(aluminium: Mechanism) -> None:
    """Where two frequencies come near and part again."""
    slopes = []
    for value in (1.6e-3, 2.4e-3, 3.2e-3):
        changed = mechanism_with(aluminium, THICKNESS, value)
        (found,) = frequency_derivatives(
            engine_of(changed), [THICKNESS], 0.3, modes=3, prestress="none"
        )
        expected = differences(changed, THICKNESS, value, 0.3, 0.0, prestress="none")
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
        slopes.append(found)
    assert slopes[0][0] > slopes[0][1]
    assert slopes[-1][0] < slopes[-1][1]


def test_a_bar_vibrates_in_proportion_to_its_thickness() -> None:
    """f of a slender clamped arm: proportional to h, to the root of E, to 1 / L^2."""
    section = BeamSection.rectangle(Material(70e9, 2700.0), 2e-3, 20e-3)
    engine = engine_of(Mechanism(RotatingArm(0.3), {"arm": section}))
    frequency = natural_frequencies(engine, 0.0, modes=2, prestress="none")
    keys = ("links.arm.in_plane_thickness", "materials.material.youngs_modulus", "linkage.length")
    found = frequency_derivatives(engine, keys, 0.0, modes=2, prestress="none")
    for slope, value, power in zip(found, (2e-3, 70e9, 0.3), (1.0, 0.5, -2.0), strict=True):
        # Rotary inertia of the sections is what is left: (h / L)^2.
        assert value * slope / frequency == pytest.approx(power, rel=2e-3)


def test_derivatives_by_what_is_not_stated_are_refused(aluminium: Mechanism) -> None:
    engine = engine_of(aluminium)
    with pytest.raises(InputError, match=r"linkage\.coupler"):
        frequency_derivatives(engine, ["linkage.copler"], 0.0)
    with pytest.raises(InputError, match="moisture is zero here"):
        frequency_derivatives(engine, ["moisture"], 0.0)
    rigid = engine_of(model("turcic_midha_bosnik_fourbar"))
    with pytest.raises(InputError, match="shear_stiffness is infinite here"):
        frequency_derivatives(rigid, ["links.coupler.shear_stiffness"], 0.0)
