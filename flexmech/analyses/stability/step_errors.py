"""How far the steps of a turn, or round-off where none are needed, put multipliers off."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from flexmech.analyses.stability.exponents import wrapped
from flexmech.analyses.stability.kept_modes import KeptModes, matched
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage
from flexmech.dynamical_systems import SampledPeriodicSystem, floquet_modes
from flexmech.types import FloatArray


def step_error(moving: VibratingLinkage, modes: KeptModes, damping: float) -> FloatArray:
    """Change of the logarithms of multipliers (k,) when the steps are halved in number.

    Steps solve a constant system exactly. What is left is the round-off of its eigenvalues:
    machine precision times the matrix's norm, the condition of the eigenvalue and the time of a
    turn (G. H. Golub & C. F. Van Loan, Matrix Computations, section 7.2.2).

    Parameters
    ----------
    moving : VibratingLinkage
    modes : KeptModes
        Found with all steps.
    damping : float
        Factor on the damping, with which they were found.

    Returns
    -------
    ndarray, shape (k,)
    """
    system = moving.system(damping)
    if system.is_constant:
        return _round_off(system, modes)
    coarse = floquet_modes(system, modes.steps // 2)
    log, other = modes.exponent * modes.period, coarse.exponent * coarse.period
    gap = log - other[matched(log, other)]
    return np.hypot(gap.real, wrapped(gap.imag))


def _round_off(system: SampledPeriodicSystem, modes: KeptModes) -> FloatArray:
    """Of the logarithms of a constant system's multipliers, (k,)."""
    matrix = system.matrices(1, 0.0)[0]
    values, left, right = scipy.linalg.eig(matrix, left=True, right=True)
    cosine = np.abs(np.einsum("in,in->n", left.conj(), right))
    size = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0)
    error = np.finfo(float).eps * np.linalg.norm(matrix, 2) * size / cosine * system.period
    nearest = np.abs(modes.exponent[:, None] - values).argmin(axis=1)
    return np.asarray(error[nearest])
