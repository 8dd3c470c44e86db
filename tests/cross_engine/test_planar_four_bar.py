"""The aluminium four-bar drawn as a planar linkage: the four-bar's numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    ResponseRequest,
    campbell,
    load_mechanism,
    moving_frequencies,
    response,
    stability,
)
from flexmech.modelfile import mechanism_from_toml
from tests.support.planar_four_bar import drawn_as_planar

ALUMINIUM = Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml"
# Equal but for rounding of the drawn coordinates.
EQUAL = 1e-12
# What Newton's method in Exudyn's static solver leaves.
STATIC = 1e-10


@pytest.fixture(scope="module")
def both() -> tuple[Mechanism, Mechanism]:
    """The four-bar, and its drawing as a model file reads it."""
    own = load_mechanism(ALUMINIUM)
    own = replace(
        own,
        sections={name: one.with_damping_time(2e-5) for name, one in own.sections.items()},
        joint_masses={"A": 0.02, "B": 0.01},
        gravity=(0.0, -9.81),
    )
    drawn = replace(own, linkage=drawn_as_planar(own.linkage, np.radians(60.0)))
    return own, mechanism_from_toml(drawn.to_toml())


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_frequencies_are_the_same(both, engine, prestress):
    values = [
        moving_frequencies(
            [engine(mechanism, 4)],
            np.radians(np.arange(0.0, 360.0, 45.0)),
            [0.0, 20.0],
            modes=4,
            prestress=prestress,
        )
        .dataset["frequency"]
        .values
        for mechanism in both
    ]
    tolerance = STATIC if (engine, prestress) == (ExudynEngine, "equilibrium") else EQUAL
    np.testing.assert_allclose(values[1], values[0], rtol=tolerance)


def compared(result, other, names):
    """The largest difference of some variables over the largest of each."""
    for name in names:
        first, second = (each.dataset[name].values for each in (result, other))
        assert np.isfinite(first).any(), name
        apart = np.nanmax(np.abs(second - first)) / np.nanmax(np.abs(first))
        assert apart < 1e-9, name


@pytest.mark.thorough
def test_the_running_response_is_the_same(both):
    request = ResponseRequest(ConstantSpeed(20.0), revolutions=1)
    results = [response(ReferenceEngine(mechanism, 4), request) for mechanism in both]
    compared(*results, ["deflection", "strain", "driving_torque", "joint_force"])


@pytest.mark.thorough
def test_stability_and_campbell_diagrams_are_the_same(both):
    maps = [stability(ReferenceEngine(mechanism, 2), [15.0, 20.0], modes=3) for mechanism in both]
    compared(*maps, ["growth_rate", "multiplier_modulus"])
    diagrams = [campbell(ReferenceEngine(mechanism, 4), [0.0, 10.0, 20.0]) for mechanism in both]
    compared(*diagrams, ["mean_frequency"])
