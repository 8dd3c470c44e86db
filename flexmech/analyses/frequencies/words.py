"""A frequency map in words: the table of extremes and the lines below it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.frequencies import damping
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.analyses.requests import fewer_modes_lines
from flexmech.analyses.summary import Table, speed_text
from flexmech.plots.reading import speed_unit

# Most decimals of a frequency in Hz: more are not known of any model, however fine its mesh is.
MOST_DECIMALS = 6
# Most digits of frequencies in the table.
_MOST_DIGITS = 8
# Frequency in Hz below which the free shaft's mode is a rigid one: at rest it is zero but for the
# root of round-off, and what takes a quarter of an hour is no vibration.
RIGID = 1e-3
# What stands for the engines where they agree.
TOGETHER = ("both", "all")


def extremes_table(extremes: xr.Dataset, dataset: xr.Dataset, title: str) -> Table:
    """Lowest and highest frequency of each mode, the crank angles of both, and its damping.

    Frequencies have as many digits as their errors by mesh and component modes, and the
    difference of engines that agree, leave known.

    Parameters
    ----------
    extremes : xarray.Dataset
        ``lowest``, ``lowest_angle``, ``highest``, ``highest_angle`` over (engine,
        crank_speed, mode); Hz and rad.
    dataset : xarray.Dataset
        Dataset of the map, with the errors.
    title : str

    Returns
    -------
    Table
        One row for each speed and mode where the engines agree within their errors, and one for
        each engine where they do not.
    """
    unit = speed_unit(dataset)
    error = known_error(dataset)
    between = "lowest_frequency" in dataset

    def row(engine: Any, label: str, speed: float, mode: int) -> tuple[str, ...]:
        where = {"engine": engine, "crank_speed": speed, "mode": mode}
        place, relative = extremes.sel(where), float(error.sel(where))
        here, both = {"crank_speed": speed, "mode": mode}, label != engine
        cells = [label, speed_text(speed, unit), str(mode)]
        for extreme in ("lowest", "highest"):
            angle = place[f"{extreme}_angle"]
            value = float(place[extreme])
            engines_apart = float(abs(extremes[extreme].sel(here) - value).max()) if both else 0.0
            known = max(value * relative, engines_apart)
            cells.append(rounded(value, known, most=_MOST_DIGITS))
            cells.append(f"{np.degrees(float(angle)):.1f}" if between else _degrees(angle))
        return (*cells, *damping.cells(dataset, engine, speed, mode, both=both))

    engines = [str(engine) for engine in extremes["engine"].values]
    groups = []
    for speed in extremes["crank_speed"].values:
        here = {"crank_speed": speed}
        shown = [(engine, engine) for engine in engines]
        if len(engines) > 1 and _engines_agree(extremes.sel(here), error.sel(here)):
            sharpest = engines[int(error.sel(here).max("mode").argmin("engine"))]
            shown = [(sharpest, TOGETHER[len(engines) > 2])]
        groups += [
            tuple(row(engine, label, speed, mode) for mode in extremes["mode"].values)
            for engine, label in shown
        ]
    headings = (
        *("engine", unit, "mode", "lowest Hz", "at deg", "highest Hz", "at deg"),
        *damping.headings(dataset),
    )
    return Table(title, headings, tuple(groups), caption=damping.caption(dataset))


def _engines_agree(extremes: xr.Dataset, error: xr.DataArray) -> bool:
    """Whether extremes of all engines differ by no more than their errors together.

    Parameters
    ----------
    extremes : xarray.Dataset
        ``lowest`` and ``highest`` in Hz, over engine and others.
    error : xarray.DataArray
        Relative, over the same.
    """
    first, errors = extremes.isel(engine=0), error.isel(engine=0) + error + 10.0**-MOST_DECIMALS
    apart = (abs(extremes[name] / first[name] - 1) for name in ("lowest", "highest"))
    return all(bool((each <= errors).all()) for each in apart)


def counted_lines(dataset: xr.Dataset) -> list[str]:
    """How many modes, lumped masses and rotation terms there are, where not the usual ones."""
    lines = [*fewer_modes_lines(dataset.attrs), *filter(None, [plots.terms_text(dataset)])]
    lumps = int(dataset.attrs.get("lumped_masses", 0))
    if lumps:
        lines.append(
            f"mass: {lumps} lumped masses in the reference engine replace distributed mass"
        )
    return lines


# Errors of frequencies over themselves, in words.
_ERRORS = {
    "discretisation_error": "discretisation error",
    "reduction_error": "reduction error",
    "lumping_error": "error of lumped masses",
}


def error_quantities(dataset: xr.Dataset, effect: xr.DataArray | None) -> Iterator[Quantity]:
    """Greatest error of each engine by mesh, component modes and lumped masses, and where.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of the map in one state.
    effect : xarray.DataArray or None
        Relative change of the frequencies by vibration, where the running states were asked for.

    Yields
    ------
    Quantity
        In percent of the frequency; those that are unknown are left out.
    """
    values = {words: dataset[name] for name, words in _ERRORS.items() if name in dataset}
    if effect is not None:
        values["change by vibration"] = effect
    for words, of_engines in values.items():
        for engine in dataset["engine"].values:
            of = of_engines.sel(engine=engine)
            if np.isfinite(of).any():
                place = of[_greatest(of)]
                where = f"{engine}, {_at(place, dataset)}"
                yield Quantity(words, 100 * float(place), "%", of=where)


def tracking_lines(dataset: xr.Dataset) -> list[str]:
    """Report veering, and branches that are unclear or not whole, where there are any."""
    veering, unclear, torn = [], [], []
    for engine in dataset["engine"].values:
        veering += _veering(dataset["veering"].sel(engine=engine).astype(bool), engine, dataset)
        for speed in dataset["crank_speed"].values:
            place = dataset.sel(engine=engine, crank_speed=speed)
            unclear += _unclear(place)
            torn += _torn_branches(place)
    lines = []
    if veering:
        lines.append(f"veering, where close modes swap their shapes: {'; '.join(veering)}")
    if unclear:
        lines.append(
            "branches uncertain even in the shortest steps between the angles: "
            + "; ".join(unclear)
        )
    if torn:
        lines.append(f"branches incomplete over these angles: {'; '.join(torn)}")
    return lines


def shaft_lines(dataset: xr.Dataset) -> list[str]:
    """Say what became of the free shaft's mode, where the shaft is free."""
    if "shaft_frequency" not in dataset:
        return []
    kinds = shaft_kind(dataset)
    lines = []
    if bool((kinds == "rigid").all()):
        return [
            f"rigid: the mode of the free shaft, below {RIGID:g} Hz in all positions; it is not "
            "counted among the modes"
        ]
    at_rest = (dataset["crank_speed"] == 0).values
    if at_rest.any() and bool((kinds.isel(crank_speed=at_rest) == "rigid").all()):
        lines.append(
            f"rigid: the mode of the free shaft, below {RIGID:g} Hz at rest; it is not counted "
            "among the modes"
        )
    moving = kinds.isel(crank_speed=~at_rest) if at_rest.any() else kinds
    counts = {kind: int((moving == kind).sum()) for kind in ("rigid", "oscillates", "diverges")}
    said = ", ".join(f"{kind} at {count}" for kind, count in counts.items() if count)
    highest = float(dataset["shaft_frequency"].max())
    growth = float(dataset["shaft_growth_rate"].max())
    lines.append(
        f"shaft: its mode, frozen at the crank angle, {said} of {moving.size} positions"
        f"{' at speed' if at_rest.any() else ''}; frequency at most {highest:.4g} Hz, growth rate "
        f"at most {growth:.4g} 1/s; it is not counted among the modes"
    )
    return lines


def shaft_kind(dataset: xr.Dataset) -> xr.DataArray:
    """Behaviour of the shaft's mode in each position.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a map whose shaft is free.

    Returns
    -------
    xarray.DataArray
        Over (engine, crank_speed, crank_angle): ``rigid`` below :data:`RIGID`, else
        ``oscillates`` or ``diverges``.
    """
    frequency, growth = dataset["shaft_frequency"], dataset["shaft_growth_rate"]
    kind = np.where(frequency.values > 0, "oscillates", "diverges")
    fastest = np.maximum(frequency.values, np.abs(growth.values) / (2 * np.pi))
    return frequency.copy(data=np.where(fastest < RIGID, "rigid", kind))


def _veering(flags: xr.DataArray, engine: str, dataset: xr.Dataset) -> list[str]:
    """Positions, modes and speeds of one engine's veering; empty without any."""
    positions = flags.any("mode")
    if not positions.any():
        return []
    speeds = flags["crank_speed"].values[positions.any("crank_angle").values]
    modes = flags["mode"].values[flags.any(["crank_speed", "crank_angle"]).values]
    unit = speed_unit(dataset)
    where = ", ".join(speed_text(speed, unit) for speed in speeds)
    return [
        f"{engine} at {int(positions.sum())} of {positions.size} positions "
        f"(modes {', '.join(map(str, modes))}; {where} {unit})"
    ]


def _unclear(place: xr.Dataset) -> list[str]:
    """Crank angles at which modes of one engine and speed could not be distinguished."""
    # Results of before this was looked at do not have it.
    if "branch_unclear" not in place or not place["branch_unclear"].any():
        return []
    flags, unit = place["branch_unclear"].astype(bool), speed_unit(place)
    modes = place["mode"].values[flags.any("crank_angle").values]
    angles = place["crank_angle"].values[flags.any("mode").values]
    return [
        f"{place['engine'].item()} at {speed_text(place['crank_speed'], unit)} {unit}, modes "
        f"{', '.join(map(str, modes))}, before {', '.join(map(_degrees, angles))} deg"
    ]


def _torn_branches(place: xr.Dataset) -> list[str]:
    """Branches of one engine and speed that are met there and not whole; empty without any."""
    branches = place["branch"].values
    met = np.isin(branches, place["branch_of_mode"].values)
    torn = branches[met & ~place["branch_whole"].values.astype(bool)]
    if not torn.size:
        return []
    unit = speed_unit(place)
    speed = speed_text(place["crank_speed"], unit)
    return [f"{place['engine'].item()} at {speed} {unit} ({', '.join(map(str, torn))})"]


def _greatest(values: xr.DataArray) -> dict[Any, Any]:
    """Indices of the greatest size, by dimension."""
    sizes = np.abs(values.values)
    place = np.unravel_index(int(np.nanargmax(sizes)), sizes.shape)
    return dict(zip(values.dims, place, strict=True))


def _at(place: xr.DataArray, dataset: xr.Dataset) -> str:
    """Where a value stands: its crank speed, crank angle and mode."""
    unit = speed_unit(dataset)
    angle = place["crank_angle" if "crank_angle" in place.coords else "check_angle"]
    return (
        f"{speed_text(place['crank_speed'], unit)} {unit}, {_degrees(angle)} deg, "
        f"mode {place['mode'].item()}"
    )


def _degrees(angle: Any) -> str:
    return f"{np.degrees(float(angle)):.6g}"
