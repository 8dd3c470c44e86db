"""Branches of natural frequencies: which modes share a panel, and lines along a branch."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.types import FloatArray

__all__ = ["MAP", "branch_lines", "contiguous_runs", "mode_groups"]

MAP = ("engine", "crank_speed", "crank_angle", "mode")
"""Dimensions of what is known of each mode, in the order in which it is drawn."""

# Two modes whose bands are this close in ratio can exchange branches; modes further apart
# only seem to, where the crank angles are too coarse to follow a branch.
NEAR_BANDS = 1.1


def mode_groups(dataset: xr.Dataset) -> list[list[int]]:
    """Modes that share a panel: neighbours between which a tracked branch passes.

    Frequencies sorted at each angle keep to one panel a mode until two branches cross or
    veer; then the branch is what a reader follows, and both modes belong in one panel.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency`` and ``branch_of_mode``, sorted by crank angle.

    Returns
    -------
    list of list of int
        Positions along the mode dimension, ascending.
    """
    branch = dataset["branch_of_mode"].transpose(*MAP).values
    frequency = dataset["frequency"].transpose(*MAP).values
    before, after = branch[:, :, :-1], branch[:, :, 1:]
    highest, lowest = np.nanmax(frequency, axis=2), np.nanmin(frequency, axis=2)
    near = np.any(lowest[..., 1:] <= NEAR_BANDS * highest[..., :-1], axis=(0, 1))
    n_modes = frequency.shape[-1]
    joined = np.zeros(n_modes, dtype=bool)
    for low in range(n_modes):
        for high in range(low + 1, n_modes):
            rises = np.any(before[..., low] == after[..., high])
            falls = np.any(before[..., high] == after[..., low])
            if (rises or falls) and np.all(near[low:high]):
                joined[low:high] = True
    cuts = np.flatnonzero(~joined[:-1]) + 1
    return [group.tolist() for group in np.split(np.arange(n_modes), cuts)]


def branch_lines(values: FloatArray, branch: FloatArray) -> dict[int, FloatArray]:
    """Values along each branch over the angles; not a number where the branch is elsewhere.

    Parameters
    ----------
    values, branch : ndarray, shape (crank_angle, mode)
        Values of some modes, and the numbers of their branches.

    Returns
    -------
    dict of int to ndarray, shape (crank_angle,)
    """
    lines = {}
    for number in np.unique(branch):
        here = branch == number
        along = np.where(here, values, 0.0).sum(axis=1)
        lines[int(number)] = np.where(here.any(axis=1), along, np.nan)
    return lines


def contiguous_runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last position of each unbroken run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(start), int(stop) - 1) for start, stop in edges.reshape(-1, 2)]
