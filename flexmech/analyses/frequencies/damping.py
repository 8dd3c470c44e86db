"""Damping of the modes of a frequency map: ranges over the turn, and their errors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity, percent, rounded
from flexmech.analyses.frequencies.flutter import flutters
from flexmech.analyses.summary import speed_text
from flexmech.plots.reading import speed_unit

# Headings of the damping of critical, by variable.
_HEADINGS = {"damping_ratio": "damping %", "strain_energy_damping": "strain-energy damping %"}
_CAUSES = ("discretisation", "reduction")
# Digits of a ratio whose error is not known, and a ratio in percent that is round-off of none.
_DIGITS, _NOTHING = 3, 1e-9


def variables_of(dataset: xr.Dataset) -> tuple[str, ...]:
    """Variables of the damping that a map has; none where nothing is damped.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.

    Returns
    -------
    tuple of str
        ``damping_ratio`` of Kelvin-Voigt damping, dampers and follower forces,
        ``strain_energy_damping``.
    """
    # Ratios of undamped links are there too, and have no errors.
    damped = {
        "damping_ratio": "damping_ratio_reduction_error" in dataset,
        "strain_energy_damping": "strain_energy_damping" in dataset,
    }
    return tuple(name for name, is_there in damped.items() if is_there)


def error_of_damping(dataset: xr.Dataset, variable: str) -> xr.DataArray:
    """Error of a damping ratio by mesh and component modes, greatest of a turn.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.
    variable : {"damping_ratio", "strain_energy_damping"}

    Returns
    -------
    xarray.DataArray
        Over (engine, crank_speed, mode); not a number in results of before it was estimated.
    """
    names = [f"{variable}_{cause}_error" for cause in _CAUSES]
    known = [dataset[name].max("check_angle") for name in names if name in dataset]
    if not known:
        return np.nan * dataset["discretisation_error"].max("check_angle")
    return sum(known[1:], start=known[0])


def damping_range(dataset: xr.Dataset, variable: str) -> xr.Dataset:
    """Lowest and highest damping ratio over the crank angles, and its error, in percent.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.
    variable : {"damping_ratio", "strain_energy_damping"}

    Returns
    -------
    xarray.Dataset
        ``lowest``, ``highest`` and ``error`` over (engine, crank_speed, mode).
    """
    ratio = 100 * dataset[variable]
    return xr.Dataset(
        {
            "lowest": ratio.min("crank_angle"),
            "highest": ratio.max("crank_angle"),
            "error": 100 * error_of_damping(dataset, variable),
        }
    )


def headings(dataset: xr.Dataset) -> tuple[str, ...]:
    """Headings of the columns of :func:`cells`."""
    return tuple(text for name in variables_of(dataset) for text in (_HEADINGS[name], "to %"))


def caption(dataset: xr.Dataset) -> str:
    """Meaning of the columns of damping; empty where there are none."""
    by = {
        "damping_ratio": f"by {dataset.attrs.get('damped_by', 'Kelvin-Voigt')}",
        "strain_energy_damping": "by modal strain energy",
    }
    said = [f"{_HEADINGS[name].removesuffix(' %')}: {by[name]}" for name in variables_of(dataset)]
    return f"{'; '.join(said)}; ratio to critical damping over the turn" if said else ""


def cells(dataset: xr.Dataset, engine: str, speed: float, mode: int, *, both: bool) -> list[str]:
    """Least and greatest damping ratio of a mode in percent, with the digits that are known.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.
    engine : str
    speed : float
        Crank speed in rad/s.
    mode : int
        Counted from 1.
    both : bool
        Whether the row is of all engines, so that their difference counts as an error.

    Returns
    -------
    list of str
        Two for each variable of :func:`variables_of`.
    """
    texts = []
    for name in variables_of(dataset):
        every = damping_range(dataset, name).sel(crank_speed=speed, mode=mode)
        of_engine = every.sel(engine=engine)
        for end in ("lowest", "highest"):
            apart = float(abs(every[end] - of_engine[end]).max()) if both else 0.0
            texts.append(
                percent_text(float(of_engine[end]), np.fmax(float(of_engine["error"]), apart))
            )
    return texts


def percent_text(value: float, error: float) -> str:
    """A damping ratio in percent as text; zero where it is the round-off of none."""
    if abs(value) < _NOTHING:
        return "0"
    return rounded(value, error) if error > 0 else rounded(value, error, most=_DIGITS)


def numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Least and greatest damping ratio of each mode at each speed, by the first engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.

    Returns
    -------
    tuple of Quantity
    """
    unit, quantities = speed_unit(dataset), list[Quantity]()
    for name in variables_of(dataset):
        first = damping_range(dataset, name).isel(engine=0)
        for speed in dataset["crank_speed"].values:
            for mode in dataset["mode"].values.tolist():
                at_speed = first.sel(crank_speed=speed, mode=mode)
                of = f"mode {mode} at {speed_text(speed, unit)} {unit}"
                quantities += [
                    Quantity(
                        f"{end}_{name}", float(at_speed[end]), "%", float(at_speed["error"]), of
                    )
                    for end in ("lowest", "highest")
                ]
    return tuple(quantities)


def trust(dataset: xr.Dataset) -> str:
    """How far damping ratios are known, to follow what is said of frequencies; may be empty."""
    said = ""
    for name in variables_of(dataset):
        extremes = damping_range(dataset, name)
        size = np.fmax(abs(extremes["lowest"]), abs(extremes["highest"]))
        worst = float((extremes["error"] / size).where(size > _NOTHING).max())
        if np.isfinite(worst):
            said += f"; {_HEADINGS[name].removesuffix(' %')} to {percent(worst)} of it"
    return said


def error_quantities(dataset: xr.Dataset) -> Iterator[Quantity]:
    """Greatest errors of the damping ratio of each mode by mesh and component modes.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.

    Yields
    ------
    Quantity
        In percent of the ratio.
    """
    if "damping_ratio" not in variables_of(dataset):
        return
    at_checks = abs(dataset["damping_ratio"].sel(crank_angle=dataset["check_angle"]))
    for cause in _CAUSES:
        shares = 100 * dataset[f"damping_ratio_{cause}_error"] / at_checks
        for mode in dataset["mode"].values:
            share, of = float(shares.sel(mode=mode).max()), f"mode {mode}"
            yield Quantity(f"{cause} error of the damping ratio", share, "%", of=of)


def damping_lines(dataset: xr.Dataset) -> list[str]:
    """Negative damping ratios of frozen positions, and what of strain-energy damping is unknown."""
    lines, kinds = [], variables_of(dataset)
    if "damping_ratio" in kinds:
        lines += _negative_lines(dataset)
    if "strain_energy_damping" in kinds:
        lines += _strain_energy_lines(dataset)
    return lines


def _negative_lines(dataset: xr.Dataset) -> list[str]:
    ratio = dataset["damping_ratio"]
    moving = ratio.where(ratio["crank_speed"] != 0)
    by_frames = dataset.attrs.get("rotation_terms", "off") != "off" and float(moving.min()) < 0
    if not by_frames or flutters(dataset):
        return []
    return [
        "damping ratio: turning link frames may make it negative in a frozen position; that is no "
        "instability, and `flexmech stability` shows whether vibrations grow"
    ]


def _strain_energy_lines(dataset: xr.Dataset) -> list[str]:
    ratio, said = dataset["strain_energy_damping"], []
    if ratio.sizes["engine"] > 1:
        apart = float(abs(ratio - ratio.isel(engine=0, drop=True)).max())
        said.append(f"engines differ by at most {apart:.1e}")
    if ratio.attrs.get("links_without_data"):
        said.append(
            f"no specific damping is known of {ratio.attrs['links_without_data']}; taken as "
            "without loss"
        )
    return [f"damping by modal strain energy: {text}" for text in said]
