"""A hammer test: its records, and the modes identified from them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.plots import style
from flexmech.plots.drawing import figure
from flexmech.plots.frf import (
    BLUE,
    CURVES,
    GREEN,
    ORANGE,
    READ,
    angle_text,
    curve_handles,
    first_angle,
    hammer_title,
)
from flexmech.plots.layout import AxesLike, grid, sheet, tiles
from flexmech.plots.picture import Curve, Pane, Picture, Span
from flexmech.plots.reading import (
    FORCE_UNITS,
    LENGTH_UNITS,
    complex_values,
    fitting_unit,
    names_of,
)
from flexmech.plots.style import series_line

# Heights in inches: a record, three of which fill half a page; a circle with its axes; the chart;
# and a shape, which is flat.
HEIGHT, CIRCLE_HEIGHT, CHART_HEIGHT, SHAPE_HEIGHT = 1.53, 2.3, 3.0, 1.5
# More impacts hide each other and have no style of their own, more modes fill more than a page.
MOST_RECORDS = MOST_MODES = 6
# So many waves of a decaying response can be distinguished in a panel, and below this part of its
# greatest displacement it cannot be distinguished from zero.
MOST_WAVES, LEAST_SEEN = 100, 0.02
# What is drawn of the force's record, in pulse durations about its start: the pulse takes a sixth.
BEFORE_PULSE, AFTER_PULSE = 2.0, 4.0
PULSE: style.Look = {"color": "0.75", "lw": 2.6}
DOTS: style.Look = {"marker": ".", "markersize": 4.0}
EXACT = "exact_receptance"
HAMMER, FEWER = "force of the hammer", "give one Axes a record"

CIRCLE_DOTS: style.Look = {"marker": ".", "ms": 3.5, "ls": ""}
# More dots on an arc than these hide the lines under them.
MOST_DOTS = 40
# Least width over length of an arc that shows a circle. Narrower is the
# curve of the other modes, with a kink where the mode is.
LEAST_WIDTH = 0.4

# Part of the orders' axis that the receptance behind the poles takes: its peaks end below the
# top.
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
    'install the extra modal-test and ask for method="lscf"'
)

EIGEN_SHAPE: style.Look = {"color": "0.35", "lw": 1.0}
FOUND = POLE | {"ms": 4}
IMAGINARY = POLE | {"marker": "x", "color": ORANGE}
JOINT: style.Look = {"color": "0.8", "lw": 0.6, "zorder": 0}
NO_GRID = "this hammer test has no grid of impacts; ask for it by grid=N (--grid N)"


@figure
def plot_hammer(dataset: xr.Dataset) -> Picture:
    """Draw force pulse, response in time, and coherence over frequency.

    The response is drawn from its beginning up to where waves can be distinguished. Without noise
    the coherence is 1 at all frequencies, and has no panel.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``HammerTest`` result; the records of its first crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, three, or two without noise. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    data = first_angle(dataset)
    start, pulse = (float(data.attrs[name]) for name in ("pulse_start", "pulse"))
    time = data["time"].values
    # Impacts without noise are the same.
    noisy = bool(data.attrs["noise"])
    count = min(MOST_RECORDS, data.sizes["average"]) if noisy else 1
    forces = [Curve(1e3 * data["pulse_time"].values, data["pulse_force"].values, PULSE, HAMMER)]
    responses = list[Curve]()
    for number in range(count):
        # The first impact lies above the others.
        look = series_line(number) | {"lw": 0.8, "zorder": 2.5 - 0.01 * number}
        name = f"impact {number + 1}, as recorded"
        forces.append(Curve(1e3 * time, data["force"].values[number], look | DOTS, name))
        responses.append(Curve(time, data["response"].values[number], look))
    end = _seen_until(time, data["response"].values[0])
    of_all = "" if end == time[-1] else f", beginning of a record of {time[-1]:.3g} s"
    around = 1e3 * (start - BEFORE_PULSE * pulse), 1e3 * (start + AFTER_PULSE * pulse)
    panes = [
        Pane("Force", forces, FORCE_UNITS, along="Time (ms)", x_limits=around),
        Pane(
            "Displacement", responses, LENGTH_UNITS, along=f"Time (s){of_all}", x_limits=(0.0, end)
        ),
    ]
    if noisy:
        frequency, coherence = data["frequency"].values, data["coherence"].values
        line = Curve(frequency, coherence, series_line(0) | {"lw": 0.8})
        ends, limits = (0.0, float(frequency[-1])), (min(0.0, float(np.nanmin(coherence))), 1.05)
        along = "Frequency (Hz)"
        panes.append(Pane("Coherence", [line], limits=limits, along=along, x_limits=ends))
    layout = grid(len(panes), 1, len(panes) * HEIGHT)
    return Picture(panes, "", dataset, hammer_title(dataset), layout=layout, fewer=FEWER)


def _seen_until(time: FloatArray, response: FloatArray) -> float:
    """Time up to which the waves of a response can be seen, and distinguished, in s."""
    size = np.abs(response)
    seen = int(np.flatnonzero(size >= LEAST_SEEN * size.max())[-1]) + 1
    crossings = np.flatnonzero(np.diff(np.signbit(response)))
    # Two crossings of zero are a wave.
    distinct = int(crossings[2 * MOST_WAVES]) if crossings.size > 2 * MOST_WAVES else len(time) - 1
    return float(time[min(seen, distinct, len(time) - 1)])


def plot_nyquist(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the mobility about each mode: a viscously damped mode gives a circle.

    The dots are measured lines near the mode. The natural frequency is the circle's far end. A
    mode that hardly moves these points has no circle, and is left out, which the heading says.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``HammerTest`` result; up to six modes identified at its first crank angle are
        drawn.
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
    identified = np.flatnonzero(np.isfinite(data["identified_frequency"].values))
    if not len(identified):
        raise InputError("no mode was identified at the first crank angle: there is no circle")
    round_ones = [mode for mode in identified if _is_circle(_mobility(data.isel(mode=mode), EXACT))]
    modes = np.array(round_ones or identified)[:MOST_MODES]
    flat = [str(data["mode"].values[mode]) for mode in identified if mode not in round_ones]
    title = f"Mobility about each mode. {hammer_title(dataset)}"
    if flat and round_ones:
        title += f"; without a circle here: mode{'s' * (len(flat) > 1)} {', '.join(flat)}"
    with sheet(
        tiles(len(modes), 3, CIRCLE_HEIGHT, narrow=2), ax=ax, fewer="give one Axes a mode"
    ) as drawn:
        drawn.header(curve_handles(**CIRCLE_DOTS), title, of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            _draw_circle(axes, data, int(mode))
    return drawn.figure


def _mobility(circle: xr.Dataset, curve: str) -> ComplexArray:
    """Mobility of one of the curves about a mode, in m/(N s)."""
    around = circle["circle_frequency"].values
    return np.asarray(complex_values(circle, f"circle_{curve}") * 2j * np.pi * around)


def _is_circle(mobility: ComplexArray) -> bool:
    """Whether an arc is wide enough over its length to show a circle."""
    places = np.column_stack([mobility.real, mobility.imag])
    places = places - places.mean(axis=0)
    along = np.linalg.svd(places, full_matrices=False)[2]
    length, width = np.ptp(places @ along.T, axis=0)
    return bool(width >= LEAST_WIDTH * length)


def _draw_circle(axes: Axes, data: xr.Dataset, mode: int) -> None:
    circle = data.isel(mode=mode)
    around = circle["circle_frequency"].values
    exact = _mobility(circle, EXACT)
    span = np.array([np.ptp(exact.real), np.ptp(exact.imag)])
    factor, unit = fitting_unit(span, READ["m/(N s)"])
    for curve in (EXACT, "identified_receptance"):
        values = factor * _mobility(circle, curve)
        axes.plot(values.real, values.imag, **CURVES[curve][1])
    frequency = data["frequency"].values
    near = np.flatnonzero((frequency >= around[0]) & (frequency <= around[-1]))
    near = near[:: -(-near.size // MOST_DOTS) or 1]
    measured = factor * complex_values(data, "receptance")[near] * 2j * np.pi * frequency[near]
    axes.plot(measured.real, measured.imag, **(CURVES["receptance"][1] | CIRCLE_DOTS))
    # Zero is shown where it is near, and does not widen the axes: the circle fills its panel.
    across, up = axes.get_yaxis_transform(), axes.get_xaxis_transform()
    for line in (Line2D([0, 1], [0, 0], transform=across), Line2D([0, 0], [0, 1], transform=up)):
        line.set(color="0.7", lw=0.5, zorder=0)
        axes.add_artist(line)
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=3 if style.is_narrow() else 4)
    axes.set(xlabel=f"Re ({unit})", ylabel=f"Im ({unit})")
    for axis in (axes.xaxis, axes.yaxis):
        # In full, with a true minus sign.
        axis.set_major_formatter(lambda value, _: f"{value:.3g}".replace("-", "\N{MINUS SIGN}"))
    natural = float(circle["identified_frequency"])
    axes.set_title(f"Mode {int(circle['mode'])}: {natural:.5g} Hz", loc="left")


@figure
def plot_stabilisation(dataset: xr.Dataset) -> Picture:
    """Draw the poles of models of rising order over frequency, at the first crank angle.

    Behind them is the receptance on a logarithmic scale of its own, and dotted are the natural
    frequencies of the eigen model. Triangles on the axis are the modes identified: a pole that was
    chosen to begin the fit is dropped by it where noise explains the receptances as well.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``HammerTest`` result whose modes were identified by LSCF.
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
    one = first_angle(dataset)
    orders = float(np.nanmax(one["chart_order"].values))
    frequency, level = one["frequency"].values, np.log(np.abs(complex_values(one, "receptance")))
    finite = np.isfinite(level)
    low, span = level[finite].min(), np.ptp(level[finite])
    behind = BEHIND * orders * (level[finite] - low) / (span or 1.0)
    curves = [Curve(frequency[finite], behind, CURVE, "receptance, logarithmic")]
    for state, (words, look) in STATES.items():
        which = one["chart_state"].values == state
        place, order = one["chart_frequency"].values[which], one["chart_order"].values[which]
        curves.append(Curve(place, order, look, words))
    identified = one["identified_frequency"].values
    curves.append(Curve(identified, np.zeros_like(identified), IDENTIFIED, "identified"))
    spans = [
        Span(at, at, EIGEN, "eigen model", upright=True)
        for at in one["eigen_frequency"].values.tolist()
        if np.isfinite(at)
    ]
    pane = Pane("Modes of the model", curves, spans=spans, limits=(0.0, 1.04 * orders))
    title, ends = f"Stabilisation chart {_where(dataset)}", np.array([0.0, frequency[-1]])
    layout = grid(1, 1, CHART_HEIGHT)
    return Picture([pane], "Frequency (Hz)", dataset, title, places=ends, layout=layout)


def _where(dataset: xr.Dataset) -> str:
    """At which crank angle a test is drawn, and where the response is."""
    response = dataset.attrs["response_point"]
    return f"at crank angle {angle_text(first_angle(dataset))}, response at {response}"


@figure
def plot_impact_shapes(dataset: xr.Dataset) -> Picture:
    """Draw identified mode shapes over the links, on those of the eigen model.

    The links follow each other along the axis, a unit each. The greatest entry of an identified
    shape is 1, so that its imaginary part shows how complex it is.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``HammerTest`` result with a grid of impacts; up to six modes identified at its
        first crank angle are drawn.
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
    panes = [_shape(data.isel(mode=int(mode))) for mode in modes]
    return Picture(
        panes,
        "Link",
        dataset,
        f"Mode shapes {_where(dataset)}",
        "Displacement (-)",
        places=np.array([0.5, data.sizes["link"] + 0.5]),
        layout=tiles(len(modes), 2, SHAPE_HEIGHT, extra=0.3),
        fewer="give one Axes a mode",
    )


def _shape(data: xr.Dataset) -> Pane:
    """Shapes of a mode: the middle of link n stands at n."""
    links = names_of(data, "link")
    number = np.array([links.index(name) for name in names_of(data, "point_link")])
    place = number + 0.5 + data["point_fraction"].values
    eigen, curves = data["eigen_shape_real"].values, list[Curve]()
    for which in (number == link for link in range(len(links))):
        curves.append(Curve(place[which], eigen[which], EIGEN_SHAPE, "eigen model"))
    curves.append(Curve(place, data["shape_imag"].values, IMAGINARY, "imaginary part"))
    curves.append(Curve(place, data["shape_real"].values, FOUND, "identified, real part"))
    of = f"MAC {float(data['mac']):.4f}, MCF {float(data['complexity_factor']):.2g}"
    return Pane(
        "",
        curves,
        title=f"Mode {int(data['mode'])}: {of}",
        spans=[Span(n + 0.5, n + 0.5, JOINT, upright=True) for n in range(1, len(links))],
        limits=(-1.15, 1.15),
        named=links,
    )
