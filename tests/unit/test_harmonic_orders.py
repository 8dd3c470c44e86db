"""Orders of a periodic system told apart by impacts: known functions are found again."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import InputError
from flexmech.arrays import ComplexArray, FloatArray
from flexmech.modal_testing import estimate_harmonics

ORDER, SHIFT, BINS, COUNT = 2, 4, 30, 64
ORDERS = np.arange(-ORDER, ORDER + 1)


def functions(highest: int) -> ComplexArray:
    """H_n at the bins -COUNT to COUNT, with H_-n(-f) the conjugate of H_n(f)."""
    generator = np.random.default_rng(1)
    values = generator.normal(size=(2 * highest + 1, 2 * COUNT + 1, 2)) @ [1, 1j]
    return (values + values[::-1, ::-1].conj()) / 2


def pulses(phase: FloatArray) -> ComplexArray:
    """Force of a pulse that comes at each place of a period, at the bins from zero."""
    number = np.arange(COUNT)
    return np.exp(-((number / 40) ** 2)) * np.exp(-2j * np.pi * phase[:, None] * number / SHIFT)


def answered(response: ComplexArray, force: ComplexArray) -> ComplexArray:
    """What all orders answer at the bins from zero; input beyond the last bin is none."""
    highest = len(response) // 2
    both = np.concatenate([force[:, :0:-1].conj(), force], axis=1)
    total = np.zeros(force.shape, dtype=complex)
    for row, order in enumerate(range(-highest, highest + 1)):
        entering = np.arange(COUNT) - SHIFT * order
        inside = np.abs(entering) < COUNT
        own = both[:, np.clip(entering + COUNT - 1, 0, 2 * COUNT - 2)] * inside
        total += response[row, np.clip(entering + COUNT, 0, 2 * COUNT)] * own
    return total


def spread(count: int) -> FloatArray:
    jitter = 0.2 * np.random.default_rng(0).uniform(-1, 1, count)
    return (np.arange(count) + 0.5 + jitter) / count


def estimated(phase: FloatArray, highest: int = ORDER):
    force = pulses(phase)
    return estimate_harmonics(
        force,
        answered(functions(highest), force),
        highest_order=ORDER,
        shift=SHIFT,
        bins=BINS,
    )


@pytest.mark.parametrize("count", [5, 9])
def test_known_functions_are_found_again(count: int) -> None:
    found = estimated(spread(count))
    np.testing.assert_allclose(found.response, functions(ORDER)[:, COUNT : COUNT + BINS], rtol=1e-9)
    assert 1 <= found.condition < 3
    assert found.misfit < 1e-12


def test_an_order_that_is_left_out_shows_in_the_misfit() -> None:
    assert estimated(spread(9), highest=3).misfit > 0.05


def test_impacts_at_one_place_of_the_period_are_refused() -> None:
    with pytest.raises(InputError, match="spread them over the period"):
        estimated(np.full(7, 0.3) + 1e-6 * np.arange(7))


def test_fewer_impacts_than_orders_are_refused() -> None:
    with pytest.raises(InputError, match="4 impacts cannot tell 5 orders apart"):
        estimated(spread(4))


@pytest.mark.parametrize("bins", [COUNT - 2 * ORDER * SHIFT + 1, COUNT])
def test_records_that_are_sampled_too_coarsely_are_refused(bins: int) -> None:
    """What enters at the last bin of the response is beyond it by the highest order."""
    force = pulses(spread(5))
    with pytest.raises(InputError, match="sample them more often"):
        estimate_harmonics(force, force, highest_order=ORDER, shift=SHIFT, bins=bins)
    estimate_harmonics(
        force, force, highest_order=ORDER, shift=SHIFT, bins=COUNT - 2 * ORDER * SHIFT
    )
