"""Band form of matrices whose coordinates stand in any order."""

import numpy as np

from flexmech.analyses.frequencies.band_form import BandForm

SIZE, NEIGHBOURS = 30, 2


def chain_matrices(count, seed=3):
    """Unsymmetric matrices of a chain, its coordinates shuffled; small pivots on the diagonal."""
    rng = np.random.default_rng(seed)
    matrices = rng.normal(size=(count, SIZE, SIZE))
    place = np.arange(SIZE)
    matrices[:, np.abs(place[:, None] - place) > NEIGHBOURS] = 0.0
    matrices[:, place, place] *= 1e-9
    shuffled = np.random.default_rng(1).permutation(SIZE)
    return matrices[:, shuffled[:, None], shuffled]


def test_systems_are_solved_in_a_narrow_band():
    first, second = chain_matrices(4), chain_matrices(4, seed=5)
    band = BandForm.of(first, second)
    assert band.width <= 2 * NEIGHBOURS
    right = np.random.default_rng(0).normal(size=(4, SIZE)) + 1j
    found = band.solve(band.entries(first) + 2j * band.entries(second), right[:, band.order])
    expected = np.linalg.solve(first + 2j * second, right[..., None])[..., 0]
    np.testing.assert_allclose(found, expected[:, band.order], rtol=1e-9)


def test_an_entry_that_is_zero_in_some_positions_is_kept():
    matrices = chain_matrices(2)
    matrices[0, 3] = matrices[0, :, 3] = 0.0
    matrices[0, 3, 3] = 1.0
    band = BandForm.of(matrices)
    right = np.ones((2, SIZE), dtype=complex)
    found = band.solve(band.entries(matrices), right)
    expected = np.linalg.solve(matrices, np.ones((2, SIZE, 1)))[..., 0]
    np.testing.assert_allclose(found, expected[:, band.order], rtol=1e-9)


def test_a_singular_matrix_has_no_solution_and_leaves_the_others_alone():
    matrices = chain_matrices(2)
    matrices[0, 3] = 0.0
    band = BandForm.of(matrices)
    found = band.solve(band.entries(matrices), np.ones((2, SIZE), dtype=complex))
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1]).all()
