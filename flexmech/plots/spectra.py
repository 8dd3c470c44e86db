"""Spectra of the running linkage's deflections, with its natural frequencies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales, style
from flexmech.plots.drawing import drawing
from flexmech.plots.layout import AxesLike, grid
from flexmech.plots.picture import Curve, Note, Pane, Picture, Span
from flexmech.plots.style import Look, series_line, series_style

ONE_LINK = "choose one link (links=...)"

# Frequencies drawn, as a multiple of the highest natural frequency: its band is seen whole.
REACH = 1.3
# Depth of a spectrum below its peak that is drawn: less is the error of the time step.
DECADES = 5.0
# Room above the peak for the bands' labels, as a part of the logarithmic scale.
HEADROOM = 0.14
# The edge keeps a frequency that hardly moves visible.
BAND: Look = {"facecolor": "#F5E6BE", "edgecolor": "#DDB450", "lw": 0.5, "zorder": 0}
ORDER_STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)
# Orders with numbers, half as many on a narrow page, and orders with ticks: more would touch.
MOST_ORDERS, MOST_ORDER_LINES = 16, 100
# Least distance of two labels in inches: the width of one.
LABEL_ROOM = 0.15


def plot_spectrum(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the amplitude spectrum of each link's deflection, one panel a link.

    The amplitudes of a periodic motion stand as stems at the orders of the crank, those of further
    engines as open marks; what is between the orders, as thin lines, does not repeat. Shaded bands
    are the ranges that the predicted natural frequencies pass through over a turn, or over the
    crank angles that a law passes; the axis on top counts the harmonics of the crank's turning
    frequency.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a link. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    picture = spectrum_picture(dataset)
    with drawing(picture, ax=ax) as drawn:
        # A law of motion has no orders.
        if "drive" not in dataset.attrs:
            turning = abs(float(dataset.attrs["crank_speed"])) / (2 * np.pi)
            _order_axis(drawn.panels, turning, float(picture.places[-1]))
    return drawn.figure


def spectrum_picture(dataset: xr.Dataset) -> Picture:
    """Spectra of deflections over the bands of natural frequencies, as of plot_spectrum."""
    bands = _bands(dataset)
    highest = max((high for _, high in bands.values()), default=np.inf)
    limit = min(float(dataset["spectrum_frequency"].max()), REACH * highest)
    within = dataset.sel(spectrum_frequency=slice(0.0, limit))
    spans = tuple(
        Span(*band, BAND, "predicted natural frequencies", upright=True) for band in bands.values()
    )
    first, *others = (_pane(within, link, spans) for link in reading.bending_links(dataset))
    panes = [replace(first, notes=_names_of_bands(bands, limit)), *others]
    return Picture(
        panes,
        "Frequency (Hz)",
        dataset,
        reading.run_title(dataset),
        places=np.array([0.0, limit]),
        layout=grid(len(panes), 1, max(1.5 * len(panes), 2.2) + style.AXES_HEIGHT, sharex=True),
        fewer=ONE_LINK,
    )


def _bands(dataset: xr.Dataset) -> dict[int, tuple[float, float]]:
    """Lowest and highest natural frequency of each mode; none of a file of an earlier version."""
    if "lowest_natural_frequency" not in dataset:
        return {}
    ends = (dataset[f"{end}_natural_frequency"].values for end in ("lowest", "highest"))
    modes = dataset["mode"].values
    return {int(mode): (float(a), float(b)) for mode, a, b in zip(modes, *ends, strict=True)}


def _names_of_bands(bands: dict[int, tuple[float, float]], limit: float) -> list[Note]:
    """f1, f2, ... over the bands, apart from each other where bands are close."""
    wanted = np.array([(low + high) / 2 for low, high in bands.values()])
    room = limit * LABEL_ROOM / (style.figure_width() - style.BESIDE_PANELS)
    look: Look = {"ha": "center", "va": "top", "fontsize": "small", "color": "0.25"}
    return [
        Note(float(place), 0.985, f"$f_{{{mode}}}$", look, high=True)
        for place, mode in zip(reading.spread(wanted, room), bands, strict=True)
    ]


def _pane(dataset: xr.Dataset, link: str, spans: tuple[Span, ...]) -> Pane:
    """Spectra of one link's deflection by all engines, on a logarithmic axis."""
    # The orders of a periodic motion stand so many frequencies apart.
    turns = int(dataset.attrs.get("spectrum_turns", 0))
    spectrum = dataset["spectrum"].sel(link=link)
    amplitude = reading.values_of(spectrum, "engine", "spectrum_frequency")
    frequency = spectrum["spectrum_frequency"].values
    highest = float(np.nanmax(amplitude, initial=0.0)) or 1.0
    # The first stem is order 1, and values between the stems do not count for the axis.
    amplitude, frequency = amplitude[:, turns:], frequency[turns:]
    least = np.nanmin(amplitude[:, :: turns or 1], initial=highest)
    lowest = float(np.clip(least, highest * 10.0**-DECADES, 0.1 * highest))
    width, curves = 1.1 if amplitude.shape[1] < 150 else 0.8, list[Curve]()
    for number, values in enumerate(amplitude):
        name = reading.engine_label(dataset, number)
        if turns:
            curves += _stems(frequency, values, turns, number, lowest, name)
        else:
            wider = 1.4 if number < len(amplitude) - 1 else 1.0
            curves.append(
                Curve(frequency, values, series_line(number) | {"lw": wider * width}, name)
            )
    return Pane(
        f"{reading.link_label(dataset, link)}\namplitude",
        curves,
        reading.LENGTH_UNITS,
        spans=spans,
        limits=(lowest, highest * (highest / lowest) ** HEADROOM),
        scale="log",
    )


def _stems(
    frequency: FloatArray, values: FloatArray, turns: int, number: int, lowest: float, name: str
) -> list[Curve]:
    """Amplitudes at the orders, and what is between them; the first one is order 1."""
    color, at, size = series_style(number).color, frequency[::turns], values[::turns]
    curves = [Curve(at, size, _stem_mark(number), f"{name}, at orders")]
    if number == 0:
        # From the axis up, with a gap after each of them.
        up = np.stack([np.full(len(size), lowest), size, np.full(len(size), np.nan)], axis=-1)
        curves.append(Curve(np.repeat(at, 3), up.ravel(), {"color": color, "lw": 0.8}))
    if turns > 1:
        between = np.where(np.arange(len(values)) % turns, values, np.nan)
        # A line that ends beside each order.
        look: Look = {"color": color, "lw": 0.5, "alpha": 0.7, "zorder": 1.5}
        curves.append(Curve(frequency, between, look))
    return curves


def _stem_mark(number: int) -> Look:
    look, first = series_style(number), number == 0
    fill: Look = {"ms": 2.6 if first else 3.6, "mfc": look.color if first else "none", "mew": 0.8}
    return {"ls": "", "marker": look.marker, "color": look.color, "zorder": 3} | fill


def _order_axis(panels: list[Axes], turning: float, limit: float) -> None:
    """Axis of harmonics of the turning frequency in Hz on top, with lines down at some."""
    orders = limit / turning
    most = MOST_ORDERS // 2 if style.is_narrow() else MOST_ORDERS
    step = int(scales.round_step(orders, most, ORDER_STEPS))
    labelled = np.arange(step, int(orders) + 1, step)
    top = panels[0].secondary_xaxis("top")
    top.set_xticks((labelled * turning).tolist(), [f"{order}" for order in labelled])
    if orders <= MOST_ORDER_LINES:
        top.set_xticks((np.arange(1, int(orders) + 1) * turning).tolist(), minor=True)
    top.set_xlabel("Harmonic of the crank's turning frequency")
    for axes in panels:
        for order in labelled:
            axes.axvline(order * turning, color=style.MID_GREY, lw=0.5, ls=":", zorder=0.5)
