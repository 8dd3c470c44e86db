"""Validation V1: four-bars at rest, exact dynamic stiffness (Wittrick-Williams)."""

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, natural_frequencies

SLENDER = {ReferenceEngine: "euler", ExudynEngine: "ancf"}
EXACT = {
    ("aluminium", 0): [44.3115, 48.0842, 114.4693, 187.3841],
    ("aluminium", 60): [44.4855, 49.4209, 174.797, 194.6211],
    ("aluminium", 120): [45.0190, 48.9228, 132.7079, 180.7425],
    ("aluminium", 180): [44.9826, 49.2311, 154.1866, 187.2666],
    ("steel", 0): [62.025, 127.781, 170.635],
}


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize(("elements", "tolerance"), [(8, 3e-4), (16, 3e-5)])
@pytest.mark.parametrize("case", EXACT)
def test_frequencies(mechanisms, case, elements, tolerance, engine):
    name, angle = case
    expected = np.array(EXACT[case])
    computed = natural_frequencies(
        engine(mechanisms[name], elements, SLENDER[engine]), np.radians(angle), modes=len(expected)
    )
    np.testing.assert_allclose(computed, expected, rtol=tolerance)


def test_frequencies_stay_below_the_pinned_links(aluminium):
    """The lowest two modes lie below those of coupler and rocker held at their pins."""
    angles = np.radians(np.arange(0, 360, 15))
    frequency = natural_frequencies(ReferenceEngine(aluminium, 16, "euler"), angles, modes=2)
    assert np.all(frequency[:, 0] < 45.1223)
    assert np.all(frequency[:, 1] < 49.5220 * (1 + 2e-6))
