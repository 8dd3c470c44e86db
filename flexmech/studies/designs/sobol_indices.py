"""Sobol's indices of sampled outputs: the share of every input in their variance.

Saltelli et al. 2010, *Computer Physics Communications* 181, 259-270, table 2 (b) and (f), with
intervals by the bootstrap (Efron 1987, *Journal of the American Statistical Association* 82,
171-185, BCa).
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import scipy
import xarray as xr

from flexmech.arrays import FloatArray

CONFIDENCE = 0.95
"""Of the intervals."""
INDICES = ("first_order", "total")
"""Of every input: alone, and with what it does together with others."""

_RESAMPLES = 1000
# Of the outputs' size: what never changes has no variance to share.
_CHANGES = 1e-12
# Shares of the variance that are not known to this part of it say little about which input matters.
_POOR = 0.2


def sobol_shares(
    values: FloatArray, outputs: list[str], inputs: list[str], seed: int
) -> xr.Dataset:
    """Sobol's indices with their intervals over (output, input).

    Parameters
    ----------
    values : ndarray, shape (d + 2, n, m)
        Outputs of the samples A, B and A_B of each of d inputs.
    outputs, inputs : list of str
        m and d names.
    seed : int
        Of the resamples.

    Returns
    -------
    xarray.Dataset
        ``first_order`` and ``total`` with ``_low`` and ``_high`` ends; of outputs that never change
        not numbers, of inputs that change nothing zero.
    """
    parts = np.moveaxis(values, -1, 1)
    whole = values.reshape(-1, len(outputs))
    varies = np.ptp(whole, axis=0) > _CHANGES * np.abs(whole).max(axis=0)
    shape = len(outputs), len(inputs)
    found: dict[str, Any] = {
        f"{name}{end}": np.full(shape, np.nan) for name in INDICES for end in ("", "_low", "_high")
    }
    if varies.any():
        first, second, mixed = parts[0, varies], parts[1, varies], parts[2:, varies]
        mean = np.stack([first, second]).mean(axis=(0, 2))[:, None]
        first, second, mixed = first - mean, second - mean, mixed - mean

        def estimates(sample: Any) -> FloatArray:
            return _estimates(first[..., sample], second[..., sample], mixed[..., sample])

        with np.errstate(invalid="ignore", divide="ignore"), warnings.catch_warnings():
            # Of an input that changes nothing there is no interval: its share is zero.
            warnings.simplefilter("ignore", scipy.stats.DegenerateDataWarning)
            interval = scipy.stats.bootstrap(
                [np.arange(first.shape[1])],
                estimates,
                n_resamples=_RESAMPLES,
                confidence_level=CONFIDENCE,
                random_state=np.random.default_rng(seed),
            ).confidence_interval
        changes = (mixed != first).any(axis=-1).T
        estimated = estimates(np.arange(first.shape[1]))
        for end, both in (("", estimated), ("_low", interval.low), ("_high", interval.high)):
            for name, each in zip(INDICES, both, strict=True):
                found[f"{name}{end}"][varies] = np.where(changes, each, 0.0)
    over = ("output", "input")
    return xr.Dataset(
        {name: (over, each) for name, each in found.items()}, {"output": outputs, "input": inputs}
    )


def _estimates(first: FloatArray, second: FloatArray, mixed: FloatArray) -> FloatArray:
    """First-order and total indices, (2, m, d).

    Parameters
    ----------
    first, second : ndarray, shape (m, n)
        Outputs at A and B.
    mixed : ndarray, shape (d, m, n)
        At A_B of each input.
    """
    variance = np.var(np.stack([first, second]), axis=(0, -1))
    alone = (second * (mixed - first)).mean(axis=-1) / variance
    total = ((first - mixed) ** 2).mean(axis=-1) / (2 * variance)
    return np.moveaxis(np.stack([alone, total]), 1, 2)


def share_text(share: xr.Dataset, name: str) -> str:
    """Total share of an input in words, in percent of the variance.

    An interval where it is known to little, and no more than all: estimates scatter about it.

    Parameters
    ----------
    share : xarray.Dataset
        Of one output.
    name : str
        Of the input.

    Returns
    -------
    str
    """
    one = share.sel(input=name)
    value, low, high = (float(one[f"total{end}"]) for end in ("", "_low", "_high"))
    within = 100 * np.clip([value, low, high], 0.0, 1.0)
    if high - low > 2 * _POOR:
        return f"{within[1]:.0f} to {within[2]:.0f} % of the variance"
    return f"{within[0]:.0f} % of the variance"


def poor_shares(data: xr.Dataset, samples: int) -> tuple[str, ...]:
    """A warning where shares are known to little, with how many samples would do.

    Parameters
    ----------
    data : xarray.Dataset
        Of :func:`sobol_shares`, or without shares.
    samples : int
        N of the study.

    Returns
    -------
    tuple of str
        Empty where shares are known.
    """
    if "total" not in data:
        return ()
    widths = np.stack([(data[f"{name}_high"] - data[f"{name}_low"]).values for name in INDICES]) / 2
    apart = float(widths[np.isfinite(widths)].max(initial=0.0))
    if apart <= _POOR:
        return ()
    # Intervals shrink with the root of the number.
    enough = 1 << math.ceil(math.log2(samples * (apart / _POOR) ** 2))
    return (
        f"{samples} samples are few: shares of the variance are known to {100 * apart:.0f} % of it "
        f"alone, and their estimates may add up to more than all; take --samples {enough}",
    )
