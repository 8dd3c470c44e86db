"""Ratios of frequencies over laminates, cases and positions."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
import xarray as xr


def laminate_factors(frequency: xr.DataArray) -> xr.DataArray:
    """Factor s of each laminate against C1: geometric mean over cases and positions.

    Linear theory with one modulus and one density a laminate gives the same ratio of two
    laminates in every linkage and position: frequency = s(laminate) q(case, position).

    Parameters
    ----------
    frequency : DataArray
        Over ``laminate``, and ``position`` or ``case`` or both.

    Returns
    -------
    DataArray
        Over ``laminate`` and whatever other dimensions there are.
    """
    ratio = frequency / frequency.sel(laminate="C1")
    return geometric_mean(ratio, [d for d in frequency.dims if d in ("position", "case")])


def geometric_mean(values: xr.DataArray, dims: str | list[Hashable]) -> xr.DataArray:
    """Geometric mean over dimensions.

    Parameters
    ----------
    values : DataArray
        Positive.
    dims : str or list of str

    Returns
    -------
    DataArray
    """
    logarithm: xr.DataArray = xr.apply_ufunc(np.log, values)
    mean: xr.DataArray = xr.apply_ufunc(np.exp, logarithm.mean(dims))
    return mean


def separable_error(frequency: xr.DataArray) -> float:
    """Greatest deviation from a factor of the laminate times one of the rest, relative.

    Parameters
    ----------
    frequency : DataArray
        Over ``laminate`` and others.

    Returns
    -------
    float
    """
    whole = frequency.transpose("laminate", ...).values
    logarithm = np.log(whole.reshape(len(whole), -1))
    rest = logarithm - logarithm.mean(axis=0) - logarithm.mean(axis=1, keepdims=True)
    return float(np.abs(np.expm1(rest + logarithm.mean())).max())


def deviation_at_best_scale(computed: xr.DataArray, published: xr.DataArray) -> float:
    """Greatest relative deviation from published values, left by the scale that makes it least.

    With ratios of computed to published values from a to b that scale is 2 / (a + b), and
    what it leaves (b - a) / (a + b).

    Parameters
    ----------
    computed, published : DataArray
        Positive, of the same dimensions.

    Returns
    -------
    float
    """
    ratio = computed / published
    low, high = float(ratio.min()), float(ratio.max())
    return (high - low) / (high + low)
