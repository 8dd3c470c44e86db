"""What forces on some coordinates of a link move where the others are held."""

from __future__ import annotations

import numpy as np
from scipy.sparse.linalg import splu

from flexmech.linear_system.chains import ChainMatrix, LinkMatrix, whole
from flexmech.types import FloatArray, IntArray

# Of the forces that are answered at a time where all of them would fill a whole matrix.
AT_A_TIME = 64


class Flexibility:
    """Inverse of a stiffness matrix with some coordinates held.

    Of a chain of elements it is never made: its factors are as narrow as the matrix itself.

    Parameters
    ----------
    stiffness : ndarray or ChainMatrix, shape (n, n)
    free : ndarray of int, shape (i,)
        Ascending coordinates that are not held.
    """

    def __init__(self, stiffness: LinkMatrix, free: IntArray) -> None:
        self.free = free
        self._factors = self._inverse = None
        if isinstance(stiffness, ChainMatrix) and len(free):
            self._factors = splu(stiffness.sparse()[free][:, free].tocsc())
        else:
            self._inverse = np.linalg.inv(whole(stiffness)[free[:, None], free])

    def answers(self, forces: FloatArray) -> FloatArray:
        """Displacements (i, k) by forces (i, k) on the free coordinates."""
        if self._factors is not None:
            return np.asarray(self._factors.solve(np.ascontiguousarray(forces)))
        assert self._inverse is not None
        return self._inverse @ forces

    def trace_with(self, matrix: LinkMatrix) -> float:
        """Trace of the product with a symmetric matrix (n, n) in the same coordinates."""
        free, total = self.free, 0.0
        for first in range(0, len(free), AT_A_TIME):
            unit = np.zeros((len(matrix), len(free[first : first + AT_A_TIME])))
            unit[free[first : first + AT_A_TIME], np.arange(unit.shape[1])] = 1.0
            moved = self.answers((matrix @ unit)[free])
            total += float(np.trace(moved[first : first + AT_A_TIME]))
        return total
