"""Maps from a link's coordinates to its nodes': rates, forces and tangents are derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.arrays import FloatArray
from flexmech.multibody.arms import Arms
from flexmech.multibody.node_directions import PolarSlopes

MAPS = pytest.mark.parametrize(
    ("mapped", "size"),
    [(Arms(0.013), 6), (PolarSlopes(np.array([2, 6])), 8)],
    ids=["arms", "slopes"],
)
SMALL = 1e-6


def state(size: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Coordinates far from the straight link, their rates, and forces that stay as they are."""
    random = np.random.default_rng(2)
    coordinates, rate, force = random.uniform(-0.6, 0.6, (3, size))
    return coordinates, rate, force


@MAPS
def test_the_inverse_leads_back(mapped: Arms | PolarSlopes, size: int) -> None:
    own, rate, _ = state(size)
    nodes, moving = mapped.to_nodes(own), mapped.rate_to_nodes(own, rate)
    np.testing.assert_allclose(mapped.inverse.to_nodes(nodes), own, rtol=0, atol=1e-14)
    back = mapped.inverse.rate_to_nodes(nodes, moving)
    np.testing.assert_allclose(back, rate, rtol=0, atol=1e-14)


@MAPS
def test_rates_are_derivatives_and_forces_do_their_work(
    mapped: Arms | PolarSlopes, size: int
) -> None:
    own, rate, force = state(size)
    ahead, back = (mapped.to_nodes(own + sign * SMALL * rate) for sign in (1, -1))
    moving = mapped.rate_to_nodes(own, rate)
    np.testing.assert_allclose(moving, (ahead - back) / (2 * SMALL), rtol=0, atol=1e-9)
    assert mapped.force(own, force) @ rate == pytest.approx(force @ moving, rel=1e-12)


@MAPS
def test_the_tangent_is_the_derivative_of_the_force(mapped: Arms | PolarSlopes, size: int) -> None:
    """Of nodes on springs, whose stiffness need not be symmetric."""
    own, rate, force = state(size)
    stiffness = np.random.default_rng(3).normal(size=(size, size))
    nodes = mapped.to_nodes(own)

    def on_link(coordinates: FloatArray) -> FloatArray:
        on_nodes = force + stiffness @ (mapped.to_nodes(coordinates) - nodes)
        return mapped.force(coordinates, on_nodes)

    change = (on_link(own + SMALL * rate) - on_link(own - SMALL * rate)) / (2 * SMALL)
    tangent = mapped.tangent(own, stiffness, force)
    np.testing.assert_allclose(tangent @ rate, change, rtol=0, atol=1e-9)
    work = rate @ mapped.matrix(own, stiffness) @ rate
    moving = mapped.rate_to_nodes(own, rate)
    assert work == pytest.approx(moving @ stiffness @ moving, rel=1e-12)
