"""Where a ray meets a band whose end two crank angles share, nearly."""

from __future__ import annotations

import numpy as np
import pytest

from tests.unit.test_tolerances_of_campbell import crossed

MEAN, HALF, APART = 10.0, 0.3, 1e-3


@pytest.mark.parametrize("sign", [-1.0, 1.0], ids=["lowest", "highest"])
def test_a_ray_enters_at_the_first_extreme_and_leaves_behind_the_last(
    monkeypatch: pytest.MonkeyPatch, sign: float
) -> None:
    """At crank angles 0 and 180 degrees, whose frequencies are 2e-4 of them apart."""

    def frequency(angle: np.ndarray, speed: np.ndarray) -> np.ndarray:
        return MEAN + sign * (HALF * np.cos(2 * angle) + APART * np.cos(angle)) + 0 * speed

    passed, speeds, _, _ = crossed(monkeypatch, frequency, [1])
    (edge,) = (own for own in passed if own.enters == (sign < 0))
    farthest = MEAN + sign * (HALF + APART)
    assert speeds[edge] == pytest.approx(2 * np.pi * farthest, rel=1e-8)
