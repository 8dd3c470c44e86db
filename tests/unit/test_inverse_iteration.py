"""Eigenvalues improved by sparse inverse iteration, against dense solutions."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg
from scipy.sparse import csc_array

from flexmech.analyses.frequencies.inverse_iteration import Pencil, newton_values, ritz_values
from flexmech.linear_system import SparseMatrices

SIZE, NEIGHBOURS = 30, 2


def chain(seed=3, *, fixed=True):
    """Symmetric mass and stiffness of a chain of springs, its coordinates shuffled."""
    rng = np.random.default_rng(seed)
    mass = np.diag(rng.uniform(1.0, 2.0, SIZE))
    stiffness = np.zeros((SIZE, SIZE))
    for place, spring in enumerate(rng.uniform(50.0, 90.0, SIZE - 1)):
        stiffness[place : place + 2, place : place + 2] += spring * np.array([[1, -1], [-1, 1]])
    stiffness[0, 0] += 70.0 * fixed
    shuffled = np.random.default_rng(1).permutation(SIZE)
    return tuple(each[shuffled[:, None], shuffled] for each in (mass, stiffness))


def unsymmetric(seed):
    """An unsymmetric band of shuffled coordinates."""
    matrix = np.random.default_rng(seed).normal(size=(SIZE, SIZE))
    place = np.arange(SIZE)
    matrix[np.abs(place[:, None] - place) > NEIGHBOURS] = 0.0
    shuffled = np.random.default_rng(1).permutation(SIZE)
    return matrix[shuffled[:, None], shuffled]


def pencil(mass, damping, stiffness):
    return Pencil.of(SparseMatrices(*map(csc_array, (mass, damping, stiffness))))


def off(shapes, part):
    return shapes + part * np.random.default_rng(2).normal(size=shapes.shape) * np.abs(shapes).max()


def quadratic():
    """Matrices with damping and gyroscopic terms, and all of their eigenvalues and shapes."""
    mass, stiffness = chain()
    damping, stiffness = 0.3 * unsymmetric(4), stiffness + 0.3 * unsymmetric(5)
    nothing, one = np.zeros((SIZE, SIZE)), np.eye(SIZE)
    companion = np.block(
        [[nothing, one], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]]
    )
    values, states = np.linalg.eig(companion)
    some = np.argsort(np.abs(values) + 1e9 * (values.imag <= 0))[:3]
    return pencil(mass, damping, stiffness), values[some], states[:SIZE, some]


@pytest.mark.parametrize("fixed", [True, False])
def test_a_step_in_the_space_of_symmetric_shapes_has_the_square_of_their_error(fixed):
    rigid = 0 if fixed else 1
    positions = [chain(seed, fixed=fixed) for seed in (3, 7)]
    exact = [scipy.linalg.eigh(stiffness, mass) for mass, stiffness in positions]
    squares = np.stack([values[rigid : rigid + 3] for values, _ in exact])
    shapes = np.stack([vectors[:, rigid : rigid + 3] for _, vectors in exact])
    pencils = [pencil(mass, 0 * mass, stiffness) for mass, stiffness in positions]
    errors = [
        np.abs(ritz_values(pencils, off(shapes, part), rigid=not fixed).imag / np.sqrt(squares) - 1)
        for part in (1e-3, 1e-4)
    ]
    errors = [error.max() for error in errors]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 50


def test_newtons_method_finds_eigenvalues_of_damped_and_turning_systems():
    one, values, shapes = quadratic()
    # Two positions, of which the second is further off.
    start = np.stack([values * (1 + 1e-3), values * (1 + 2e-3)])
    begun = np.stack([off(shapes, 1e-3), off(shapes, 2e-3)])
    first = newton_values([one, one], start, begun)
    assert np.abs(first / values - 1).max() < 1e-4
    converged = newton_values([one, one], start, begun, steps=8)
    np.testing.assert_allclose(converged, [values, values], rtol=1e-11)


def test_an_eigenvalue_at_which_the_matrix_is_singular_stays():
    mass, stiffness = np.eye(3), np.diag([4.0, 9.0, 0.0])
    start = np.array([[2j, 2.9j]])
    [found] = newton_values([pencil(mass, 0 * mass, stiffness)], start, np.eye(3)[None, :, :2])
    assert found[0] == 2j
    assert found[1] == pytest.approx(3j, rel=1e-3)


def test_positions_have_one_pattern_even_where_an_entry_is_zero():
    matrices = np.stack([unsymmetric(1), unsymmetric(6)])
    matrices[0, 3] = 0.0
    system = SimpleNamespace(
        mass=matrices, damping=2 * matrices, stiffness=np.swapaxes(matrices, 1, 2), size=SIZE
    )
    for place, one in enumerate(Pencil.of_positions(system)):
        total = one.total(2.0, 1j, 3.0).toarray()
        expected = (2.0 + 2j) * matrices[place] + 3.0 * matrices[place].T
        np.testing.assert_allclose(total, expected, rtol=1e-14)
