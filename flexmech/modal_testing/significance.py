"""Which poles stand out of the noise.

Taken out of the model, a pole leaves more of the receptances unexplained. Of noise alone that gain
over its variance is chi-squared with as many degrees of freedom as a mode has numbers: a residue at
each point, and a pole. The greatest of as many trials as there are spectral lines is what noise can
look like at best.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from flexmech.modal_testing.identified import residue_columns
from flexmech.types import ComplexArray, FloatArray

FALSE_ALARM = 1e-3
"""Probability that noise alone gives a mode somewhere in the band."""


def significant_poles(
    s: ComplexArray, receptance: ComplexArray, pole: ComplexArray
) -> ComplexArray:
    """Poles without those that noise explains as well; the least one is taken out first.

    Parameters
    ----------
    s : ndarray of complex, shape (F,)
        In 1/s; none of them 0.
    receptance : ndarray of complex, shape (points, F)
    pole : ndarray of complex, shape (k,)

    Returns
    -------
    ndarray of complex, shape (l,)
    """
    points, lines = receptance.shape
    least = chi2.isf(FALSE_ALARM / lines, 2 * points + 2)
    values = np.concatenate([receptance.real, receptance.imag], axis=1).T
    while pole.size:
        with_all = _left(s, pole, values)
        free = values.size - 2 * points * (pole.size + 1) - 2 * pole.size
        variance = with_all / max(free, 1)
        gain = np.array(
            [_left(s, np.delete(pole, one), values) - with_all for one in range(pole.size)]
        )
        weakest = int(np.argmin(gain))
        if gain[weakest] > least * variance:
            break
        pole = np.delete(pole, weakest)
    return pole


def _left(s: ComplexArray, pole: ComplexArray, values: FloatArray) -> float:
    """Sum of squares that the best residues of some poles leave."""
    matrix = residue_columns(s, pole)
    basis, _ = np.linalg.qr(matrix / np.linalg.norm(matrix, axis=0))
    return float(np.sum((values - basis @ (basis.T @ values)) ** 2))
