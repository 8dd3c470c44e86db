"""Crank angles at which a quantity that moves with the crank is looked at over a turn."""

from __future__ import annotations

import numpy as np

from flexmech.types import FloatArray

ANGLES = 24
"""Every 15 degrees: natural frequencies move slowly enough for bounds to be told by these."""


def sampled_turn(start_angle: float = 0.0) -> FloatArray:
    """Evenly spaced crank angles of a turn in rad, shape (24,); its end is left out."""
    return np.asarray(start_angle + np.linspace(0.0, 2 * np.pi, ANGLES, endpoint=False))


def without_end(crank_angles: FloatArray) -> FloatArray:
    """Increasing angles of a full turn without its end, which is its start again.

    Parameters
    ----------
    crank_angles : ndarray, shape (A,)
        In rad.

    Returns
    -------
    ndarray
        The first angles, A or one less.
    """
    before_end = crank_angles < crank_angles[0] + 2 * np.pi * (1 - 1e-9)
    return np.asarray(crank_angles[before_end], dtype=float)
