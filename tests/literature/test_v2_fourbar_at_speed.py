"""Validation V2: four-bars prestressed by their own inertia forces, no rotation terms.

Independent numbers: OpenSees (corotational, 64 elements a link) and Exudyn.
"""

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, natural_frequencies

SLENDER = {ReferenceEngine: "euler", ExudynEngine: "ancf"}
EQUILIBRIUM = {
    ("steel", 0, 20): [62.1859, 127.977, 170.519],
    ("steel", 60, 20): [95.1136, 135.625, 232.711],
    ("aluminium", 0, 20): [45.158, 47.683, 114.499],
    ("aluminium", 60, 20): [45.050, 48.966, 175.244],
}
CLASSICAL = {
    ("steel", 0, 20): [62.1021, 127.9497, 170.594],
    ("steel", 60, 40): [95.4045, 135.472, 233.434],
    ("aluminium", 0, 20): [44.864, 47.9225, 114.536],
}


def at(engine, mechanism, case, prestress):
    _, angle, speed = case
    return natural_frequencies(
        engine(mechanism, 16, SLENDER[engine]),
        np.radians(angle),
        speed,
        modes=3,
        prestress=prestress,
        rotation_terms=False,
    )


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("case", EQUILIBRIUM)
def test_equilibrium(mechanisms, case, engine):
    computed = at(engine, mechanisms[case[0]], case, "equilibrium")
    np.testing.assert_allclose(computed, EQUILIBRIUM[case], rtol=5e-5)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("case", CLASSICAL)
def test_classical_axial_force(mechanisms, case, engine):
    """Turcic & Midha's k_G (eq. 1.58) alone."""
    computed = at(engine, mechanisms[case[0]], case, "axial")
    np.testing.assert_allclose(computed, CLASSICAL[case], rtol=5e-5)


def test_classical_form_misses_part_of_the_effect(mechanisms):
    """Aluminium at 20 rad/s: posture adds more than half of what tension does."""
    case = ("aluminium", 0, 20)
    engine = ReferenceEngine
    rest = natural_frequencies(engine(mechanisms["aluminium"], 16, "euler"), 0.0, modes=1)
    tension = at(engine, mechanisms["aluminium"], case, "axial")[0] - rest[0]
    whole = at(engine, mechanisms["aluminium"], case, "equilibrium")[0] - rest[0]
    assert tension / whole == pytest.approx((44.864 - 44.3115) / (45.158 - 44.3115), abs=2e-3)
