"""Measured curves beside computed ones: frequency responses of hammer tests, and other records."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, over_angles, phase_pane
from flexmech.plots.reading import amplitudes_of, complex_values, signed, speed_text
from flexmech.plots.style import (
    MID_GREY,
    SERIES_STYLES,
    Look,
    is_narrow,
    line_handle,
    series_style,
)

# What a row of panels and what the axes take, in inches.
ROW_HEIGHT, AXES_HEIGHT = 1.7, 0.5
# Colours that both figures share.
BLUE, ORANGE, GREEN = (series_style(number).color for number in range(3))
CURVES: dict[str, tuple[str, Look]] = {
    "exact_receptance": ("eigen model, exact", {"color": "0.75", "lw": 2.6}),
    "receptance": ("measured (H1)", {"color": BLUE, "lw": 0.8}),
    "identified_receptance": (
        "identified modes",
        {"color": ORANGE, "lw": 0.9, "ls": (0.0, (4.0, 4.0))},
    ),
}
"""Receptances of the dataset, from the lowest to the uppermost line: label and look."""
# Decades of an amplitude below its peak that are drawn, at most: deeper antiresonances are noise.
DECADES = 5.0

# What a row of panels and what the axes take, in inches: seven orders fit a page. On a narrow page
# each row becomes two.
ROW, NARROW_ROW, HARMONIC_AXES_HEIGHT = 1.25, 0.75, 0.7
# Room above the greatest amplitude, and how far below it the axis reaches at most.
HEADROOM, HARMONIC_DECADES = 2.0, 4.5
HARMONICS: dict[str, tuple[str, Look]] = {
    "frozen": ("frozen linkage", {"color": MID_GREY, "lw": 0.9, "ls": (0.0, (4.0, 2.0))}),
    "receptance": ("running linkage", {"color": BLUE, "lw": 0.9}),
}
"""Harmonic transfer functions of the dataset, from the lowest line up: label and look."""
# A phase is drawn where its amplitude is above this part of the order's greatest: of round-off it
# would fill the panel.
LEAST_AMPLITUDE = 1e-4

# The computed curve lies on the measured one, which is seen on both sides of it.
MEASURED: Look = {"color": "0.68", "lw": 2.4}
COMPUTED: Look = {"color": SERIES_STYLES[0].color, "lw": 0.8}
RESIDUAL: Look = {"color": SERIES_STYLES[1].color, "lw": 0.8}
# Marks at the first and last crank angle hang over the edge.
POINTS: Look = {"ls": "", "marker": "o", "ms": 3.2, "mfc": "none", "mew": 0.9, "clip_on": False}
COMPARED = {"measured": MEASURED, "computed": COMPUTED, "residual": RESIDUAL}
# Heights of a panel and of the axes in inches: three panels, each with its own axis, fill half a
# page.
PANEL_HEIGHT, COMPARED_AXES_HEIGHT = 1.35, 1.5
# Units in which values are read, by the SI unit.
READ: dict[str, reading.Units] = {
    "": reading.STRAIN_UNITS,
    "m": reading.LENGTH_UNITS,
    "Hz": ((1.0, "Hz"),),
    "m/N": ((1e3, "mm/N"), (1e6, "µm/N"), (1e9, "nm/N")),
    "m/(N s)": ((1.0, "m/(N s)"), (1e3, "mm/(N s)"), (1e6, "µm/(N s)")),
    "m/(N s^2)": ((1.0, "m/(N s²)"),),
}
PARAMETER_UNITS: dict[str, reading.Units] = {"s": ((1e6, "µs"), (1e9, "ns"))}
# Depth of a spectrum below its peak that is drawn: a measured one ends there in noise.
COMPARED_DECADES = 4.0


@figure
def plot_frf(dataset: xr.Dataset) -> Picture:
    """Draw amplitude and phase of the receptance.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``HammerTest`` result; its first crank angle is drawn.
    ax : sequence of Axes, optional
        Two of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    data = first_angle(dataset)
    frequency = data["frequency"].values
    values = {curve: complex_values(data, curve) for curve in CURVES}
    low, high = scales.log_limits(np.abs(values["exact_receptance"]), DECADES)
    size, phase = (
        [Curve(frequency, part(values[n]), look, words) for n, (words, look) in CURVES.items()]
        for part in (np.abs, scales.phase_of)
    )
    limits, layout = (low / 2, high), grid(2, 1, 2 * ROW_HEIGHT + AXES_HEIGHT, sharex=True)
    amplitude = Pane("Receptance\namplitude (m/N)", size, limits=limits, scale="log")
    panes, ends = [amplitude, phase_pane("Phase (deg)", phase)], np.array([0.0, frequency[-1]])
    title, along = hammer_title(dataset), "Frequency (Hz)"
    return Picture(panes, along, dataset, title, places=ends, layout=layout)


def curve_handles(**measured: Any) -> list[Artist]:
    """Legend entries of the curves; further properties are of the measured one."""
    return [
        line_handle(label, **(look | (measured if curve == "receptance" else {})))
        for curve, (label, look) in CURVES.items()
    ]


def first_angle(dataset: xr.Dataset) -> xr.Dataset:
    """The part of a dataset at its first crank angle."""
    return dataset.isel(crank_angle=0) if "crank_angle" in dataset.dims else dataset


def angle_text(one: xr.Dataset) -> str:
    """Crank angle of the part of a dataset at one angle."""
    return f"{float(np.degrees(one['crank_angle'])):.6g} deg"


def hammer_title(dataset: xr.Dataset) -> str:
    """Heading that says where the crank was locked, hit and watched, and by which engine."""
    of = dataset.attrs
    return (
        f"Crank locked at {angle_text(first_angle(dataset))}: impact {of['impact']}, response "
        f"{of['response_point']}, {of['direction']}; {of['engine']}"
    )


@figure
def plot_harmonic_frf(dataset: xr.Dataset) -> Picture:
    """Draw amplitude and phase of each harmonic transfer function, a row an order.

    Along x is the frequency of the force; the response of order n is at that frequency and n
    times the crank's. Dashed is what the frozen linkage would answer, by the Fourier series of its
    receptance over the turn.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``RunningHammerTest`` result.
    ax : Axes or sequence of Axes, optional
        The user's: amplitude and phase of each order. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    orders, panes = dataset["order"].values.tolist(), []
    frequency = dataset["frequency"].values
    functions = {name: complex_values(dataset, name, "order", "frequency") for name in HARMONICS}
    limits = _limits(np.abs(list(functions.values())))
    for row, order in enumerate(orders):
        sizes, phases = list[Curve](), list[Curve]()
        for name, values in functions.items():
            size, (words, look) = np.abs(values[row]), HARMONICS[name]
            strong = np.where(size > LEAST_AMPLITUDE * size.max(), values[row], np.nan)
            sizes.append(Curve(frequency, amplitudes_of(values[row]), look, words))
            phases.append(Curve(frequency, scales.phase_of(strong), look, words))
        symbol = f"H{reading.subscripts(signed(order))}"
        panes.append(Pane(f"|{symbol}| (m/N)", sizes, limits=limits, scale="log"))
        panes.append(phase_pane(f"\N{ANGLE}{symbol} (deg)", phases))
    attrs = dataset.attrs
    title = (
        f"From {attrs['impact_point']} at f to {attrs['response_point']} at f + n f$_{{crank}}$; "
        f"{speed_text(dataset)}, {attrs['engine']} engine"
    )
    height = (NARROW_ROW if is_narrow() else ROW) * len(orders) + HARMONIC_AXES_HEIGHT / 2
    layout, along = grid(len(orders), 2, height, sharex=True), "Frequency f of the force (Hz)"
    return Picture(panes, along, dataset, title, places=frequency, layout=layout)


def _limits(size: FloatArray) -> tuple[float, float]:
    """Limits of all amplitudes, from a few decades below the greatest."""
    greatest = float(size.max())
    if greatest == 0:
        return 1e-9, 1.0
    least = float(size[size > 0].min())
    return max(least / HEADROOM, greatest * 10**-HARMONIC_DECADES), greatest * HEADROOM


@figure
def plot_comparison(dataset: xr.Dataset) -> Picture:
    """Draw a measured record and the computed one in three panels.

    A record over time has both curves with the crank angle on top, the residual, and the spectra of
    all three. A frequency-response function has amplitude, phase, and amplitude of the residual.
    Natural frequencies over the crank angle have two panels, frequencies and residual. The heading
    names the fitted parameters, with their 95 % intervals.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Comparison`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    of = {"time": _over_time, "sample": _over_angle}
    make = next((made for name, made in of.items() if name in dataset.dims), _over_frequency)
    picture = replace(make(dataset), title=_compared_title(dataset))
    rows = len(picture.panes)
    return replace(picture, layout=grid(rows, 1, rows * PANEL_HEIGHT + COMPARED_AXES_HEIGHT))


def _compared_title(dataset: xr.Dataset) -> str:
    """Compared quantity and its place, and the fitted parameters."""
    attrs = dataset.attrs
    if "crank_speed" in attrs:
        where = f"at {reading.speed_text(dataset)}"
    else:
        where = f"crank locked at {np.degrees(attrs['crank_angle_locked']):.4g} deg"
    fitted = [_fitted(dataset.isel(parameter=n)) for n in range(dataset.sizes["parameter"])]
    compared = f"{attrs['record']} and {attrs['quantity']}, {where}"
    lines = [compared, *([", ".join(fitted)] if fitted else [])]
    return "\n".join(lines).replace("$", r"\$")


def _fitted(own: xr.Dataset) -> str:
    """A parameter with half of its 95 % interval."""
    name, unit = str(own["parameter"].item()), str(own["parameter_unit"].item())
    value, half = float(own["fitted"]), float(own["upper"] - own["lower"]) / 2
    factor, read = reading.fitting_unit(
        np.array([value]), PARAMETER_UNITS.get(unit, ((1.0, unit),))
    )
    digits = max(0, 1 - int(np.floor(np.log10(factor * half)))) if half > 0 else 4
    text = f"{name.replace('_', ' ')} {factor * value:.{digits}f} ± {factor * half:.{digits}f}"
    return text if read == "1" else f"{text} {read}"


def _what(dataset: xr.Dataset) -> str:
    """Word for the quantity on an axis, from the name of its column."""
    name = str(dataset.attrs["quantity"])
    return next((word for word in ("strain", "deflection") if word in name), name).capitalize()


def _compared(x: FloatArray, curves: dict[str, FloatArray]) -> list[Curve]:
    return [Curve(x, values, COMPARED[name], name) for name, values in curves.items()]


def _over_time(dataset: xr.Dataset) -> Picture:
    time, units = dataset["time"].values, READ[str(dataset.attrs["unit"])]
    curves = _compared(time, {name: dataset[name].values for name in COMPARED})
    # Mostly noise, whose swings would run together.
    residual = replace(curves[2], look=RESIDUAL | {"lw": 0.4})
    panes = (
        Pane(_what(dataset), curves[:2], units, spans=(ZERO,)),
        Pane("Residual", (residual,), units, spans=(ZERO,)),
        _spectra(dataset),
    )
    return Picture(panes, "Time (s)", dataset, over="time", places=time)


def _spectra(dataset: xr.Dataset) -> Pane:
    """Spectra of both curves and of the residual, in the unit of the curves."""
    units = READ[str(dataset.attrs["unit"])]
    factor, unit = reading.fitting_unit(dataset["measured"].values, units)
    amplitude = factor * dataset["spectrum"].transpose("curve", "spectrum_frequency").values
    frequency, highest = dataset["spectrum_frequency"].values, float(amplitude.max())
    return Pane(
        f"Amplitude ({unit})",
        _compared(frequency[1:], dict(zip(COMPARED, amplitude[:, 1:], strict=True))),
        limits=(highest * 10.0**-COMPARED_DECADES, 2 * highest),
        scale="log",
        along="Frequency (Hz)",
        x_limits=(0.0, float(frequency[-1])),
        apart="number",
    )


def _over_frequency(dataset: xr.Dataset) -> Picture:
    frequency = dataset["frequency"].values
    functions = {name: reading.complex_values(dataset, name) for name in COMPARED}
    sizes = {name: np.abs(values) for name, values in functions.items()}
    factor, unit = reading.fitting_unit(sizes["measured"], READ[str(dataset.attrs["unit"])])
    panes = []
    for label, names in (
        (str(dataset.attrs["kind"]).capitalize(), ("measured", "computed")),
        ("Residual", ("residual",)),
    ):
        shown = {name: factor * sizes[name] for name in names}
        low, high = scales.log_limits(np.concatenate(list(shown.values())), COMPARED_DECADES)
        curves = _compared(frequency, shown)
        panes.append(Pane(f"{label} ({unit})", curves, limits=(low / 1.5, high), scale="log"))
    phases = {name: np.degrees(np.angle(functions[name])) for name in ("measured", "computed")}
    phase = _compared(frequency, phases)
    panes.insert(1, phase_pane("Phase (deg)", phase))
    return Picture(panes, "Frequency (Hz)", dataset, places=frequency)


def _over_angle(dataset: xr.Dataset) -> Picture:
    upper, lower = list[Curve](), list[Curve]()
    for number, mode in enumerate(np.unique(dataset["mode"].values)):
        own = dataset.isel(sample=np.flatnonzero(dataset["mode"].values == mode))
        own = own.sortby("crank_angle")
        angle, style = reading.degrees(own["crank_angle"]), series_style(number)
        points = POINTS | {"color": style.color}
        line: Look = {"color": style.color, "ls": style.linestyle, "lw": 0.9}
        name = reading.mode_label([int(mode)]).lower()
        upper.append(Curve(angle, own["measured"].values, points, f"{name}, measured"))
        upper.append(Curve(angle, own["computed"].values, line, f"{name}, computed"))
        lower.append(Curve(angle, own["residual"].values, points))
    panes = (
        Pane("Natural frequency (Hz)", upper),
        Pane("Residual (Hz)", lower, spans=(ZERO,)),
    )
    return over_angles(np.unique(reading.degrees(dataset["crank_angle"])), panes, dataset)
