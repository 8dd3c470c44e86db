"""Frequencies and damping over the crank angle; critical speeds and stability over speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses import CampbellDiagram, MovingFrequencies, StabilityMap, Table
from flexmech.analyses.digits import decimals_of, with_error
from flexmech.analyses.frequencies.damping import error_of_damping
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.arrays import FloatArray
from flexmech.plots.frequencies import damping_picture
from flexmech.plots.picture import Choice, Picture, joined
from flexmech.plots.reading import degrees, names_of, speed_label
from flexmech.report import panel
from flexmech.report.panel import Plot, plotted
from flexmech.report.results import (
    Results,
    speed_name,
    speed_unit_of,
    state_of,
)
from flexmech.units import from_si

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
        plots=(_frequency_plot(result, unit),),
        readings=tuple(_readings(result, unit)),
        folded=_tables(result, unit),
        stress=STRESSES[str(attrs["prestress"])],
        terms=_terms(str(attrs.get("rotation_terms", "off"))),
    )


def _terms(counted: str) -> str:
    """Which rotation terms are counted, by the attribute of a result."""
    if counted in ("on", "off"):
        return f"with{'out' * (counted == 'off')} the Coriolis, centripetal and tangential"
    names = counted.replace("coriolis", "Coriolis").split(",")
    return f"with, of those by rotation, only the {' and '.join(names)}"


@panel.shows(MovingFrequencies)
def damping_panel(result: MovingFrequencies, results: Results) -> panel.Panel | None:
    """Damping ratios over crank angle, where any link damps."""
    variable = _damping_of(result.dataset)
    if not variable:
        return None
    lines = tuple(line for line in result.summary().lines if "damping" in line)
    shown = _of_each(result, partial(damping_picture, name=variable))
    plot = plotted(variable.replace("_", "-"), shown)
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


def _of_each(result: MovingFrequencies, picture: Callable[[xr.Dataset], Picture]) -> Picture:
    """A picture of every state by every engine, among which the reader chooses."""
    return joined(
        [
            ({"engine": engine, "state": state}, picture(data.isel(engine=[number])))
            for state, data in in_each_state(result).items()
            for number, engine in enumerate(names_of(data, "engine"))
        ]
    )


def _frequency_plot(result: MovingFrequencies, unit: str) -> Plot:
    """Frequencies of all modes; the cursor's dots are at the speed chosen."""
    speeds = result.dataset["crank_speed"].values.tolist()
    chosen = {speed_label(one, unit): {"speed": speed_name(one, unit)} for one in speeds}

    def picture(data: xr.Dataset) -> Picture:
        made = plots.plot_frequencies.picture(data.assign_attrs(speed_unit=unit))
        panes = [
            replace(
                pane,
                curves=tuple(replace(one, followed=chosen[one.name]) for one in pane.curves),
            )
            for pane in made.panes
        ]
        return replace(made, panes=tuple(panes))

    return plotted("frequency", _of_each(result, picture))


def _readings(result: MovingFrequencies, unit: str) -> list[panel.Reading]:
    """Frequency and damping ratio of each mode at the crank angle."""
    readings = []
    damping = _damping_of(result.dataset)
    for state, data, engine, speed, mode in _places(result):
        angle = degrees(data["crank_angle"])
        when: Choice = {"engine": engine, "state": state, "speed": speed_name(speed, unit)}
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
    where = {"engine": engine, "crank_speed": speed, "mode": mode}
    return float(error_of_damping(data, variable).sel(where))


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


@panel.shows(CampbellDiagram)
def campbell_panel(result: CampbellDiagram, results: Results) -> panel.Panel:
    """Bands over crank speed under the orders' rays, with critical speeds."""
    data, unit = result.dataset, speed_unit_of(results)
    data = data.assign_attrs(speed_unit=unit)
    shown = [
        ({"engine": engine} if data.sizes["engine"] > 1 else {}, data.isel(engine=[number]))
        for number, engine in enumerate(names_of(data, "engine"))
    ]
    pictures = [(when, plots.plot_campbell.picture(one)) for when, one in shown]
    plot = plotted("campbell", joined(pictures))
    of = {"engine": names_of(data, "engine")[0], "state": state_of(data.attrs)}
    table = _critical_table(data, unit)
    return panel.panel_of("campbell", result.summary(), plots=(plot,), folded=(table,), **of)


@panel.shows(StabilityMap)
def stability_panel(result: StabilityMap, results: Results) -> panel.Panel:
    """Growth rates and moduli over crank speed, with the unstable bands."""
    data, unit = result.dataset, speed_unit_of(results)
    plot = plotted("stability", plots.plot_stability.picture(data.assign_attrs(speed_unit=unit)))
    of = {name: data.attrs[name] for name in ("prestress", "damping")}
    return panel.panel_of("stability", result.summary(), plots=(plot,), **of)


def relative_error(data: xr.Dataset, engine: str, branch: int) -> float:
    """Relative error of a branch by mesh, fit and Krylov spaces, greatest of the speeds.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a Campbell diagram.
    engine : str
    branch : int

    Returns
    -------
    float
    """
    own = data.sel(engine=engine)
    mesh = float(np.nanmax(own["discretisation_error"].sel(branch=branch).values, initial=0.0))
    return mesh + float(own["fit_error"]) + float(own["projection_error"])


def _critical_table(data: xr.Dataset, unit: str) -> Table:
    """Critical speeds with their errors: those of the frequencies, in speed."""
    rows = []
    for place in range(data.sizes["critical"]):
        own = data.isel(critical=place)
        engine, branch = str(own["critical_engine"].item()), int(own["critical_branch"])
        relative = relative_error(data, engine, branch)
        gap = float(own["critical_gap"])
        start, end = (from_si(float(own[f"critical_{name}"]), unit) for name in ("start", "end"))
        known = [with_error(value, abs(value) * relative) for value in (start, end)]
        if gap > 0:
            known[1] = "-"
        if bool(own["critical_starts_inside"]):
            known[0] = f"< {start:.4g}"
        if bool(own["critical_ends_inside"]):
            known[1] = f"> {end:.4g}"
        nearest = f"{100 * gap:.1f} %" if gap > 0 else "-"
        order = str(int(own["critical_order"]))
        rows.append((engine, str(branch), order, *known, nearest))
    return Table(
        "Critical speeds",
        ("engine", "branch", "order", f"from ({unit})", f"to ({unit})", "nearest"),
        (tuple(rows),),
        caption=(
            "errors: those of the frequencies by mesh and fit, as a speed; <, >: inside the band "
            "already at the first speed, or still at the last; nearest: the order meets the branch "
            "nowhere and is this far from it"
        ),
    )
