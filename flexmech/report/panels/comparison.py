"""A measured record beside what is computed."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Comparison
from flexmech.arrays import FloatArray
from flexmech.plots.reading import complex_values
from flexmech.report.panel import Panel, Plot, Trace, YAxis, over_angle, panel_of, shows
from flexmech.report.results import Results

# Strains are read in µm/m; what has a unit is drawn in it.
STRAIN = (1e6, "µm/m")
CURVES = ("measured", "computed", "residual")


@shows(Comparison)
def comparison_panel(result: Comparison, results: Results) -> Panel:
    """Measured and computed curves with the residual, and what was fitted."""
    data = result.dataset
    if "time" in data.dims:
        plot = _over_time(data)
    elif "sample" in data.dims:
        plot = _over_angle(data)
    else:
        plot = _over_frequency(data)
    of = {name: data.attrs[name] for name in ("column", "record", "quantity")}
    return panel_of("comparison", result.summary(), plots=(plot,), **of)


def _traces(x: FloatArray, curves: list[FloatArray]) -> tuple[Trace, ...]:
    """The measured curve under the computed one, and below them the residual."""
    measured, computed, residual = curves
    return (
        Trace("measured", x, measured, "#8a8a8a", width=3.0),
        Trace("computed", x, computed, 0),
        Trace("residual", x, residual, 1, axis=1),
    )


def _over_time(data: xr.Dataset) -> Plot:
    unit = str(data.attrs["unit"])
    factor, unit = (1.0, unit) if unit else STRAIN
    return Plot(
        "comparison",
        "Time (s)",
        (YAxis(f"{data.attrs['quantity']} ({unit})"), YAxis(f"Residual ({unit})")),
        _traces(data["time"].values, [factor * data[name].values for name in CURVES]),
        "Measured and computed curve against time, and below them the residual",
        height=440,
    )


def _over_frequency(data: xr.Dataset) -> Plot:
    names = str(data.attrs["kind"]).capitalize(), "Residual"
    sizes = [np.abs(complex_values(data, name)) for name in CURVES]
    return Plot(
        "comparison",
        "Frequency (Hz)",
        tuple(YAxis(f"{name} ({data.attrs['unit']})", logarithmic=True) for name in names),
        _traces(data["frequency"].values, sizes),
        "Amplitude of the measured and the computed function over frequency, and the residual",
        height=440,
    )


def _over_angle(data: xr.Dataset) -> Plot:
    traces = []
    for number, mode in enumerate(np.unique(data["mode"].values).tolist()):
        own = data.isel(sample=np.flatnonzero(data["mode"].values == mode)).sortby("crank_angle")
        angle = np.degrees(own["crank_angle"].values)
        measured, computed, residual = (own[name].values for name in CURVES)
        traces += [
            Trace(f"mode {mode}, measured", angle, measured, number, "points"),
            Trace(f"mode {mode}, computed", angle, computed, number),
            Trace(f"mode {mode}", angle, residual, number, "points", axis=1),
        ]
    return over_angle(
        "comparison",
        (YAxis("Natural frequency (Hz)"), YAxis("Residual (Hz)")),
        traces,
        text="Measured and computed natural frequencies over the crank angle, and the residual",
        tick=None,
        height=440,
    )
