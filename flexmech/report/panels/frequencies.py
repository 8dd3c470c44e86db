"""Moving natural frequencies, and damping ratios where links damp."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import MovingFrequencies, Table
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.arrays import FloatArray
from flexmech.plots.reading import degrees, names_of
from flexmech.report import panel
from flexmech.report.results import (
    Results,
    decimals_of,
    speed_name,
    speed_unit_of,
    state_of,
    with_error,
)
from flexmech.units import from_si

# Of an axis, and of what stands around all of them, in pixels.
AXIS_HEIGHT, FRAME_HEIGHT = 130, 110
STRESSES = {
    "none": "links without stress",
    "axial": "links under the axial forces of the rigid motion",
    "equilibrium": "links at the quasi-static equilibrium under the inertia forces",
    "trajectory": "links in the states of the running simulation",
}


def in_each_state(result: MovingFrequencies) -> dict[str, xr.Dataset]:
    """Datasets of a map by the state that they are of."""
    if result.states:
        return {name: result.state(name).dataset for name in result.states}
    return {state_of(result.dataset.attrs): result.dataset}


@panel.shows(MovingFrequencies)
def frequency_panel(result: MovingFrequencies, results: Results) -> panel.Panel:
    """Frequencies over crank angle, a plot for each mode, a line for each speed."""
    unit, attrs = speed_unit_of(results), result.dataset.attrs
    return panel.panel_of(
        "frequencies",
        result.summary(),
        plots=(_plot(result, unit, "frequency"),),
        readings=tuple(_readings(result, unit)),
        tables=_tables(result, unit),
        stress=STRESSES[str(attrs["prestress"])],
        terms="with" if attrs.get("rotation_terms") == "on" else "without",
    )


@panel.shows(MovingFrequencies)
def damping_panel(result: MovingFrequencies, results: Results) -> panel.Panel | None:
    """Damping ratios over crank angle, where any link damps."""
    variable = _damping_of(result.dataset)
    if not variable:
        return None
    lines = tuple(line for line in result.summary().lines if "damping" in line)
    plot = _plot(result, speed_unit_of(results), variable)
    return panel.panel_of("damping", None, variable, plots=(plot,), lines=lines)


def _damping_of(data: xr.Dataset) -> str:
    """Which damping ratio a map holds; empty where nothing damps."""
    if "strain_energy_damping" in data:
        return "strain_energy_damping"
    return "damping_ratio" if "damping_ratio_reduction_error" in data else ""


def _values(data: xr.Dataset, name: str, engine: str, speed: float, mode: int) -> FloatArray:
    one = data[name].sel(engine=engine, crank_speed=speed, mode=mode)
    return np.asarray(one.values, dtype=float)


def _places(result: MovingFrequencies) -> list[tuple[str, xr.Dataset, str, float, int]]:
    """State, its dataset, engine, speed and mode of every line."""
    return [
        (state, data, engine, float(speed), int(mode))
        for state, data in in_each_state(result).items()
        for engine in names_of(data, "engine")
        for mode in data["mode"].values
        for speed in data["crank_speed"].values
    ]


def _plot(result: MovingFrequencies, unit: str, variable: str) -> panel.Plot:
    modes = result.dataset["mode"].values.tolist()
    speeds = result.dataset["crank_speed"].values.tolist()
    words, factor = ("Frequency (Hz)", 1) if variable == "frequency" else ("Damping ratio (%)", 100)
    traces = [
        panel.Trace(
            *(speed_name(speed, unit), degrees(data["crank_angle"])),
            factor * _values(data, variable, engine, speed, mode),
            speeds.index(speed),
            ("solid", "dash", "dashdot", "dot")[speeds.index(speed) % 4],
            when={"engine": engine, "state": state},
            followed={"speed": speed_name(speed, unit)},
            axis=modes.index(mode),
            legend=mode == modes[0],
        )
        for state, data, engine, speed, mode in _places(result)
    ]
    return panel.over_angle(
        variable.replace("_", "-"),
        tuple(panel.YAxis(f"Mode {mode}") for mode in modes),
        traces,
        text=f"{words} of {len(modes)} modes against crank angle at {len(speeds)} crank speeds",
        height=FRAME_HEIGHT + AXIS_HEIGHT * len(modes),
        title=words,
    )


def _readings(result: MovingFrequencies, unit: str) -> list[panel.Reading]:
    """Frequency and damping ratio of each mode at the crank angle."""
    readings = []
    damping = _damping_of(result.dataset)
    for state, data, engine, speed, mode in _places(result):
        angle = degrees(data["crank_angle"])
        when: panel.Choice = {"engine": engine, "state": state, "speed": speed_name(speed, unit)}
        frequency = _values(data, "frequency", engine, speed, mode)
        relative = float(known_error(data).sel(engine=engine, crank_speed=speed, mode=mode))
        error = relative * float(np.nanmax(frequency))
        found = [("Natural frequency", "Hz", frequency, error)]
        if damping:
            ratio = 100 * _values(data, damping, engine, speed, mode)
            error = 100 * _damping_error(data, damping, engine, speed, mode)
            found.append(("Damping ratio", "%", ratio, error))
        for group, of, values, known in found:
            number = angle, values, known, when, decimals_of(known)
            readings.append(panel.Reading(group, f"mode {mode}", of, *number, str(mode)))
    return readings


def _damping_error(data: xr.Dataset, variable: str, engine: str, speed: float, mode: int) -> float:
    """Absolute error of a damping ratio, greatest of the turn; not a number if not known."""
    names = [f"damping_ratio_{cause}_error" for cause in ("discretisation", "reduction")]
    if variable != "damping_ratio" or not set(names) <= set(data):
        return float("nan")
    where = {"engine": engine, "crank_speed": speed, "mode": mode}
    return sum(float(np.nanmax(data[name].sel(where).values)) for name in names)


def _tables(result: MovingFrequencies, unit: str) -> tuple[Table, ...]:
    """Lowest and highest frequency of each mode with their errors, a table for each state."""
    return tuple(
        _extremes_table(MovingFrequencies(data), state, unit, several=len(result.states) > 1)
        for state, data in in_each_state(result).items()
    )


def _extremes_table(result: MovingFrequencies, state: str, unit: str, *, several: bool) -> Table:
    data, extremes = result.dataset, result.extremes()
    error = known_error(data)
    rows = []
    for engine in names_of(data, "engine"):
        for speed in data["crank_speed"].values.tolist():
            for mode in data["mode"].values.tolist():
                where = {"engine": engine, "crank_speed": speed, "mode": mode}
                here, relative = extremes.sel(where), float(error.sel(where))
                cells = [engine, f"{from_si(speed, unit):.6g}", str(mode)]
                for which in ("lowest", "highest"):
                    value = float(here[which])
                    cells.append(with_error(value, value * relative))
                    cells.append(f"{np.degrees(float(here[f'{which}_angle'])):.1f}")
                rows.append(tuple(cells))
    return Table(
        "Lowest and highest natural frequencies" + (f", {state}" if several else ""),
        ("engine", unit, "mode", "lowest (Hz)", "at (deg)", "highest (Hz)", "at (deg)"),
        (tuple(rows),),
        caption="errors: mesh (estimated) and component modes together, greatest of the turn",
    )
