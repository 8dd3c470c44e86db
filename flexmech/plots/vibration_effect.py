"""How far the links' own vibration moves the natural frequencies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots import angle_panels, scales
from flexmech.plots.labels import engine_label, mode_label
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import at_highest_speed, degrees, values_of
from flexmech.plots.series import SERIES_STYLES, Look, few_points, line_handle, series_style
from flexmech.plots.style import MID_GREY
from flexmech.types import FloatArray

# Of the engines, where there are several.
MARKS = "so^D"
MARK_SIZE = 3.6
# Narrowest axis of the difference in percent: below it one would look at round-off.
LEAST_DIFFERENCE = 1e-3
SAME = 1e-12
RUNNING: Look = {"lw": 1.1}
STILL: Look = {"color": "0.2", "ls": (0, (4.0, 2.0)), "lw": 0.9}


def plot_vibration_effect(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw natural frequencies of the running linkage next to the quasi-static ones.

    For the highest crank speed: a panel a mode with the frequencies about the states that a
    simulation runs through (solid) and about the quasi-static equilibrium (dashed), and at
    the bottom their relative difference. Only engines in which the two differ are drawn; in
    a linear model vibration changes nothing. If none differs, the first engine is drawn.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency`` and ``quasi_static_frequency`` (engine, crank_speed, crank_angle,
        mode) in Hz, angles in rad and speeds in rad/s.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode and one more. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    fastest, speed = at_highest_speed(dataset.sortby("crank_angle"))
    order = ("mode", "engine", "crank_angle")
    pair = [values_of(fastest[name], *order) for name in ("frequency", "quasi_static_frequency")]
    engines = _affected(*pair)
    running, still = (values[:, engines] for values in pair)
    names = [engine_label(dataset, engine) for engine in engines]
    angles, modes = degrees(fastest["crank_angle"]), fastest["mode"].values.tolist()
    tall = max(0.85, 1.5 - 0.1 * len(modes))
    ratios = [*[tall] * len(modes), 1.4]
    layout = grid(len(ratios), 1, sum(ratios) + 0.5, sharex=True, height_ratios=ratios)
    with sheet(layout, ax=ax) as drawn:
        title = f"Natural frequencies at {speed}, {' and '.join(names)}"
        drawn.header(_handles(modes, names), title, of=dataset)
        drawn.label_x("Crank angle (deg)")
        for mode, axes in enumerate(drawn.panels[:-1]):
            axes.set(title=mode_label(modes[mode : mode + 1]), ylabel="Frequency\n(Hz)")
            _draw_frequencies(axes, angles, running[mode], still[mode], series_style(mode).color)
            scales.scale_y(axes, [running[mode], still[mode]], least_part=scales.FREQUENCY_BAND)
        _draw_difference(drawn.panels[-1], angles, 100.0 * (running / still - 1.0))
        for axes in drawn.panels:
            scales.crank_angle_axis(axes, angles)
    return drawn.figure


def _affected(running: FloatArray, still: FloatArray) -> list[int]:
    """Engines whose two frequencies differ, or the first engine; shape (mode, engine, angle)."""
    differ = ~np.isclose(running, still, rtol=SAME, atol=0.0, equal_nan=True)
    numbers: list[int] = np.flatnonzero(differ.any(axis=(0, 2))).tolist()
    return numbers or [0]


def _draw_frequencies(
    axes: Axes, angles: FloatArray, running: FloatArray, still: FloatArray, color: str
) -> None:
    """Both frequencies of a mode; shape (engine, crank_angle)."""
    for number in range(len(running)):
        # One engine needs no marks to be told from others.
        marked = few_points(angles) or len(running) > 1
        mark: Look = {"marker": MARKS[number % 4] if marked else "", "ms": MARK_SIZE}
        mark["markevery"] = angle_panels.staggered(angles, number, len(running))
        axes.plot(angles, running[number], color=color, **RUNNING, **mark)
        axes.plot(angles, still[number], **STILL, **mark, mfc="white")


def _draw_difference(axes: Axes, angles: FloatArray, percent: FloatArray) -> None:
    """Relative differences in percent; shape (mode, engine, crank_angle)."""
    axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=0)
    for mode, engines in enumerate(percent):
        look = RUNNING | _mode_mark(mode)
        look["markevery"] = angle_panels.staggered(angles, mode, len(percent))
        for number, values in enumerate(engines):
            axes.plot(angles, values, ls="-" if number == 0 else ":", **look)
    scales.scale_y(axes, np.append(percent, 0.0), least=LEAST_DIFFERENCE)
    axes.set(title="Running against quasi-static", ylabel="Difference\n(%)")


def _mode_mark(number: int) -> Look:
    """Colour and mark of a mode: where the series' styles repeat, the marks are open."""
    style = series_style(number)
    fill = style.color if number < len(SERIES_STYLES) else "white"
    return {"color": style.color, "marker": style.marker, "ms": MARK_SIZE, "mfc": fill}


def _handles(modes: list[int], names: list[str]) -> list[Artist]:
    """Legend entries: the two lines of the upper panels, then a colour and mark a mode."""
    handles = [line_handle("running", color="0.2", **RUNNING), line_handle("quasi-static", **STILL)]
    for number, name in enumerate(names if len(names) > 1 else []):
        mark = {"ls": "", "marker": MARKS[number % 4], "ms": MARK_SIZE}
        handles.append(line_handle(name, color="0.2", **mark))
    handles += [line_handle(f"mode {mode}", **_mode_mark(n)) for n, mode in enumerate(modes)]
    return handles
