"""What a stability map answers: which crank speeds shake the linkage up, and what calms them."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity
from flexmech.analyses.remarks import speed_text
from flexmech.analyses.stability import words
from flexmech.analyses.stability.agreement import engine_difference
from flexmech.analyses.stability.searched import greatest_step, is_known, within
from flexmech.analyses.trust import trust_line
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si

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
