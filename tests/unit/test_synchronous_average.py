"""What a running machine repeats in every turn is taken off its records."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech.errors import InputError
from flexmech.modal_testing import without_synchronous_average

TURN, TURNS = 32, 12


def running(turns: int = TURNS) -> np.ndarray:
    phase = 2 * np.pi * np.arange(TURN * turns) / TURN
    return 3.0 + np.cos(phase) - 0.4 * np.sin(5 * phase)


def ringing(start: int, turns: int = TURNS) -> np.ndarray:
    since = np.arange(TURN * turns) - start
    return np.where(since > 0, np.exp(-0.02 * since) * np.sin(0.7 * since), 0.0)


@given(start=st.integers(TURN, 4 * TURN))
def test_an_impact_is_left_alone(start: int) -> None:
    answer = ringing(start)
    left = without_synchronous_average(running() + answer, TURN, np.arange(answer.size) <= start)
    np.testing.assert_allclose(left, answer, atol=1e-12)


def test_records_may_be_stacked() -> None:
    both = np.stack([running() + ringing(40), 2 * running() + ringing(50)])
    left = without_synchronous_average(both, TURN, np.arange(both.shape[1]) <= 40)
    np.testing.assert_allclose(left, np.stack([ringing(40), ringing(50)]), atol=1e-12)


def test_more_quiet_turns_add_less_noise() -> None:
    noise = np.random.default_rng(3).standard_normal(TURN * 104)
    added = []
    for turns in (4, 100):
        quiet = np.arange(noise.size) < turns * TURN
        left = without_synchronous_average(running(104) + noise, TURN, quiet)
        added.append(np.std((left - noise)[-TURN:]))
    assert added == pytest.approx([0.5, 0.1], rel=0.35)


@pytest.mark.parametrize(
    ("record", "quiet", "message"),
    [
        (running(), np.arange(TURN * TURNS) < 20, "12 of 32 places of the period have no quiet"),
        (running(), np.ones(5, dtype=bool), "give one value for each of 384"),
        (np.full(64, np.nan), np.ones(64, dtype=bool), "not finite"),
    ],
)
def test_records_without_an_average(record: np.ndarray, quiet: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        without_synchronous_average(record, TURN, quiet)
