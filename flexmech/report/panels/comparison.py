"""A measured record beside what is computed."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Comparison
from flexmech.report.panel import Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.types import FloatArray

MEASURED = "#8a8a8a"
COMPUTED, RESIDUAL = 0, 1
# Strains are read in µm/m; what has a unit is drawn in it.
STRAIN = (1e6, "µm/m")


def comparison_panel(results: Results) -> Panel | None:
    """Measured and computed curves with the residual, and what was fitted."""
    result = results.first(Comparison)
    if result is None:
        return None
    data, said = result.dataset, result.summary()
    if "time" in data.dims:
        plot = _over_time(data)
    elif "sample" in data.dims:
        plot = _over_angle(data)
    else:
        plot = _over_frequency(data)
    return Panel(
        name="comparison",
        title="Beside a measured record",
        caption=(
            f"{data.attrs['column']} of {data.attrs['record']} and {data.attrs['quantity']}. "
            "Fitted numbers have 95 % intervals, which are widened where the residual is no white "
            "noise; nothing of them is applied to the mechanism."
        ),
        equation="min Σ (measured - computed(τ, k))²",
        source="G. H. Golub and V. Pereyra, SIAM Journal on Numerical Analysis 10 (1973) 413-432",
        plots=(plot,),
        tables=said.tables,
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
    )


def _scale(data: xr.Dataset) -> tuple[float, str]:
    unit = str(data.attrs["unit"])
    return (1.0, unit) if unit else STRAIN


def _over_time(data: xr.Dataset) -> Plot:
    factor, unit = _scale(data)
    time = data["time"].values
    return Plot(
        name="comparison",
        x_title="Time (s)",
        axes=(YAxis(f"{data.attrs['quantity']} ({unit})"), YAxis(f"Residual ({unit})")),
        traces=(
            Trace("measured", time, factor * data["measured"].values, MEASURED, width=3.0),
            Trace("computed", time, factor * data["computed"].values, COMPUTED),
            Trace("residual", time, factor * data["residual"].values, RESIDUAL, axis=1),
        ),
        text="Measured and computed curve against time, and below them the residual",
        height=440,
    )


def _over_frequency(data: xr.Dataset) -> Plot:
    def size(curve: str) -> FloatArray:
        return np.asarray(np.hypot(data[f"{curve}_real"].values, data[f"{curve}_imag"].values))

    frequency, unit = data["frequency"].values, str(data.attrs["unit"])
    return Plot(
        name="comparison",
        x_title="Frequency (Hz)",
        axes=(
            YAxis(f"{str(data.attrs['kind']).capitalize()} ({unit})", logarithmic=True),
            YAxis(f"Residual ({unit})", logarithmic=True),
        ),
        traces=(
            Trace("measured", frequency, size("measured"), MEASURED, width=3.0),
            Trace("computed", frequency, size("computed"), COMPUTED),
            Trace("residual", frequency, size("residual"), RESIDUAL, axis=1),
        ),
        text="Amplitude of the measured and the computed function over frequency, and the residual",
        height=440,
    )


def _over_angle(data: xr.Dataset) -> Plot:
    traces = []
    for number, mode in enumerate(np.unique(data["mode"].values).tolist()):
        own = data.isel(sample=np.flatnonzero(data["mode"].values == mode)).sortby("crank_angle")
        angle = np.degrees(own["crank_angle"].values)
        traces += [
            Trace(f"mode {mode}, measured", angle, own["measured"].values, number, "points"),
            Trace(f"mode {mode}, computed", angle, own["computed"].values, number),
            Trace(f"mode {mode}", angle, own["residual"].values, number, "points", axis=1),
        ]
    return Plot(
        name="comparison",
        x_title="Crank angle (deg)",
        axes=(YAxis("Natural frequency (Hz)"), YAxis("Residual (Hz)")),
        traces=tuple(traces),
        text="Measured and computed natural frequencies over the crank angle, and the residual",
        cursor="angle",
        height=440,
    )
