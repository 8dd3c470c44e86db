"""Transition matrices of linear systems ``x' = A(t) x`` over short steps.

The Magnus expansion of sixth order: the transition matrix of a step is the exponential of one
matrix that is made of A at the three Gauss points and its commutators (S. Blanes, F. Casas,
J. A. Oteo & J. Ros, The Magnus expansion and some of its applications, Physics Reports 470
(2009) 151-238, section 5.4). What holds for the exact transition matrix holds for this one
whatever the step: that of a Hamiltonian system is symplectic, its determinant is the exponential
of the integral of the trace (Liouville), and what is strongly damped dies out. A constant system
is solved exactly.
"""

from __future__ import annotations

import numpy as np

from flexmech.time_domain.matrix_exponential import cache_blocks
from flexmech.types import FloatArray

ORDER = 6
"""Of the error in the length of the step."""
GAUSS_POINTS = tuple((0.5 + 0.1 * np.sqrt(15.0) * np.array([-1.0, 0.0, 1.0])).tolist())
"""Places in a step at which A is wanted."""


def step_exponents(
    first: FloatArray, middle: FloatArray, last: FloatArray, step: float
) -> FloatArray:
    """Matrices whose exponentials are the transition matrices of N steps.

    Parameters
    ----------
    first, middle, last : ndarray, shape (N, n, n)
        A at the three :data:`GAUSS_POINTS` of each step, in 1/s.
    step : float
        In s.

    Returns
    -------
    ndarray, shape (N, n, n)
    """
    result = np.empty(middle.shape)
    for block in cache_blocks(middle):
        result[block] = _of_block(first[block], middle[block], last[block], step)
    return result


def _of_block(first: FloatArray, middle: FloatArray, last: FloatArray, step: float) -> FloatArray:
    mean = step * middle
    slope = np.sqrt(15.0) / 3.0 * step * (last - first)
    bow = 10.0 / 3.0 * step * (last - 2.0 * middle + first)
    turn = _commutator(mean, slope)
    twist = _commutator(mean, 2.0 * bow + turn) / -60.0
    outer = _commutator(turn - 20.0 * mean - bow, slope + twist)
    return np.asarray(mean + bow / 12.0 + outer / 240.0)


def _commutator(first: FloatArray, second: FloatArray) -> FloatArray:
    return first @ second - second @ first
