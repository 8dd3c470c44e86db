"""Measurements: hammer tests, locked and running, and a record beside what is computed."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Comparison, HammerTest, RunningHammerTest
from flexmech.arrays import FloatArray
from flexmech.plots.frf import COMPARED, CURVES, HARMONICS, READ, angle_text
from flexmech.plots.reading import amplitudes_of, complex_values, signed
from flexmech.report import panel
from flexmech.report.results import Results, speed_name, speed_unit_of

# Of the curves of both figures those that are shown: variable, colour, look and width.
RECEPTANCES: tuple[tuple[str, panel.Look], ...] = (
    ("exact_receptance", "dash"),
    ("receptance", "solid"),
)
FUNCTIONS: tuple[tuple[str, int | str, panel.Look, float], ...] = (
    ("frozen", "#737373", "dash", 1.2),
    ("receptance", 0, "solid", 1.4),
)
# Angles whose curves are shown, each with a colour of its own; the table holds all.
MOST_ANGLES = 6


@panel.shows(HammerTest)
def hammer_panel(result: HammerTest, results: Results) -> panel.Panel:
    """Receptance and coherence over frequency, and measured beside computed modes."""
    data = result.dataset
    shown = min(MOST_ANGLES, data.sizes["crank_angle"])
    left_out = data.sizes["crank_angle"] - shown
    plot = panel.Plot(
        "hammer-frf",
        "Frequency (Hz)",
        (panel.YAxis("Receptance (m/N)", logarithmic=True), panel.YAxis("Coherence")),
        tuple(trace for number in range(shown) for trace in _receptances(data, number)),
        "Amplitude of the receptance and coherence against frequency",
        height=440,
    )
    of = {name: data.attrs[name] for name in ("impact", "response_point", "direction", "engine")}
    thinned = (f"curves of {left_out} more crank angles",) if left_out else ()
    return panel.panel_of("hammer", result.summary(), plots=(plot,), thinned=thinned, **of)


def _receptances(data: xr.Dataset, number: int) -> list[panel.Trace]:
    """Curves at one crank angle."""
    own = data.isel(crank_angle=number)
    at, frequency = angle_text(own), own["frequency"].values
    traces = []
    for name, look in RECEPTANCES:
        size = np.abs(complex_values(own, name))
        traces.append(panel.Trace(f"{CURVES[name][0]}, {at}", frequency, size, number, look))
    coherence = own["coherence"].values
    return [*traces, panel.Trace(at, frequency, coherence, number, axis=1, legend=False)]


@panel.shows(RunningHammerTest)
def running_hammer_panel(result: RunningHammerTest, results: Results) -> panel.Panel:
    """Amplitudes of every order over the frequency of the force."""
    data, attrs = result.dataset, result.dataset.attrs
    orders, frequency = data["order"].values.tolist(), data["frequency"].values
    # Where nothing answers there is nothing to draw on a logarithmic axis.
    sizes = {
        name: amplitudes_of(complex_values(data, name, "order", "frequency"))
        for name, *_ in FUNCTIONS
    }
    traces = [
        panel.Trace(
            *(HARMONICS[name][0], frequency, sizes[name][axis], colour, look, width),
            axis=axis,
            legend=axis == 0,
        )
        for axis in range(len(orders))
        for name, colour, look, width in FUNCTIONS
    ]
    plot = panel.Plot(
        "harmonic-response",
        "Frequency f of the force (Hz)",
        tuple(panel.YAxis(f"order {signed(order)} (m/N)", logarithmic=True) for order in orders),
        tuple(traces),
        "Amplitude of the response at f and at multiples of the crank's frequency beside it, "
        "over the frequency f of the force, of the running linkage and of the frozen one",
        height=panel.FRAME_HEIGHT + 110 * len(orders),
    )
    of = {name: attrs[name] for name in ("response_point", "impact_point", "direction")}
    of["speed"] = speed_name(float(attrs["crank_speed"]), speed_unit_of(results))
    return panel.panel_of("running-hammer", result.summary(), plots=(plot,), **of)


@panel.shows(Comparison)
def comparison_panel(result: Comparison, results: Results) -> panel.Panel:
    """Measured and computed curves with the residual, and what was fitted."""
    data = result.dataset
    if "time" in data.dims:
        plot = _over_time(data)
    elif "sample" in data.dims:
        plot = _over_angle(data)
    else:
        plot = _over_frequency(data)
    of = {name: data.attrs[name] for name in ("column", "record", "quantity")}
    return panel.panel_of("comparison", result.summary(), plots=(plot,), **of)


def _traces(x: FloatArray, curves: list[FloatArray]) -> tuple[panel.Trace, ...]:
    """The measured curve under the computed one, and below them the residual."""
    measured, computed, residual = curves
    return (
        panel.Trace("measured", x, measured, "#8a8a8a", width=3.0),
        panel.Trace("computed", x, computed, 0),
        panel.Trace("residual", x, residual, 1, axis=1),
    )


def _over_time(data: xr.Dataset) -> panel.Plot:
    unit = str(data.attrs["unit"])
    factor, unit = (1.0, unit) if unit else READ[""][0]
    return panel.Plot(
        "comparison",
        "Time (s)",
        (panel.YAxis(f"{data.attrs['quantity']} ({unit})"), panel.YAxis(f"Residual ({unit})")),
        _traces(data["time"].values, [factor * data[name].values for name in COMPARED]),
        "Measured and computed curve against time, and below them the residual",
        height=440,
    )


def _over_frequency(data: xr.Dataset) -> panel.Plot:
    names = str(data.attrs["kind"]).capitalize(), "Residual"
    sizes = [np.abs(complex_values(data, name)) for name in COMPARED]
    return panel.Plot(
        "comparison",
        "Frequency (Hz)",
        tuple(panel.YAxis(f"{name} ({data.attrs['unit']})", logarithmic=True) for name in names),
        _traces(data["frequency"].values, sizes),
        "Amplitude of the measured and the computed function over frequency, and the residual",
        height=440,
    )


def _over_angle(data: xr.Dataset) -> panel.Plot:
    traces = []
    for number, mode in enumerate(np.unique(data["mode"].values).tolist()):
        own = data.isel(sample=np.flatnonzero(data["mode"].values == mode)).sortby("crank_angle")
        angle = np.degrees(own["crank_angle"].values)
        measured, computed, residual = (own[name].values for name in COMPARED)
        traces += [
            panel.Trace(f"mode {mode}, measured", angle, measured, number, "points"),
            panel.Trace(f"mode {mode}, computed", angle, computed, number),
            panel.Trace(f"mode {mode}", angle, residual, number, "points", axis=1),
        ]
    return panel.over_angle(
        "comparison",
        (panel.YAxis("Natural frequency (Hz)"), panel.YAxis("Residual (Hz)")),
        traces,
        text="Measured and computed natural frequencies over the crank angle, and the residual",
        tick=None,
        height=440,
    )
