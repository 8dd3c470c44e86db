"""The search for the speed at which a part fails first."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.analyses.strength.speed_search import HALVINGS, STEPS, search_speed
from flexmech.errors import ComputationError


def test_inertia_alone_is_found_at_the_root() -> None:
    start = 9.0
    found = search_speed(lambda s: {"a": start / s**2, "b": 2 * start / s**2}, start)
    step = (1.1 * 3 - 1) / (STEPS - 1)
    assert [*found.speed_factor] == ["a"]
    assert 3 <= found.speed_factor["a"] < 3 + step / 2**HALVINGS
    assert not found.note
    assert np.all(np.diff(found.factor) > 0)
    np.testing.assert_allclose(found.load_factor, start / found.factor**2)


def test_a_resonance_comes_first() -> None:
    """Amplified loads of another part pass 1 where (1 - (s / 2)^2) f0 / s^2 = 1."""
    start = 16.0

    def least(factor: float) -> dict[str, float]:
        amplified = abs(1 - (factor / 2) ** 2)
        return {"quiet": start / factor**2, "ringing": start * amplified / factor**2}

    found = search_speed(least, 12.0)
    expected = np.sqrt(start / (1 + start / 4))
    assert found.speed_factor == {"ringing": pytest.approx(expected, rel=2e-3)}


def test_a_part_that_fails_already() -> None:
    found = search_speed(lambda s: {"a": 0.5 / s**2}, 0.5)
    assert found.speed_factor == {"a": 1.0}
    assert found.factor.tolist() == [1.0]


def test_no_failure_and_no_motion_are_told() -> None:
    found = search_speed(lambda s: {"a": 5.0}, 5.0)
    assert found.speed_factor == {}
    assert "no part fails up to" in found.note

    def buckles(factor: float) -> dict[str, float]:
        if factor > 1.5:
            raise ComputationError("no equilibrium")
        return {"a": 5.0 / factor**2}

    found = search_speed(buckles, 5.0)
    assert found.speed_factor == {}
    assert "no equilibrium" in found.note
    assert found.factor.max() <= 1.5
