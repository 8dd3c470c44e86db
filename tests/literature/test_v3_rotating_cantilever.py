"""Validation V3: rotating cantilever, beyond the cases of the verification.

Hamza-Cherif & Houmat, ICAS 2004, Table 2. Speeds and frequencies over sqrt(EI / rhoA L^4).
"""

from dataclasses import replace

import numpy as np
import pytest

from flexmech.verification import verification_case

FLAP = verification_case("Rotating arm of slenderness 70: flap, speeds 2 to 10")


def test_flap_in_component_modes():
    reduced = replace(FLAP, measured_by=FLAP.measured_by.with_(component_modes=True))
    assert reduced.outcome().verdict == "passed"


@pytest.mark.parametrize("engine", ["reference", "exudyn"])
def test_slender_limit_of_the_geometrically_exact_equilibrium(engine):
    """Without the stretch, the chord's square is the flap's less the speed's."""
    speeds, flap = np.array(FLAP.measured_by.settings["speeds"]), FLAP.expected_values()
    arm = FLAP.measured_by.with_(
        engine=engine, elements=24, slenderness=1000, prestress="equilibrium"
    )
    np.testing.assert_allclose(arm.values(), flap, rtol=FLAP.tolerance)
    chord = arm.with_(rotation_terms=True).values()
    np.testing.assert_allclose(chord, np.sqrt(flap**2 - speeds**2), rtol=FLAP.tolerance)
