"""Point masses that are close to each other or to a joint: no element of a hair's length."""

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ExudynEngine,
    FourBar,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    natural_frequencies,
)

ANGLES = np.radians([30.0, 60.0])
LENGTH = 0.0963
# Elements between these points would be 1e11 times as stiff as the link; the first frequency was
# 1 to 3 % off by round-off, another amount in each mesh.
NEAR = 1.6e-5


ENGINES = [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")]


def first_frequency(masses, engine, elements: int) -> np.ndarray:
    """Of a four-bar with a soft crank and a coupler that carries point masses."""

    def section(thickness: float) -> BeamSection:
        return BeamSection.rectangle(Material(70e9, 2700, 0.3), thickness, 20e-3)

    mechanism = Mechanism(
        FourBar(0.1123, 0.0316, LENGTH, 0.1117),
        {"crank": section(2.7e-4), "coupler": section(1.7e-3), "rocker": section(1.9e-3)},
        link_masses=tuple(PointMass("coupler", place, mass) for place, mass in masses),
    )
    kind, element = engine
    return natural_frequencies(
        kind(mechanism, elements, element), ANGLES, modes=1, prestress="none"
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("elements", [4, 16])
def test_two_close_masses_are_as_one(engine, elements):
    pair = [(0.0163, 8.7e-4), (0.0163 + NEAR, 14.4e-4)]
    centre = 0.0163 + NEAR * 14.4 / (8.7 + 14.4)
    one = first_frequency([(centre, 23.1e-4)], engine, elements)
    np.testing.assert_allclose(first_frequency(pair, engine, elements), one, rtol=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("end", [0.0, LENGTH])
def test_a_mass_close_to_an_end_moves_with_the_end(engine, end):
    """The frequency changes in proportion to the distance."""
    inner = abs(end - NEAR)
    at_end, near = (first_frequency([(x, 20e-4)], engine, 16) for x in (end, inner))
    further = first_frequency([(abs(end - 1e-3), 20e-4)], engine, 16)
    np.testing.assert_allclose(near - at_end, (further - at_end) * NEAR / 1e-3, rtol=0.05)
