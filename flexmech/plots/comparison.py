"""A measured record beside the computed one: both curves, their spectra and the residual."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.layout import AxesLike, Sheet, grid, sheet
from flexmech.plots.style import SERIES_STYLES, Look, line_handle, line_handles, series_style

# The computed curve lies on the measured one, which is seen on both sides of it.
MEASURED: Look = {"color": "0.68", "lw": 2.4}
COMPUTED: Look = {"color": SERIES_STYLES[0].color, "lw": 0.8}
RESIDUAL: Look = {"color": SERIES_STYLES[1].color, "lw": 0.8}
POINTS: Look = {"ls": "", "marker": "o", "ms": 3.2, "mfc": "none", "mew": 0.9}
CURVES = {"measured": MEASURED, "computed": COMPUTED, "residual": RESIDUAL}
# Of a panel and of the axes in inches.
PANEL_HEIGHT, AXES_HEIGHT = 1.35, 1.5
# Units in which values are read, by the SI unit.
READ: dict[str, reading.Units] = {
    "": ((1e6, "µm/m"),),
    "m": reading.LENGTH_UNITS,
    "Hz": ((1.0, "Hz"),),
    "m/N": ((1e3, "mm/N"), (1e6, "µm/N"), (1e9, "nm/N")),
    "m/(N s)": ((1.0, "m/(N s)"), (1e3, "mm/(N s)"), (1e6, "µm/(N s)")),
    "m/(N s^2)": ((1.0, "m/(N s²)"),),
}
PARAMETER_UNITS: dict[str, reading.Units] = {"s": ((1e6, "µs"), (1e9, "ns"))}
# Marks at the first and last crank angle hang over the edge by less than this part of the width.
MARK_ROOM = 0.02
# Depth of a spectrum below its peak that is drawn.
DECADES = 4.0


def plot_comparison(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw a measured record and the computed one in three panels.

    Over time: both curves with the crank angle on top, the residual, and the spectra of all three.
    Of a frequency-response function: amplitude, phase, and amplitude of the residual. Of natural
    frequencies over the crank angle: the frequencies and the residual, in two panels. The heading
    tells what was fitted, with its 95 % interval.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Comparison`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    over_angle = "sample" in dataset.dims
    rows = 2 if over_angle else 3
    layout = grid(rows, 1, rows * PANEL_HEIGHT + AXES_HEIGHT)
    with sheet(layout, ax=ax) as drawn:
        if "time" in dataset.dims:
            _draw_time(drawn, dataset)
        elif over_angle:
            _draw_frequencies(drawn, dataset)
        else:
            _draw_function(drawn, dataset)
    return drawn.figure


def _title(dataset: xr.Dataset) -> str:
    """What is compared where, and the fitted parameters."""
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
    told = f"{name.replace('_', ' ')} {factor * value:.{digits}f} ± {factor * half:.{digits}f}"
    return told if read == "1" else f"{told} {read}"


def _what(dataset: xr.Dataset) -> str:
    """Word for the quantity on an axis, from the name of its column."""
    name = str(dataset.attrs["quantity"])
    return next((word for word in ("strain", "deflection") if word in name), name).capitalize()


def _draw_time(drawn: Sheet, dataset: xr.Dataset) -> None:
    curves, residual, spectra = drawn.panels
    time = dataset["time"].values
    drawn.header(line_handles(CURVES), _title(dataset), of=dataset)
    units = READ[str(dataset.attrs["unit"])]
    factor, unit = reading.fitting_unit(dataset["measured"].values, units)
    of_residual, unit_of_residual = reading.fitting_unit(dataset["residual"].values, units)
    for axes in (curves, residual):
        axes.set_xlim(float(time[0]), float(time[-1]))
        scales.zero_line(axes)
        scales.plain_numbers(axes)
    curves.plot(time, factor * dataset["measured"].values, **MEASURED)
    curves.plot(time, factor * dataset["computed"].values, **COMPUTED)
    scales.angle_axis(curves, dataset)
    curves.set_ylabel(f"{_what(dataset)} ({unit})")
    residual.plot(time, of_residual * dataset["residual"].values, **RESIDUAL)
    residual.set(xlabel="Time (s)", ylabel=f"Residual ({unit_of_residual})")
    amplitude = factor * dataset["spectrum"].transpose("curve", "spectrum_frequency").values
    frequency = dataset["spectrum_frequency"].values
    for values, look in zip(amplitude, CURVES.values(), strict=True):
        spectra.plot(frequency[1:], values[1:], **look)
    highest = float(amplitude.max())
    scales.log_scale(spectra, highest * 10.0**-DECADES, 2 * highest)
    spectra.set_xlim(0.0, float(frequency[-1]))
    spectra.set(xlabel="Frequency (Hz)", ylabel=f"Amplitude ({unit})")


def _draw_function(drawn: Sheet, dataset: xr.Dataset) -> None:
    amplitude, phase, residual = drawn.panels
    frequency = dataset["frequency"].values
    drawn.header(line_handles(CURVES), _title(dataset), of=dataset)
    curves = {name: reading.complex_values(dataset, name) for name in CURVES}
    sizes = {name: np.abs(values) for name, values in curves.items()}
    factor, unit = reading.fitting_unit(sizes["measured"], READ[str(dataset.attrs["unit"])])
    for name in ("measured", "computed"):
        amplitude.plot(frequency, factor * sizes[name], **CURVES[name])
        phase.plot(frequency, np.degrees(np.angle(curves[name])), **CURVES[name])
    residual.plot(frequency, factor * sizes["residual"], **RESIDUAL)
    kind = str(dataset.attrs["kind"]).capitalize()
    for axes, label in ((amplitude, kind), (residual, "Residual")):
        drawn_values = np.concatenate([line.get_ydata() for line in axes.lines])
        low, high = scales.log_limits(drawn_values, DECADES)
        scales.log_scale(axes, low / 1.5, high)
        axes.set_ylabel(f"{label} ({unit})")
    scales.phase_axis(phase)
    phase.set_ylabel("Phase (deg)")
    for axes in drawn.panels:
        axes.set_xlim(float(frequency[0]), float(frequency[-1]))
    drawn.label_x("Frequency (Hz)")


def _draw_frequencies(drawn: Sheet, dataset: xr.Dataset) -> None:
    upper, lower = drawn.panels
    modes = np.unique(dataset["mode"].values)
    handles = [line_handle("measured", color="0.3", **POINTS), line_handle("computed", color="0.3")]
    for number, mode in enumerate(modes):
        own = dataset.isel(sample=np.flatnonzero(dataset["mode"].values == mode))
        own = own.sortby("crank_angle")
        angle, look = reading.degrees(own["crank_angle"]), series_style(number)
        upper.plot(angle, own["measured"].values, color=look.color, **POINTS)
        upper.plot(angle, own["computed"].values, color=look.color, ls=look.linestyle, lw=0.9)
        lower.plot(angle, own["residual"].values, color=look.color, **POINTS)
        handles.append(
            line_handle(reading.mode_label([int(mode)]).lower(), color=look.color, lw=2.0)
        )
    drawn.header(handles, _title(dataset), of=dataset)
    scales.zero_line(lower)
    for axes, label in ((upper, "Natural frequency (Hz)"), (lower, "Residual (Hz)")):
        scales.crank_angle_axis(axes, np.unique(reading.degrees(dataset["crank_angle"])))
        axes.margins(x=MARK_ROOM)
        axes.autoscale(axis="x")
        scales.plain_numbers(axes)
        axes.set_ylabel(label)
    drawn.label_x("Crank angle (deg)")
