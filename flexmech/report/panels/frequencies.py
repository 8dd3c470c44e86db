"""Frequencies and damping over the crank angle; critical speeds and stability over speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses import CampbellDiagram, MovingFrequencies, StabilityMap
from flexmech.analyses.digits import decimals_of
from flexmech.analyses.frequencies.damping import error_of_damping
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.arrays import FloatArray
from flexmech.plots.frequencies import damping_of
from flexmech.plots.picture import Choice, Picture, joined
from flexmech.plots.reading import degrees, names_of, speed_label
from flexmech.report import panel
from flexmech.report.panel import Plot, plotted
from flexmech.report.results import Results, speed_name, speed_unit_of, state_of

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
        result.said,
        plots=(_frequency_plot(result, unit),),
        readings=tuple(_readings(result, unit)),
        # The table is of the last state; what it is against comes first.
        folded=tuple(t for name in result.states[:1] for t in result.state(name).said.tables),
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
    if not _is_damped(result.dataset):
        return None
    variable = damping_of(result.dataset)
    lines = tuple(line for line in result.said.lines if "damping" in line)
    plot = plotted(variable.replace("_", "-"), _of_each(result, plots.plot_damping.picture))
    return panel.panel_of("damping", (), variable, plots=(plot,), lines=lines)


def _is_damped(data: xr.Dataset) -> bool:
    """Whether links damp: of Kelvin-Voigt damping the error of the ratio is estimated."""
    return "strain_energy_damping" in data or "damping_ratio_reduction_error" in data


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
    damping, damped = damping_of(result.dataset), _is_damped(result.dataset)
    for state, data, engine, speed, mode in _places(result):
        angle = degrees(data["crank_angle"])
        when: Choice = {"engine": engine, "state": state, "speed": speed_name(speed, unit)}
        frequency = _values(data, "frequency", engine, speed, mode)
        relative = float(known_error(data).sel(engine=engine, crank_speed=speed, mode=mode))
        error = relative * float(np.nanmax(frequency))
        found = [("Natural frequency", "Hz", frequency, error)]
        if damped:
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
    return panel.panel_of("campbell", result.said, plots=(plot,), **of)


@panel.shows(StabilityMap)
def stability_panel(result: StabilityMap, results: Results) -> panel.Panel:
    """Growth rates and moduli over crank speed, with the unstable bands."""
    data, unit = result.dataset, speed_unit_of(results)
    plot = plotted("stability", plots.plot_stability.picture(data.assign_attrs(speed_unit=unit)))
    of = {name: data.attrs[name] for name in ("prestress", "damping")}
    return panel.panel_of("stability", result.said, plots=(plot,), **of)
