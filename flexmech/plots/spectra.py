"""Spectra of the running linkage's deflections, against its natural frequencies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from flexmech.plots.response import (
    LENGTH_UNITS,
    engine_handles,
    fitting_unit,
    link_label,
    run_title,
)
from flexmech.plots.style import (
    MID_GREY,
    header_height,
    header_legend,
    new_figure,
    publication_style,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["highest_frequency", "plot_spectrum", "spread"]


PANEL_HEIGHT = 1.5
LEAST_HEIGHT = 2.2
# What the axes of frequency and of harmonics take, in inches.
AXES_HEIGHT = 0.9
# Frequencies drawn, as a multiple of the highest natural frequency.
REACH = 1.3
# Depth of a spectrum below its peak that is drawn.
DECADES = 5.0
# Room above the peak for the bands' labels, as a part of the logarithmic scale.
HEADROOM = 0.14
BAND_COLOR = "#F5E6BE"
BAND_EDGE = "#DDB450"
ORDER_STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)
MOST_ORDERS = 16
MOST_ORDER_LINES = 100
# Least distance of two labels as a fraction of a panel's width.
LABEL_ROOM = 0.024


def plot_spectrum(dataset: xr.Dataset) -> Figure:
    """Draw the amplitude spectrum of each link's deflection, one panel a link.

    Shaded bands are the ranges that the predicted natural frequencies pass through over the
    run; the axis on top counts the harmonics of the crank's turning frequency.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result. One without natural frequencies (of a run too short for
        a spectrogram) is drawn without bands.

    Returns
    -------
    Figure
    """
    with publication_style():
        limit = highest_frequency(dataset, "spectrum_frequency")
        shown = dataset["spectrum_frequency"].values <= limit
        frequency = dataset["spectrum_frequency"].values[shown]
        bands = _bands(dataset)
        handles, title = engine_handles(dataset), run_title(dataset)
        if bands:
            handles.append(Patch(color=BAND_COLOR, lw=0, label="predicted natural frequencies"))
        links = [str(name) for name in dataset["link"].values]
        height = max(len(links) * PANEL_HEIGHT, LEAST_HEIGHT) + AXES_HEIGHT
        figure = new_figure(height + header_height(handles, title))
        panels = list(figure.subplots(len(links), 1, sharex=True, squeeze=False)[:, 0])
        panels[0].set_xlim(0.0, limit)
        for axes, link in zip(panels, links, strict=True):
            spectrum = dataset["spectrum"].sel(link=link).transpose("engine", "spectrum_frequency")
            amplitude = spectrum.values[:, shown]
            factor, unit = fitting_unit(amplitude, LENGTH_UNITS)
            _mark_bands(axes, bands)
            _draw_spectra(axes, frequency, factor * amplitude)
            axes.set_ylabel(f"{link_label(dataset, link)}\namplitude ({unit})")
        _label_bands(panels[0], bands)
        _order_axis(panels, abs(float(dataset.attrs["crank_speed"])) / (2 * np.pi), limit)
        panels[-1].set_xlabel("Frequency (Hz)")
        figure.align_ylabels()
        header_legend(figure, handles, title)
    return figure


def highest_frequency(dataset: xr.Dataset, name: str) -> float:
    """Highest frequency drawn in Hz: a little above the predictions, if there is data.

    Parameters
    ----------
    dataset : Dataset
    name : str
        Of the frequency coordinate.

    Returns
    -------
    float
    """
    end = float(dataset[name].max())
    if "natural_frequency" not in dataset:
        return end
    return min(end, REACH * float(dataset["natural_frequency"].max()))


def _bands(dataset: xr.Dataset) -> list[tuple[int, float, float]]:
    """Number of each mode with its lowest and highest natural frequency by any engine."""
    if "natural_frequency" not in dataset:
        return []
    frequency = dataset["natural_frequency"].transpose("mode", "engine", "window_time").values
    return [
        (int(mode), float(np.nanmin(values)), float(np.nanmax(values)))
        for mode, values in zip(dataset["mode"].values, frequency, strict=True)
    ]


def _mark_bands(axes: Axes, bands: list[tuple[int, float, float]]) -> None:
    for _, low, high in bands:
        # The edge line keeps a frequency that hardly moves visible.
        axes.axvspan(low, high, facecolor=BAND_COLOR, edgecolor=BAND_EDGE, lw=0.5, zorder=0)


def _label_bands(axes: Axes, bands: list[tuple[int, float, float]]) -> None:
    """Write f1, f2, ... over the bands, apart from each other where bands are close."""
    limit = axes.get_xlim()[1]
    wanted = np.array([(low + high) / 2 / limit for _, low, high in bands])
    for place, (mode, _, _) in zip(spread(wanted, LABEL_ROOM), bands, strict=True):
        axes.text(
            place,
            0.985,
            f"$f_{{{mode}}}$",
            transform=axes.transAxes,
            ha="center",
            va="top",
            fontsize=8,
            color="0.25",
        )


def spread(places: FloatArray, least: float) -> FloatArray:
    """Move places apart to a least distance, so that labels at them do not touch.

    Parameters
    ----------
    places : ndarray
        Ascending.
    least : float
        Distance that neighbours keep at least.

    Returns
    -------
    ndarray
        In the same order; places that had to move are centred on where they were.
    """
    rows: list[tuple[float, int]] = []  # centre and number of places that stand in a row
    for place in places.tolist():
        centre, count = place, 1
        while rows and centre - rows[-1][0] < (count + rows[-1][1]) * least / 2:
            before, many = rows.pop()
            centre = (centre * count + before * many) / (count + many)
            count += many
        rows.append((centre, count))
    return np.array(
        [centre + (n - (count - 1) / 2) * least for centre, count in rows for n in range(count)]
    )


def _draw_spectra(axes: Axes, frequency: FloatArray, amplitude: FloatArray) -> None:
    """Spectra of the engines; shape (engine, frequency), in the panel's unit."""
    highest = float(np.nanmax(amplitude, initial=0.0)) or 1.0
    width = 1.1 if frequency.size < 150 else 0.8
    for number, values in enumerate(amplitude):
        style = series_style(number)
        wider = 1.4 if number < len(amplitude) - 1 else 1.0
        axes.plot(frequency, values, color=style.color, linestyle=style.linestyle, lw=wider * width)
    lowest = max(float(np.nanmin(amplitude)), highest * 10.0**-DECADES)
    axes.set_yscale("log")
    lowest = min(lowest, 0.1 * highest)
    axes.set_ylim(lowest, highest * (highest / lowest) ** HEADROOM)
    axes.yaxis.set_major_locator(LogLocator(base=10, numticks=7))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _order_axis(panels: list[Axes], turning: float, limit: float) -> None:
    """Axis of harmonics of the turning frequency in Hz on top, with lines down at some."""
    orders = limit / turning
    step = next((s for s in ORDER_STEPS if orders <= s * MOST_ORDERS), None)
    if step is None:
        return
    labelled = np.arange(step, int(orders) + 1, step)
    top = panels[0].secondary_xaxis("top")
    top.set_xticks((labelled * turning).tolist())
    top.set_xticklabels([f"{order}" for order in labelled])
    if orders <= MOST_ORDER_LINES:
        top.set_xticks((np.arange(1, int(orders) + 1) * turning).tolist(), minor=True)
    top.set_xlabel("Harmonic of the crank's turning frequency")
    for axes in panels:
        for order in labelled:
            axes.axvline(order * turning, color=MID_GREY, lw=0.5, ls=":", zorder=0.5)
