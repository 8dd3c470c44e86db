"""Over the crank speed: which speeds to avoid, and where the linkage shakes itself up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses import CampbellDiagram, StabilityMap, Table
from flexmech.plots.campbell import critical_stretches
from flexmech.plots.reading import names_of
from flexmech.plots.stability import KINDS, UnstableBand, growth_curve, unstable_bands
from flexmech.plots.style import series_style
from flexmech.report.panel import GREY, Panel, Trace, YAxis, over_speed, panel_of, shows
from flexmech.report.results import Results, speed_unit_of, state_of, with_error
from flexmech.units import from_si


@shows(CampbellDiagram)
def campbell_panel(result: CampbellDiagram, results: Results) -> Panel:
    """Bands over crank speed under the orders' rays, with critical speeds."""
    data, unit = result.dataset, speed_unit_of(results)
    plot = over_speed(
        "campbell",
        unit,
        (YAxis("Frequency (Hz)"),),
        (*_branches(data, unit), *_rays(data, unit), *_critical(data, unit)),
        f"Bands of {data.sizes['branch']} branches against crank speed, with rays of the "
        "orders of the crank; thick dark parts of rays are critical speeds",
    )
    of = {"engine": names_of(data, "engine")[0], "state": state_of(data.attrs)}
    table = _critical_table(data, unit)
    return panel_of("campbell", result.summary(), plots=(plot,), tables=(table,), **of)


@shows(StabilityMap)
def stability_panel(result: StabilityMap, results: Results) -> Panel:
    """Growth rates and moduli over crank speed, with the unstable bands."""
    data, unit = result.dataset, speed_unit_of(results)
    # Derived in the unit of the page.
    data = data.assign_attrs(speed_unit=unit)
    plot = over_speed(
        "stability",
        unit,
        (YAxis("Growth rate (1/s)"), YAxis("Largest modulus")),
        (*_filled(unstable_bands(data)), *_growth(data)),
        "Growth rate and largest modulus of a Floquet multiplier against crank speed; shaded "
        "are the unstable bands",
    )
    of = {name: data.attrs[name] for name in ("prestress", "damping")}
    return panel_of("stability", result.summary(), plots=(plot,), **of)


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


def _branches(data: xr.Dataset, unit: str) -> list[Trace]:
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
                    Trace(
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


def _rays(data: xr.Dataset, unit: str) -> list[Trace]:
    speed = data["crank_speed"].values
    ends = np.array([min(speed.min(), 0.0), 0.0, max(speed.max(), 0.0)])
    top = 1.06 * float(np.nanmax(data["highest_frequency"].values))
    traces: list[Trace] = []
    for order in data["order"].values.tolist():
        # Rays end where the bands do: beyond there is nothing to meet.
        most = min(float(np.abs(ends).max()), 2 * np.pi * top / order)
        along = np.clip(ends, -most, most)
        x, y = from_si(1.0, unit) * along, order * np.abs(along) / (2 * np.pi)
        name = f"order {order}" if traces else "order of the crank"
        ray = Trace(name, x, y, GREY, width=0.8, legend=not traces, label=f"{order}×")
        traces.append(ray)
    return traces


def _critical(data: xr.Dataset, unit: str) -> list[Trace]:
    """Parts of rays that are inside bands, with gaps between them."""
    x, y = list[float](), list[float]()
    for _, ends, ray in critical_stretches(data):
        x += [*(from_si(end, unit) for end in ends.tolist()), np.nan]
        y += [*ray.tolist(), np.nan]
    line = Trace("critical speed", np.array(x), np.array(y), "critical", "solid", 3.5)
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


def _growth(data: xr.Dataset) -> list[Trace]:
    """Growth and modulus of every engine."""
    traces = []
    for number, engine in enumerate(names_of(data, "engine")):
        speed, *curves = growth_curve(data, number)
        followed: dict[str, str] | None = None if number else {}
        for axis, values in enumerate(curves):
            line = Trace(engine, speed, values, number, axis=axis, legend=axis == 0)
            traces.append(replace(line, followed=followed))
    return traces


def _filled(bands: list[UnstableBand]) -> list[Trace]:
    """Unstable bands, filled up to their greatest growth rate."""
    traces, named, kinds = [], set[str](), list(KINDS)
    for band in bands:
        name, color = f"band: {KINDS[band.kind][0]}", series_style(kinds.index(band.kind)).color
        if band.kind == "unnamed":
            name, color = "band without a name", "#6e6e6e"
        x = np.array([band.low, band.low, band.high, band.high, band.low])
        y = band.growth * np.array([0.0, 1.0, 1.0, 0.0, 0.0])
        fill, legend = _translucent(color, 0.3), name not in named
        traces.append(Trace(name, x, y, fill, width=0.8, fill="itself", legend=legend))
        named.add(name)
    return traces
