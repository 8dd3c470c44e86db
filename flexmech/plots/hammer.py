"""A hammer test: its records, and the modes identified from them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import style
from flexmech.plots.frf import (
    BLUE,
    CURVES,
    GREEN,
    ORANGE,
    angle_text,
    curve_handles,
    first_angle,
    hammer_title,
)
from flexmech.plots.layout import AxesLike, grid, sheet, tiles
from flexmech.plots.reading import LENGTH_UNITS, complex_values, fitting_unit, names_of

# Of three records, which fill half a page, of a circle with its axes, of the chart, and of a shape,
# which is flat; in inches.
HEIGHT, CIRCLE_HEIGHT, CHART_HEIGHT, SHAPE_HEIGHT = 4.6, 2.3, 3.0, 1.5
# More impacts hide each other and have no style of their own, more modes fill more than a page.
MOST_RECORDS = MOST_MODES = 6
# What is drawn of the force's record, in pulse durations about its start: the pulse takes a sixth.
BEFORE_PULSE, AFTER_PULSE = 2.0, 4.0
PULSE: style.Look = {"color": "0.75", "lw": 2.6}
DOTS: style.Look = {"marker": ".", "markersize": 4.0}
THREE = "give three Axes"

CIRCLE_DOTS: style.Look = {"marker": ".", "ms": 3.5, "ls": ""}

# Of the orders' axis, that the receptance behind the poles takes: its peaks end below the top.
BEHIND = 0.9
CURVE: style.Look = {"color": style.MID_GREY, "lw": 0.8, "zorder": 1}
EIGEN: style.Look = {"color": "0.1", "lw": 0.8, "ls": (0, (1, 2)), "zorder": 1.5}
POLE: style.Look = {"ls": "none", "marker": "o", "ms": 3.5, "color": BLUE}
# On the axis: modes that the fit keeps, since noise does not explain them as well.
IDENTIFIED = POLE | {"marker": "^", "ms": 6.5, "color": GREEN, "clip_on": False, "zorder": 5}
# Poles by their state: label and look.
STATES: dict[str, tuple[str, style.Look]] = {
    "new": ("new pole", POLE | {"marker": ".", "ms": 2.5, "color": "0.6", "mew": 0.0}),
    "frequency": ("stable in frequency", POLE | {"mfc": "white", "mew": 0.8}),
    "stable": ("stable in damping as well", POLE),
    "chosen": (
        "chosen to begin the fit",
        POLE | {"marker": "D", "ms": 5.5, "color": ORANGE, "zorder": 4},
    ),
}
NO_CHART = (
    "this hammer test has no stabilisation chart: its modes were identified by peaks and circles; "
    'install flexmech[modal-test] and ask for method="lscf"'
)

EIGEN_SHAPE: style.Look = {"color": "0.35", "lw": 1.0}
FOUND = POLE | {"ms": 4}
IMAGINARY = POLE | {"marker": "x", "color": ORANGE}
JOINT: style.Look = {"color": "0.8", "lw": 0.6, "zorder": 0}
NO_GRID = "this hammer test has no grid of impacts; ask for it by grid=N (--grid N)"


def plot_hammer(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw force pulse, response in time, and coherence over frequency.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result; the records of its first crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, three. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    data = first_angle(dataset)
    start, pulse = (float(data.attrs[name]) for name in ("pulse_start", "pulse"))
    time = data["time"].values
    count = min(MOST_RECORDS, data.sizes["average"])
    with sheet(grid(3, 1, HEIGHT), ax=ax, fewer=THREE) as drawn:
        # Impacts without noise are the same.
        count = count if data.attrs["noise"] else 1
        handles = [style.line_handle("force of the hammer", **PULSE)]
        for number in range(count):
            handles.append(style.series_handle(number, f"impact {number + 1}, as recorded", **DOTS))
        drawn.header(handles, hammer_title(dataset), of=dataset)
        force, response, coherence = drawn.panels
        scale, unit = fitting_unit(data["response"].values, LENGTH_UNITS)
        force.plot(1e3 * data["pulse_time"].values, data["pulse_force"].values, **PULSE)
        for number in reversed(range(count)):
            look = style.series_line(number) | {"lw": 0.8}
            force.plot(1e3 * time, data["force"].values[number], **(look | DOTS))
            response.plot(time, scale * data["response"].values[number], **look)
        force.set_xlim(1e3 * (start - BEFORE_PULSE * pulse), 1e3 * (start + AFTER_PULSE * pulse))
        force.set(xlabel="Time (ms)", ylabel="Force (N)")
        force.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
        response.set_xlim(0.0, float(time[-1]))
        response.set(xlabel="Time (s)", ylabel=f"Displacement ({unit})")
        look = style.series_line(0) | {"lw": 0.8}
        coherence.plot(data["frequency"].values, data["coherence"].values, **look)
        coherence.set_xlim(0.0, float(data["frequency"].values[-1]))
        coherence.set_ylim(min(0.0, float(np.nanmin(data["coherence"]))), 1.05)
        coherence.set(xlabel="Frequency (Hz)", ylabel="Coherence")
    return drawn.figure


def plot_nyquist(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the mobility about each mode: a viscously damped mode gives a circle.

    The dots are the measured lines near the mode. The natural frequency is the circle's far end.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result; up to six modes identified at its first crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If no mode was identified there.
    """
    data = first_angle(dataset)
    modes = np.flatnonzero(np.isfinite(data["identified_frequency"].values))[:MOST_MODES]
    if not len(modes):
        raise InputError("no mode was identified at the first crank angle: there is no circle")
    with sheet(
        tiles(len(modes), 3, CIRCLE_HEIGHT, narrow=2), ax=ax, fewer="give one Axes a mode"
    ) as drawn:
        drawn.header(curve_handles(**CIRCLE_DOTS), hammer_title(dataset), of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            _draw_circle(axes, data, int(mode))
        drawn.label_x("Re mobility (m/(N s))")
        drawn.label_y("Im mobility (m/(N s))")
    return drawn.figure


def _draw_circle(axes: Axes, data: xr.Dataset, mode: int) -> None:
    circle = data.isel(mode=mode)
    around = circle["circle_frequency"].values
    for curve in ("exact_receptance", "identified_receptance"):
        values = complex_values(circle, f"circle_{curve}") * 2j * np.pi * around
        axes.plot(values.real, values.imag, **CURVES[curve][1])
    frequency = data["frequency"].values
    near = (frequency >= around[0]) & (frequency <= around[-1])
    measured = complex_values(data, "receptance")[near] * 2j * np.pi * frequency[near]
    axes.plot(measured.real, measured.imag, **(CURVES["receptance"][1] | CIRCLE_DOTS))
    axes.axhline(0.0, color="0.7", lw=0.5, zorder=0)
    axes.axvline(0.0, color="0.7", lw=0.5, zorder=0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=4)
    for axis in (axes.xaxis, axes.yaxis):
        # In full, with a true minus sign.
        axis.set_major_formatter(lambda value, _: f"{value:.3g}".replace("-", "\N{MINUS SIGN}"))
    natural = float(circle["identified_frequency"])
    axes.set_title(f"Mode {int(circle['mode'])}: {natural:.5g} Hz", loc="left")


def plot_stabilisation(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the poles of models of rising order over frequency, at the first crank angle.

    Behind them is the receptance on a logarithmic scale of its own, and dotted are the natural
    frequencies of the eigen model. Triangles on the axis are the modes identified: a pole that was
    chosen to begin the fit is dropped by it where noise explains the receptances as well.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result whose modes were identified by LSCF.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is no chart.
    """
    if "chart_order" not in dataset:
        raise InputError(NO_CHART)
    words = dict(STATES.values()) | {"identified": IDENTIFIED}
    words |= {"receptance, logarithmic": CURVE, "eigen model": EIGEN}
    with sheet(grid(1, 1, CHART_HEIGHT), ax=ax) as drawn:
        drawn.header(
            style.line_handles(words), f"Stabilisation chart {_where(dataset)}", of=dataset
        )
        _draw_chart(drawn.panels[0], first_angle(dataset))
        drawn.label_x("Frequency (Hz)")
        drawn.label_y("Modes of the model")
    return drawn.figure


def _draw_chart(axes: Axes, one: xr.Dataset) -> None:
    orders = float(np.nanmax(one["chart_order"].values))
    lines = one["frequency"].values
    level = np.log(np.abs(complex_values(one, "receptance")))
    finite = np.isfinite(level)
    low, high = level[finite].min(), level[finite].max()
    part = (level - low) / (high - low) if high > low else np.zeros_like(level)
    axes.plot(lines[finite], BEHIND * orders * part[finite], **CURVE)
    for frequency in one["eigen_frequency"].values:
        if np.isfinite(frequency):
            axes.axvline(frequency, **EIGEN)
    state = one["chart_state"].values
    for name, (_, look) in STATES.items():
        which = state == name
        axes.plot(one["chart_frequency"].values[which], one["chart_order"].values[which], **look)
    identified = one["identified_frequency"].values
    axes.plot(identified, np.zeros_like(identified), **IDENTIFIED)
    axes.set(xlim=(0.0, float(lines[-1])), ylim=(0.0, 1.04 * orders))


def _where(dataset: xr.Dataset) -> str:
    """At which crank angle a test is drawn, and where the response is."""
    response = dataset.attrs["response_point"]
    return f"at crank angle {angle_text(first_angle(dataset))}, response at {response}"


def plot_impact_shapes(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw identified mode shapes over the links, on those of the eigen model.

    The links follow each other along the axis, a unit each. The greatest entry of an identified
    shape is 1, so that its imaginary part shows how complex it is.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result with a grid of impacts; up to six modes identified at its first
        crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is no grid, or no mode was identified there.
    """
    if "point" not in dataset.dims:
        raise InputError(NO_GRID)
    data = first_angle(dataset)
    modes = np.flatnonzero(np.isfinite(data["shape_real"].values).all(axis=0))[:MOST_MODES]
    if not len(modes):
        raise InputError("no mode was identified at the first crank angle: there is no shape")
    words = {
        "eigen model": EIGEN_SHAPE,
        "identified, real part": FOUND,
        "imaginary part": IMAGINARY,
    }
    layout = tiles(len(modes), 2, SHAPE_HEIGHT, extra=0.3)
    with sheet(layout, ax=ax, fewer="give one Axes a mode") as drawn:
        drawn.header(style.line_handles(words), f"Mode shapes {_where(dataset)}", of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            _draw_shape(axes, data.isel(mode=int(mode)))
        drawn.label_x("Link")
        drawn.label_y("Displacement (-)")
    return drawn.figure


def _draw_shape(axes: Axes, data: xr.Dataset) -> None:
    links = names_of(data, "link")
    own = np.array([links.index(name) for name in names_of(data, "point_link")])
    place = own + data["point_fraction"].values
    for number in range(len(links)):
        which = own == number
        axes.plot(place[which], data["eigen_shape_real"].values[which], **EIGEN_SHAPE)
        axes.axvline(number + 1, **JOINT)
    axes.plot(place, data["shape_imag"].values, **IMAGINARY)
    axes.plot(place, data["shape_real"].values, **FOUND)
    axes.set(xlim=(0.0, len(links)), ylim=(-1.15, 1.15))
    axes.set_xticks(np.arange(len(links)) + 0.5, links)
    axes.tick_params(axis="x", length=0)
    of = f"MAC {float(data['mac']):.4f}, MCF {float(data['complexity_factor']):.2g}"
    axes.set_title(f"Mode {int(data['mode'])}: {of}", loc="left")
