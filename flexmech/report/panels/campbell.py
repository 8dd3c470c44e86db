"""Which crank speeds to avoid: the Campbell diagram."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import CampbellDiagram, Table
from flexmech.report.panel import Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import engine_names, speed_unit_of, state_of, with_error
from flexmech.units import from_si

FILLINGS = ("0,114,178", "213,94,0", "0,158,115", "204,121,167", "230,159,0", "86,180,233")


def campbell_panel(results: Results) -> Panel | None:
    """Bands over crank speed under the orders' rays, with critical speeds."""
    result = results.first(CampbellDiagram)
    if result is None:
        return None
    data, unit = result.dataset, speed_unit_of(results)
    said = result.summary()
    engine = engine_names(data)[0]
    traces = (*_bands(data, unit), *_rays(data, unit), *_critical(data, engine, unit))
    plot = Plot(
        name="campbell",
        x_title=f"Crank speed ({unit})",
        axes=(YAxis("Frequency (Hz)"),),
        traces=traces,
        text=(
            f"Bands of {data.sizes['branch']} branches against crank speed, with rays of the "
            "orders of the crank; thick dark parts of rays are critical speeds"
        ),
        cursor="speed",
        speed_scale=from_si(1.0, unit),
        height=440,
    )
    return Panel(
        name="campbell",
        title="Which crank speeds to avoid",
        caption=(
            f"Campbell diagram by the {engine} engine, {state_of(data.attrs)}: filled is each "
            "branch from its lowest to its highest natural frequency over the turn, the line in it "
            "is the mean. Grey rays "
            "are multiples (orders) of the crank's turns per second; where a ray is dark it is "
            "inside a band, and the crank excites that branch: these are critical speeds."
        ),
        equation="n ω / 2π = f_b(θ, ω) for some θ of the turn",
        source="W. Campbell, Trans. ASME 46 (1924), with a band in place of each line",
        plots=(plot,),
        tables=(_table(data, unit),),
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
    )


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


def _bands(data: xr.Dataset, unit: str) -> list[Trace]:
    traces = []
    speed = from_si(1.0, unit) * data["crank_speed"].values
    for engine in engine_names(data):
        for number, branch in enumerate(data["branch"].values.tolist()):
            own = data.sel(engine=engine, branch=branch)
            fill = f"rgba({FILLINGS[number % len(FILLINGS)]},0.25)"
            for part, width in (("lowest", 0.6), ("highest", 0.6), ("mean", 1.8)):
                traces.append(
                    Trace(
                        name=f"branch {branch}",
                        x=speed,
                        y=own[f"{part}_frequency"].values,
                        colour=fill if part == "highest" else number,
                        width=width,
                        when={"engine": engine} if data.sizes["engine"] > 1 else {},
                        followed={} if part == "mean" else None,
                        fill="to previous" if part == "highest" else "none",
                        legend=part == "mean",
                    )
                )
    return traces


def _rays(data: xr.Dataset, unit: str) -> list[Trace]:
    speed = data["crank_speed"].values
    ends = np.array([min(speed.min(), 0.0), 0.0, max(speed.max(), 0.0)])
    top = 1.06 * float(np.nanmax(data["highest_frequency"].values))
    traces = []
    orders = data["order"].values.tolist()
    for order in orders:
        # Rays end where the bands do: beyond there is nothing to meet.
        most = min(float(np.abs(ends).max()), 2 * np.pi * top / order)
        along = np.clip(ends, -most, most)
        traces.append(
            Trace(
                name="order of the crank" if order == orders[0] else f"order {order}",
                x=from_si(1.0, unit) * along,
                y=order * np.abs(along) / (2 * np.pi),
                colour="#8c8c8c",
                width=0.8,
                legend=order == orders[0],
                label=f"{order}×",
            )
        )
    return traces


def _critical(data: xr.Dataset, engine: str, unit: str) -> list[Trace]:
    x, y = [], []
    met = (data["critical_engine"].values == engine) & (data["critical_gap"].values == 0)
    for place in np.flatnonzero(met).tolist():
        own = data.isel(critical=place)
        order = float(own["critical_order"])
        for end in ("start", "end"):
            speed = float(own[f"critical_{end}"])
            x.append(from_si(speed, unit))
            y.append(order * abs(speed) / (2 * np.pi))
        x.append(np.nan)
        y.append(np.nan)
    if not x:
        return []
    return [Trace("critical speed", np.array(x), np.array(y), "critical", "solid", 3.5)]


def _table(data: xr.Dataset, unit: str) -> Table:
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
            known[0] = f"< {from_si(float(own['critical_start']), unit):.4g}"
        if bool(own["critical_ends_inside"]):
            known[1] = f"> {from_si(float(own['critical_end']), unit):.4g}"
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
