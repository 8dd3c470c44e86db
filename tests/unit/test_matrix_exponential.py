"""Exponentials of many small matrices at once."""

import numpy as np
import pytest

from flexmech.dynamical_systems import matrix_exponentials
from flexmech.dynamical_systems.periodic_system import BLOCK, cache_blocks


@pytest.mark.parametrize("size", [1, 2, 5, 24])
@pytest.mark.parametrize("norm", [0.0, 1e-9, 0.7, 3.0, 60.0])
def test_exponentials_are_those_by_their_series(size: int, norm: float) -> None:
    """The series in extended precision; eigenvectors would lose digits of their own."""
    matrices = np.random.default_rng(size).normal(size=(7, size, size))
    matrices *= norm / np.abs(matrices).sum(axis=1).max()
    halvings = 8
    term = np.broadcast_to(np.eye(size, dtype=np.longdouble), matrices.shape)
    exact = term.copy()
    for order in range(1, 25):
        term = term @ (matrices / np.longdouble(2.0**halvings)) / order
        exact += term
    for _ in range(halvings):
        exact = exact @ exact
    gap = np.abs(matrix_exponentials(matrices) - exact).max(axis=(1, 2))
    assert np.all(gap < 1e-15 * max(10.0, norm) * np.abs(exact).max(axis=(1, 2)))


def test_what_dies_out_in_a_step_is_not_lost_beside_what_stays() -> None:
    found = matrix_exponentials(np.diag([-700.0, -30.0, 0.0])[None])
    assert np.diag(found[0]) == pytest.approx(np.exp([-700.0, -30.0, 0.0]), rel=1e-11)


def test_a_stack_longer_than_a_block_keeps_its_order() -> None:
    angle = np.linspace(0.0, 1.0, 3 * BLOCK // 32 + 5)
    turning = angle[:, None, None] * np.array([[0.0, -1.0], [1.0, 0.0]])
    assert len(cache_blocks(turning)) == 4
    found = matrix_exponentials(turning)
    assert np.abs(found[:, 1, 0] - np.sin(angle)).max() < 1e-15


def test_what_is_beyond_all_numbers_is_not_finite() -> None:
    for beyond in (1e4, np.inf, np.nan):
        assert not np.isfinite(matrix_exponentials(np.full((1, 2, 2), beyond))).any()


def test_nothing_gives_nothing() -> None:
    assert matrix_exponentials(np.empty((0, 3, 3))).shape == (0, 3, 3)
