"""Frequencies and damping over the crank angle; critical speeds and stability over speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses import CampbellDiagram, MovingFrequencies, StabilityMap, Table
from flexmech.analyses.digits import decimals_of, with_error
from flexmech.analyses.frequencies.damping import error_of_damping
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.arrays import FloatArray
from flexmech.plots.campbell import critical_stretches
from flexmech.plots.reading import degrees, names_of
from flexmech.plots.stability import KINDS, UnstableBand, growth_curve, unstable_bands
from flexmech.plots.style import series_style
from flexmech.report import panel
from flexmech.report.results import (
    Results,
    speed_name,
    speed_unit_of,
    state_of,
)
from flexmech.units import from_si

# Of an axis in pixels: three ticks and their numbers, and the lines of some speeds.
AXIS_HEIGHT = 130
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
        height=panel.FRAME_HEIGHT + AXIS_HEIGHT * len(modes),
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
    plot = panel.over_speed(
        "campbell",
        unit,
        (panel.YAxis("Frequency (Hz)"),),
        (*_branches(data, unit), *_rays(data, unit), *_critical(data, unit)),
        f"Bands of {data.sizes['branch']} branches against crank speed, with rays of the "
        "orders of the crank; thick dark parts of rays are critical speeds",
    )
    of = {"engine": names_of(data, "engine")[0], "state": state_of(data.attrs)}
    table = _critical_table(data, unit)
    return panel.panel_of("campbell", result.summary(), plots=(plot,), folded=(table,), **of)


@panel.shows(StabilityMap)
def stability_panel(result: StabilityMap, results: Results) -> panel.Panel:
    """Growth rates and moduli over crank speed, with the unstable bands."""
    data, unit = result.dataset, speed_unit_of(results)
    # Derived in the unit of the page.
    data = data.assign_attrs(speed_unit=unit)
    plot = panel.over_speed(
        "stability",
        unit,
        (panel.YAxis("Growth rate (1/s)"), panel.YAxis("Largest modulus")),
        (*_filled(unstable_bands(data)), *_growth(data)),
        "Growth rate and largest modulus of a Floquet multiplier against crank speed; shaded "
        "are the unstable bands",
    )
    of = {name: data.attrs[name] for name in ("prestress", "damping")}
    return panel.panel_of("stability", result.summary(), plots=(plot,), **of)


def relative_error(data: xr.Dataset, engine: str, branch: int) -> float:
    """Relative error of a branch by mesh, fit and Krylov spaces, greatest of the speeds.

    Parameters
    ----------
    data : xarray.Dataset
        Of a Campbell diagram.
    engine : str
    branch : int

    Returns
    -------
    float
    """
    own = data.sel(engine=engine)
    mesh = float(np.nanmax(own["discretisation_error"].sel(branch=branch).values, initial=0.0))
    return mesh + float(own["fit_error"]) + float(own["projection_error"])


def _branches(data: xr.Dataset, unit: str) -> list[panel.Trace]:
    """Each branch's lowest and highest frequency, filled between them, and its mean."""
    traces = []
    speed = from_si(1.0, unit) * data["crank_speed"].values
    for engine in names_of(data, "engine"):
        when = {"engine": engine} if data.sizes["engine"] > 1 else {}
        for number, branch in enumerate(data["branch"].values.tolist()):
            fill = _translucent(series_style(number).color, 0.25)
            for part in ("lowest", "highest", "mean"):
                values = data[f"{part}_frequency"].sel(engine=engine, branch=branch).values
                mean, filled = part == "mean", part == "highest"
                traces.append(
                    panel.Trace(
                        *(f"branch {branch}", speed, values, fill if filled else number),
                        width=1.8 if mean else 0.6,
                        when=when,
                        followed={} if mean else None,
                        fill="to previous" if filled else "none",
                        legend=mean,
                    )
                )
    return traces


def _translucent(color: str, opacity: float) -> str:
    """A colour such as #0072B2 as a browser fills with it."""
    red, green, blue = bytes.fromhex(color[1:])
    return f"rgba({red},{green},{blue},{opacity:g})"


def _rays(data: xr.Dataset, unit: str) -> list[panel.Trace]:
    speed = data["crank_speed"].values
    ends = np.array([min(speed.min(), 0.0), 0.0, max(speed.max(), 0.0)])
    top = 1.06 * float(np.nanmax(data["highest_frequency"].values))
    traces: list[panel.Trace] = []
    labelled = _labelled(data["order"].values.tolist(), float(np.abs(ends).max()), top)
    for order in data["order"].values.tolist():
        # Rays end where the bands do: beyond there is nothing to meet.
        most = min(float(np.abs(ends).max()), 2 * np.pi * top / order)
        along = np.clip(ends, -most, most)
        x, y = from_si(1.0, unit) * along, order * np.abs(along) / (2 * np.pi)
        name = f"order {order}" if traces else "order of the crank"
        ray = panel.Trace(name, x, y, panel.GREY, width=0.8, legend=not traces)
        if order in labelled:
            ray = replace(ray, label=f"{order}×")
        traces.append(ray)
    return traces


# Least distance of two labels of orders, as a part of the axes: height and width of their letters.
_APART = 0.05


def _labelled(orders: list[int], fastest: float, top: float) -> set[int]:
    """Orders whose labels stand clear of each other, from the highest on.

    Parameters
    ----------
    orders : list of int
    fastest : float
        Greatest crank speed in rad/s.
    top : float
        Highest frequency of the axes in Hz.
    """
    kept: dict[int, tuple[float, float]] = {}
    for order in sorted(orders, reverse=True):
        # A ray ends at the right edge, or where it leaves the axes at their top.
        along = min(1.0, 2 * np.pi * top / (order * fastest)) if fastest else 1.0
        place = along, order * along * fastest / (2 * np.pi * top)
        if all(max(abs(place[n] - other[n]) for n in (0, 1)) > _APART for other in kept.values()):
            kept[order] = place
    return set(kept)


def _critical(data: xr.Dataset, unit: str) -> list[panel.Trace]:
    """Parts of rays that are inside bands, with gaps between them."""
    x, y = list[float](), list[float]()
    for _, ends, ray in critical_stretches(data):
        x += [*(from_si(end, unit) for end in ends.tolist()), np.nan]
        y += [*ray.tolist(), np.nan]
    line = panel.Trace("critical speed", np.array(x), np.array(y), "critical", "solid", 3.5)
    return [line] if x else []


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


def _growth(data: xr.Dataset) -> list[panel.Trace]:
    """Growth and modulus of every engine."""
    traces = []
    for number, engine in enumerate(names_of(data, "engine")):
        speed, *curves = growth_curve(data, number)
        followed: dict[str, str] | None = None if number else {}
        for axis, values in enumerate(curves):
            line = panel.Trace(engine, speed, values, number, axis=axis, legend=axis == 0)
            traces.append(replace(line, followed=followed))
    return traces


def _filled(bands: list[UnstableBand]) -> list[panel.Trace]:
    """Unstable bands, filled up to their greatest growth rate."""
    traces, named, kinds = [], set[str](), list(KINDS)
    for band in bands:
        name, color = f"band: {KINDS[band.kind][0]}", series_style(kinds.index(band.kind)).color
        if band.kind == "unnamed":
            name, color = "band without a name", "#6e6e6e"
        x = np.array([band.low, band.low, band.high, band.high, band.low])
        y = band.growth * np.array([0.0, 1.0, 1.0, 0.0, 0.0])
        fill, legend = _translucent(color, 0.3), name not in named
        traces.append(panel.Trace(name, x, y, fill, width=0.8, fill="itself", legend=legend))
        named.add(name)
    return traces
