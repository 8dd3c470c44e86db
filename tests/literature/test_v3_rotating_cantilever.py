"""Validation V3: rotating cantilever; Hamza-Cherif & Houmat, ICAS 2004, Table 2, and
Wright et al. 1982 (flap, hub radius). Speeds and frequencies over sqrt(EI / rhoA L^4)."""

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, natural_frequencies

SPEED = np.array([2, 4, 6, 8, 10, 50.0])
FLAP = np.array([4.1373, 5.5850, 7.3603, 9.2568, 11.2023, 51.0805])
CHORD = np.array([3.6195, 3.888, 4.2393, 4.6105, 4.97, 7.3362])
TOLERANCE = np.array([2e-4, 2e-4, 2e-4, 2e-4, 2e-4, 5e-4])
WRIGHT = [
    3.51602, 3.68165, 4.13732, 4.79728, 5.58500, 6.44954, 7.36037, 8.29964, 9.25684, 10.22569,
    11.20233, 12.18434, 13.17015,
]  # fmt: skip


def first(engine, speeds, prestress, rotation_terms):
    frequency = natural_frequencies(
        engine, 0.0, speeds, modes=1, prestress=prestress, rotation_terms=rotation_terms
    )
    return 2 * np.pi * frequency[..., 0]


@pytest.mark.parametrize("component_modes", [True, False])
def test_flap_is_prestress_without_rotation_terms(unit_arm, component_modes):
    engine = ReferenceEngine(unit_arm(70), 32, component_modes=component_modes)
    slow = SPEED <= 10 if component_modes else SPEED > 0
    computed = first(engine, SPEED[slow], "axial", False)
    np.testing.assert_array_less(np.abs(computed / FLAP[slow] - 1), TOLERANCE[slow])


def test_chord_has_coriolis_and_centripetal_terms(unit_arm):
    engine = ReferenceEngine(unit_arm(70), 32, component_modes=False)
    computed = first(engine, SPEED, "axial", True)
    np.testing.assert_array_less(np.abs(computed / CHORD - 1), TOLERANCE)


def test_flap_without_hub(unit_arm):
    computed = first(ReferenceEngine(unit_arm(70), 16), np.arange(13.0), "axial", False)
    np.testing.assert_allclose(computed, WRIGHT, rtol=5e-5)


@pytest.mark.parametrize(("speed", "flap"), [(2.0, 4.83369), (10.0, 16.60636)])
def test_flap_with_a_hub_as_large_as_the_arm(unit_arm, speed, flap):
    computed = first(ReferenceEngine(unit_arm(70, 1.0), 16), speed, "axial", False)
    assert computed == pytest.approx(flap, rel=5e-5)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_slender_limit_of_the_geometrically_exact_equilibrium(unit_arm, engine):
    slow = SPEED <= 10
    arm = engine(unit_arm(1000), 24, component_modes=False)
    flap = first(arm, SPEED[slow], "equilibrium", False)
    np.testing.assert_allclose(flap, FLAP[slow], rtol=2e-4)
    chord = first(arm, SPEED[slow], "equilibrium", True)
    np.testing.assert_allclose(chord, np.sqrt(FLAP[slow] ** 2 - SPEED[slow] ** 2), rtol=2e-4)
