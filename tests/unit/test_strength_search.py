"""Speeds at which parts fail, found of load factors that are known by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest

from flexmech.analyses.strength.speed_search import FASTEST, SpeedSearch, search_roots
from flexmech.errors import ComputationError


def searched(end: float = math.inf, **parts: float) -> tuple[SpeedSearch, list[float]]:
    """Of load factors ``a / (s^2 + b s^4 + c)`` of parts; ``parts`` are a, b and c of each."""
    asked: list[float] = []

    def at(speed: float) -> Mapping[str, float]:
        return {
            name: a / (speed**2 + b * speed**4 + c)
            for name, (a, b, c) in parts.items()  # type: ignore[misc]
        }

    def least(speed: float) -> Mapping[str, float]:
        asked.append(speed)
        if speed >= end:
            raise ComputationError("no equilibrium at {crank_speed}: slow down", crank_speed=3.0)
        return at(speed)

    return search_roots(least, at(1.0)), asked


def test_straight_links_need_two_more_speeds() -> None:
    """Their load factor is a straight line in logarithms: the second one is at its root."""
    found, asked = searched(link=(5.0, 0.0, 0.0))
    assert found.speed_factor["link"] == pytest.approx(math.sqrt(5), rel=1e-12)
    assert len(asked) == 1
    assert not found.note


def test_roots_of_parts_that_stiffen_and_soften() -> None:
    parts = {"a": (40.0, 0.05, 0.0), "b": (90.0, -0.002, 0.0), "c": (7.0, 0.3, 0.4)}
    found, asked = searched(**parts)  # type: ignore[arg-type]
    for name, (a, b, c) in parts.items():
        roots = np.roots([b, 0, 1, 0, c - a])
        real = roots[np.isreal(roots) & (roots.real > 0)].real
        assert found.speed_factor[name] == pytest.approx(real.min(), rel=3e-4)
    assert len(asked) < 12
    assert found.factor.tolist() == sorted([1.0, *asked])
    assert found.part[0] == "c"


def test_a_part_that_fails_already_is_slowed_down() -> None:
    found, _ = searched(a=(0.2, 0.1, 0.0), b=(0.05, 0.0, 0.02))  # type: ignore[arg-type]
    assert found.speed_factor["b"] == pytest.approx(math.sqrt(0.03), rel=3e-4)
    square = (-1 + math.sqrt(1 + 4 * 0.1 * 0.2)) / 0.2
    assert found.speed_factor["a"] == pytest.approx(math.sqrt(square), rel=3e-4)


def test_what_fails_at_rest_has_no_speed() -> None:
    found, _ = searched(a=(0.5, 0.0, 0.6))  # type: ignore[arg-type]
    assert found.speed_factor == {"a": 0.0}


def test_search_ends_where_no_equilibrium_is() -> None:
    """Near to it parts are found that fail before; the others are named."""
    found, _ = searched(end=3.0, a=(8.0, 0.0, 0.0), b=(40.0, 0.0, 0.0))  # type: ignore[arg-type]
    assert found.speed_factor == {"a": pytest.approx(math.sqrt(8), rel=3e-4)}
    assert found.note.startswith("ended at 3")
    assert "no equilibrium at 3 rad/s; up to there these do not fail: b" in found.note
    assert "slow down" not in found.note


def test_what_no_speed_moves_is_told() -> None:
    still, asked = searched(a=(1e9, 0.0, 1.0))  # type: ignore[arg-type]
    assert not still.speed_factor
    assert f"ended at {FASTEST:.4g} times the speed; up to there these do not fail: a" == still.note
    assert max(asked) < FASTEST
    assert len(asked) <= 25


def test_infinite_and_zero_load_factors_need_no_search() -> None:
    found = search_roots(lambda speed: {}, {"a": math.inf, "b": 0.0})
    assert found.speed_factor == {"a": math.inf, "b": 0.0}
    assert found.factor.tolist() == [1.0]
