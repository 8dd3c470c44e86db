"""Krein signatures: which Floquet multipliers of an undamped system can leave the unit circle.

A multiplier of a Hamiltonian system leaves the unit circle only where it meets another one, and
only if the two have opposite signatures (V. A. Yakubovich & V. M. Starzhinskii, Linear
Differential Equations with Periodic Coefficients, Wiley 1975, chapter III). Where the Hamilton
function is positive definite, the signature is the sign of the frequency: the multiplier of
``f_a`` then meets an opposite one in that of ``-f_b`` alone, so that sums of frequencies can be
unstable and differences cannot.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.types import FloatArray


def krein_signature(shapes: NDArray[np.complex128]) -> FloatArray:
    """Krein signature of Floquet modes in canonical coordinates ``x = (y, p)``.

    It is ``x^H i J x / x^H x`` with ``J x' = H x``, so with ``J = [0, -1; 1, 0]``, and is the same
    at all times but for the size of x. A mode of a constant system with positive energy has the
    sign of its frequency.

    Parameters
    ----------
    shapes : ndarray of complex, shape (..., 2 m, k)
        Modes in columns, y before p.

    Returns
    -------
    ndarray, shape (..., k)
        Between -1 and 1; zero where the multiplier is not on the unit circle. Of modes that share
        a multiplier it is that of the vectors given, not of the multiplier.
    """
    half = shapes.shape[-2] // 2
    y, p = shapes[..., :half, :], shapes[..., half:, :]
    size = (np.abs(shapes) ** 2).sum(axis=-2)
    return np.asarray(2 * (y.conj() * p).imag.sum(axis=-2) / size, dtype=float)
