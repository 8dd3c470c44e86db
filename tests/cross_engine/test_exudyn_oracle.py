"""Exudyn's own eigenvalues of the constrained system, as an oracle at rest."""

import numpy as np
import pytest

from flexmech import ExudynEngine
from flexmech.analyses import solve_frequencies
from flexmech.multibody.library import load_exudyn
from flexmech.threads import one_thread

ANGLES = np.radians([0.0, 70.0, 200.0, 310.0])
# Shear and stretch of the geometrically exact beams reach far above the frequencies asked
# for; what the oracle's null space loses to round-off goes with them.
TOLERANCE = {"ancf": 1e-8, "geometrically-exact": 5e-8}


def oracle(engine, mechanism):
    """mbs.ComputeODE2Eigenvalues at each crank angle; squares of angular frequencies."""
    model, motion = engine.model, mechanism.linkage.motion(ANGLES)
    mbs = model.assembly.mbs
    initial = load_exudyn().ConfigurationType.Initial
    frequencies = []
    with one_thread():
        for number in range(len(ANGLES)):
            mbs.systemData.SetODE2Coordinates(model.move_to(motion, number), initial)
            squares = np.sort(mbs.ComputeODE2Eigenvalues()[0])
            frequencies.append(np.sqrt(squares[:6]) / (2 * np.pi))
    return np.array(frequencies)


@pytest.mark.parametrize("name", ["aluminium", "steel"])
@pytest.mark.parametrize("element", ["ancf", "geometrically-exact"])
def test_unreduced_frequencies_are_exudyn_s_own(mechanisms, name, element):
    engine = ExudynEngine(mechanisms[name], 8, element)
    computed = solve_frequencies(engine.unreduced().linear_system(ANGLES), 6)
    np.testing.assert_allclose(computed, oracle(engine, mechanisms[name]), rtol=TOLERANCE[element])


def test_finely_reduced_frequencies_are_exudyn_s_own(aluminium):
    engine = ExudynEngine(aluminium, 8)
    computed = solve_frequencies(engine.linear_system(ANGLES, modes=6, detail=4.0), 6)
    np.testing.assert_allclose(computed, oracle(engine, aluminium), rtol=1e-8)
