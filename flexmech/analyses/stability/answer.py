"""What a stability map answers: which crank speeds shake the linkage up, and what calms them.

How far two engines' stability maps differ, and whether their errors explain it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy.optimize
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.digits import Quantity
from flexmech.analyses.stability import words
from flexmech.analyses.stability.words import edge_error, greatest_step, is_known, within
from flexmech.analyses.summary import EngineDifference, speed_text, trust_line
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


# Digits of damping ratios and growth rates.
_DIGITS = 3


def answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Whether a vibration grows at the operating speed, where it does, and how fast.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    tuple of str
    """
    bands = _first_bands(dataset)
    if not bands.sizes["band"]:
        [line] = words.avoid_lines(dataset)
        if line.startswith("avoid: "):
            line = f"No vibration is found to grow{within(dataset)}."
        return (*_at_operating_speed(dataset, bands), line, *_missed(dataset), *_about(dataset))
    unit, count = speed_unit(dataset), bands.sizes["band"]
    fastest = bands.isel(band=int(bands["band_largest_growth_rate"].values.argmax()))
    rate = float(fastest["band_largest_growth_rate"])
    where = words.band_range(fastest, unit)
    many = "one band" if count == 1 else f"{count} bands"
    lines = [
        f"A vibration grows in {many} of speeds{within(dataset)}, fastest at {where}, with "
        f"{rate:.{_DIGITS}g} 1/s."
    ]
    ratios = bands["band_closing_damping_ratio"].values
    if np.isfinite(ratios).all():
        closed = "it" if count == 1 else "all that were found"
        lines.append(f"A damping ratio of {100 * ratios.max():.{_DIGITS}g} % closes {closed}.")
    return (*_at_operating_speed(dataset, bands), *lines, *_missed(dataset), *_about(dataset))


def _about(dataset: xr.Dataset) -> list[str]:
    """Which motion vibrations are about, where it is not the one that runs."""
    level = dataset.attrs["prestress"]
    if level == "trajectory":
        return []
    if level != "equilibrium":
        return [
            "These are vibrations about straight links; about the motion itself, which --prestress "
            "trajectory finds, others may grow."
        ]
    distance, unit = float(dataset.attrs["motion_distance"]), speed_unit(dataset)
    speed = f"{speed_text(float(dataset['crank_speed'][-1]), unit)} {unit}"
    far = f"up to {100 * distance:.2g} % of its greatest deflection from it at {speed}"
    if not math.isfinite(distance):
        far = f"not known at {speed} by linear equations"
    return [
        f"These are vibrations about the quasi-static equilibrium; the periodic motion is {far}, "
        "and about that, which --prestress trajectory finds, others may grow."
    ]


def _missed(dataset: xr.Dataset) -> list[str]:
    """What the steps in speed may not see."""
    step = greatest_step(dataset, str(dataset["engine"].values[0]))
    if not step:
        return []
    modes = dataset.sizes["multiplier"] // 2
    return [
        f"A band between two speeds that were solved for, at most {step} apart, can be missed, "
        f"above all one with a mode above the lowest {modes}: smaller steps and more modes see "
        "more."
    ]


def _first_bands(dataset: xr.Dataset) -> xr.Dataset:
    """Bands of the first engine."""
    first = str(dataset["engine"].values[0])
    return dataset.isel(band=np.flatnonzero(dataset["band_engine"].values == first))


def _at_operating_speed(dataset: xr.Dataset, bands: xr.Dataset) -> list[str]:
    """Whether the greatest operating speed among those mapped lies in a band; or nothing."""
    named = [float(speed) for speed in str(dataset.attrs.get("operating_speeds", "")).split()]
    low, high = np.sort(dataset["crank_speed"].values[[0, -1]])
    inside = [speed for speed in named if low <= speed <= high]
    if not inside:
        return []
    speed, unit = max(inside, key=abs), speed_unit(dataset)
    name = f"{speed_text(speed, unit)} {unit}"
    if not is_known(dataset, speed):
        return [f"Whether {name} is stable is not known: nothing was computed about it."]
    for number in range(bands.sizes["band"]):
        band = bands.isel(band=number)
        lower, upper = sorted((float(band["band_lower"]), float(band["band_upper"])))
        if lower <= speed <= upper:
            return [f"{name} is unstable: it lies in the band of {words.band_range(band, unit)}."]
    return [f"{name} is in no unstable band that was found."]


def numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Edges of the bands of the first engine in the user's unit, with their errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    tuple of Quantity
        ``unstable_from`` and ``unstable_to``; of an edge that the range of speeds cuts no error
        is known.
    """
    bands, unit, found = _first_bands(dataset), speed_unit(dataset), list[Quantity]()
    for number in range(bands.sizes["band"]):
        band = bands.isel(band=number)
        for name, edge in (("from", "lower"), ("to", "upper")):
            value = from_si(float(band[f"band_{edge}"]), unit)
            error = abs(from_si(words.edge_error(band, edge), unit))
            found.append(Quantity(f"unstable_{name}", value, unit, error, words.short_name(band)))
    return tuple(found)


def trust(dataset: xr.Dataset) -> str:
    """How far the edges of bands are known, and whether the engines agree.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    str
        With a clause for each error that could not be told.
    """
    return "; ".join((_known(dataset), *words.unknown_error_lines(dataset)))


def _known(dataset: xr.Dataset) -> str:
    """How far edges, or without any the multipliers, are known; and whether the engines agree."""
    names = [str(name) for name in dataset["engine"].values]
    found = numbers(dataset)
    known = [abs(one.error / one.value) for one in found if math.isfinite(one.error)]
    line = trust_line(names, max(known, default=math.nan), engine_difference(dataset))
    if known:
        return line.replace("numbers are", "edges of bands are", 1)
    error = float(np.nan_to_num(dataset["step_error"].values).max())
    ran = line.partition("; ")[2] or line
    return f"logarithms of multipliers are known to {error:.0e} by the steps; {ran}"
