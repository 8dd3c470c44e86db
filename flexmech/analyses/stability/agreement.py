"""How far two engines' stability maps differ, and whether their errors explain it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy.optimize
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.remarks import speed_text
from flexmech.analyses.stability.words import edge_error
from flexmech.analyses.trust import EngineDifference
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si


def verdict(dataset: xr.Dataset) -> str:
    """How far two engines' multipliers and band edges differ; or that only one ran."""
    names = [str(name) for name in dataset["engine"].values]
    if len(names) < 2:
        return f"engines: no comparison was made, only the {names[0]} engine ran"
    moduli = np.exp(np.sort(dataset["log_modulus"].values[:2], axis=-1))
    apart = np.abs(moduli[1] - moduli[0])
    if not np.isfinite(apart).any():
        return "engines: no comparison is possible, at no speed have both a result"
    unit, place = speed_unit(dataset), int(np.nanargmax(np.nan_to_num(apart).max(axis=-1)))
    where = speed_text(dataset["crank_speed"][place], unit)
    return (
        f"engines: moduli of {names[0]} and {names[1]} differ by at most "
        f"{float(np.nanmax(apart)):.1e}, at {where} {unit}; "
        f"{_edges_apart(dataset, names, unit)}{theory_reason(dataset.attrs)}"
    )


def engine_difference(dataset: xr.Dataset) -> EngineDifference | None:
    """That of two engines' edges of bands which their errors explain least.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a map.

    Returns
    -------
    EngineDifference or None
        Not a number where one engine has a band that the other has not; None where there is
        nothing to compare.
    """
    names = [str(name) for name in dataset["engine"].values]
    if len(names) < 2:
        return None
    pairs, alone = _pairs_of_bands(dataset, names)
    if alone:
        return EngineDifference(math.nan, math.nan)
    apart, allowed = [], []
    for one, two in pairs:
        for edge in ("lower", "upper"):
            first, second = (float(band[f"band_{edge}"]) for band in (one, two))
            error = edge_error(one, edge) + edge_error(two, edge)
            # Where the range of speeds cuts a band, nothing is known of its edge.
            if math.isfinite(error):
                apart.append(abs(second / first - 1))
                allowed.append(abs(error / first))
    return EngineDifference.least_explained(apart, allowed) if apart else None


def disagreement(dataset: xr.Dataset) -> list[str]:
    """What two engines do not agree on, beyond their errors; empty where they agree.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a map.
    """
    found = engine_difference(dataset)
    if theory_reason(dataset.attrs) or found is None or not found.worth_a_warning:
        return []
    return [verdict(dataset)]


def _pairs_of_bands(
    dataset: xr.Dataset, names: Sequence[str]
) -> tuple[list[tuple[xr.Dataset, xr.Dataset]], int]:
    """Bands of two engines that overlap most, and how many bands have no other.

    A name may be certain for one engine alone; where a band lies is known for both.
    """
    first, second = (
        [dataset.isel(band=n) for n in np.flatnonzero(dataset["band_engine"].values == name)]
        for name in names[:2]
    )
    ends = [
        np.array([np.sort((one["band_lower"], one["band_upper"])) for one in own]).reshape(-1, 2)
        for own in (first, second)
    ]
    shared = np.minimum(ends[0][:, None, 1], ends[1][:, 1]) - np.maximum(
        ends[0][:, None, 0], ends[1][:, 0]
    )
    places = scipy.optimize.linear_sum_assignment(-np.maximum(shared, 0.0))
    pairs = [(first[a], second[b]) for a, b in zip(*places, strict=True) if shared[a, b] > 0]
    return pairs, len(first) + len(second) - 2 * len(pairs)


def _edges_apart(dataset: xr.Dataset, names: Sequence[str], unit: str) -> str:
    """How far edges of bands that overlap are apart, and how many bands have no other."""
    pairs, alone = _pairs_of_bands(dataset, names)
    if not pairs and not alone:
        return "neither has an unstable band"
    without = f"{alone} band{'' if alone == 1 else 's'} without a counterpart"
    if not pairs:
        return without
    widest = max(
        abs(float(one[f"band_{edge}"]) - float(two[f"band_{edge}"]))
        for one, two in pairs
        for edge in ("lower", "upper")
    )
    said = f"edges of bands by at most {abs(from_si(widest, unit)):.2g} {unit}"
    return f"{said}, {without}" if alone else said
