"""Natural frequencies against crank angle, by crank speed, and damping ratios, by mode."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.errors import InputError
from flexmech.plots import angle_panels, reading, scales, style
from flexmech.plots.angle_panels import Between, colour_bar, has_many_speeds, speed_lines
from flexmech.plots.layout import AxesLike, sheet
from flexmech.plots.style import Look, line_handle

# Two modes whose bands are this close in ratio can exchange branches: frequencies that veer are
# less than a tenth apart. Modes further apart only seem to, where the crank angles are too coarse.
NEAR_BANDS = 1.1

# Veering can last for a large part of the turn: a strip of this part of a mode's height is seen and
# hides no line.
VEERING_STRIP = 0.035
STRIP: Look = {"color": "0.72", "lw": 0}

# More panels than these are too many to compare, and six fill three rows of two.
MOST_SPEEDS = 6
# Narrowest axis of damping as a part of the mean ratio, which is known to two digits at best.
LEAST_BAND = 0.02


def plot_frequencies(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw natural frequencies against crank angle, one panel a mode, one line a speed.

    Modes lie far apart and the crank speed moves them by about one per cent, so each mode
    has a panel with its own frequency axis. Modes between which a tracked branch passes
    (crossing or veering) share a panel, in which each line follows a branch and is numbered
    by it at its right end. The first engine is drawn as lines, the second as markers;
    a grey strip on the crank-angle axis shows where veering was flagged. More than five speeds
    are coloured by a scale beside the panels, and the first engine is drawn alone.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result; frequencies in Hz, angles in rad, speeds in rad/s.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = dataset.sortby("crank_angle")
    groups, angles = mode_groups(dataset), reading.degrees(dataset["crank_angle"])
    frequency, branch = (
        reading.values_of(dataset[name], *reading.MAP) for name in ("frequency", "branch_of_mode")
    )
    veering = dataset["veering"].transpose(*reading.MAP).values.astype(bool)[0]
    layout = angle_panels.angle_layout([len(group) for group in groups])
    with sheet(layout, ax=ax, fewer=angle_panels.ONE_MODE) as drawn:
        looks = speed_lines(dataset) if has_many_speeds(dataset) else []
        if looks:
            handles = [line_handle(reading.engine_label(dataset), color=style.MID_GREY)]
        else:
            handles = angle_panels.series_and_engines(dataset, reading.speed_texts(dataset))
        if veering.any():
            handles.append(Patch(**STRIP, label="veering"))
        drawn.header(handles, of=dataset)
        angle_panels.label_angles(drawn, angles, "Frequency (Hz)")
        between = points_between(dataset)
        for axes, group in zip(drawn.panels, groups, strict=True):
            drawn.title(axes, reading.mode_label(dataset["mode"].values[group].tolist()))
            scales.scale_y(axes, frequency[..., group], least_part=scales.FREQUENCY_BAND)
            _mark_veering(axes, angles, veering[..., group])
            of_group = [_of_modes(each, group) for each in between]
            _draw_speeds(
                axes, angles, frequency[..., group], branch[0][..., group], of_group, looks
            )
        colour_bar(drawn, dataset)
    return drawn.figure


def mode_groups(dataset: xr.Dataset) -> list[list[int]]:
    """Modes that share a panel: neighbours between which a tracked branch passes.

    Frequencies sorted at each angle keep to one panel a mode until two branches cross or
    veer; then the branch is what a reader follows, and both modes belong in one panel.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency`` and ``branch_of_mode``, sorted by crank angle.

    Returns
    -------
    list of list of int
        Positions along the mode dimension, ascending.
    """
    branch = dataset["branch_of_mode"].transpose(*reading.MAP).values
    frequency = dataset["frequency"].transpose(*reading.MAP).values
    before, after = branch[:, :, :-1], branch[:, :, 1:]
    highest, lowest = np.nanmax(frequency, axis=2), np.nanmin(frequency, axis=2)
    near = np.any(lowest[..., 1:] <= NEAR_BANDS * highest[..., :-1], axis=(0, 1))
    n_modes = frequency.shape[-1]
    joined = np.zeros(n_modes, dtype=bool)
    for low in range(n_modes):
        for high in range(low + 1, n_modes):
            rises = np.any(before[..., low] == after[..., high])
            falls = np.any(before[..., high] == after[..., low])
            if (rises or falls) and np.all(near[low:high]):
                joined[low:high] = True
    cuts = np.flatnonzero(~joined[:-1]) + 1
    return [group.tolist() for group in np.split(np.arange(n_modes), cuts)]


def _mark_veering(axes: Axes, angles: FloatArray, veering: NDArray[np.bool_]) -> None:
    """Grey strip along the axis where a mode veers at any speed; (speed, angle, mode)."""
    # A flagged angle stands for the interval half way to its neighbours.
    edges = np.clip(reading.cell_edges(angles), angles[0], angles[-1])
    height = VEERING_STRIP / veering.shape[-1]
    for run in unbroken_runs(np.any(veering, axis=(0, 2))):
        axes.axvspan(edges[run.start], edges[run.stop], ymax=height, **STRIP, zorder=0)


def points_between(dataset: xr.Dataset) -> list[Between]:
    """Points of the first engine's lines between the crank angles, one entry a crank speed.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency_between`` and ``branch_between``, or without.

    Returns
    -------
    list of Between
        Without points where the dataset holds none.
    """
    count, modes = dataset.sizes["crank_speed"], dataset.sizes["mode"]
    if "frequency_between" not in dataset:
        nothing = np.zeros((0, modes))
        return [Between(np.zeros(0), nothing, nothing)] * count
    order = ("crank_speed", "between_angle", "mode")
    values, branch = (
        reading.values_of(dataset[f"{n}_between"], *order) for n in ("frequency", "branch")
    )
    angles = reading.degrees(dataset["between_angle"])
    return [Between(angles, *each) for each in zip(values, branch, strict=True)]


def _of_modes(between: Between, group: list[int]) -> Between:
    """Points of some modes; those of one mode alone are one line, whatever their branches."""
    values, branch = between.values[:, group], between.branch[:, group]
    return Between(between.angles, values, branch if len(group) > 1 else np.zeros_like(branch))


def _draw_speeds(
    axes: Axes,
    angles: FloatArray,
    frequency: FloatArray,
    branch: FloatArray,
    between: list[Between],
    looks: list[Look],
) -> None:
    """All speeds in one panel: frequency (engine, speed, angle, mode), branch without engine.

    Of many speeds each has its look, and the first engine is drawn alone.
    """
    _, n_speeds, _, n_modes = frequency.shape
    # One mode alone is one line: sorted frequencies do not jump.
    along = branch if n_modes > 1 else np.zeros_like(branch)
    for number, points in enumerate(between):
        if looks:
            lines = angle_panels.branch_lines(frequency[0, number], along[number])
            for of_branch, line in lines.items():
                axes.plot(*points.among(angles, line, of_branch), **looks[number])
        else:
            series = along[number], number, n_speeds, points
            lines = angle_panels.draw_series(axes, angles, frequency[:, number], *series)
        if number == 0 and n_modes > 1:
            _number_branches(axes, lines)


def _number_branches(axes: Axes, lines: dict[int, FloatArray]) -> None:
    """Write each branch's number beside the right end of its line, spread to be read."""
    ends = sorted((float(line[-1]), number) for number, line in lines.items())
    there = [(end, number) for end, number in ends if np.isfinite(end)]
    least = 0.07 * float(np.ptp(axes.get_ylim()))
    heights = reading.spread(np.array([end for end, _ in there]), least)
    look: Look = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    look |= {"va": "center", "fontsize": style.LABEL_POINTS, "color": style.MID_GREY}
    for height, (_, number) in zip(heights, there, strict=True):
        axes.annotate(f"branch {number}", (1.0, height), xytext=(6, 0), **look)


def plot_modal_damping(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the damping ratio by modal strain energy, one panel a speed, one line a mode.

    Modes are in order of frequency at each angle. Where two of them change places a line
    breaks off and goes on elsewhere: it does not join the damping of different vibrations.
    The first engine is drawn as lines, the others as markers. Of more than six speeds, six
    are drawn, evenly spread.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result of a mechanism with specific damping.
    ax : Axes or sequence of Axes, optional
        The user's, one a speed. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no ``strain_energy_damping``.
    """
    if "strain_energy_damping" not in dataset:
        raise InputError(
            "this result has no damping by modal strain energy: give the mechanism sections "
            "with specific damping, then compute moving_frequencies"
        )
    return _draw_damping(dataset, "strain_energy_damping", "Damping by modal strain energy", ax)


def plot_damping_ratio(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the damping ratio -Re(lambda)/abs(lambda) of frozen positions, one panel a speed.

    As :func:`plot_modal_damping`. With rotation terms frozen eigenvalues have damping ratios of
    either sign that are no damping; an undamped mechanism has these alone.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a speed. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    title = "Kelvin-Voigt damping of frozen positions"
    if dataset.attrs.get("damped_by", "Kelvin-Voigt") != "Kelvin-Voigt":
        title = "Damping ratios of frozen positions"
    return _draw_damping(dataset, "damping_ratio", title, ax)


def _draw_damping(dataset: xr.Dataset, name: str, title: str, ax: AxesLike | None) -> Figure:
    count = dataset.sizes["crank_speed"]
    # The first and the last among them.
    places = np.round(np.linspace(0, count - 1, min(count, MOST_SPEEDS))).astype(int)
    dataset = dataset.sortby("crank_angle").isel(crank_speed=places)
    percent = 100.0 * reading.values_of(dataset[name], *reading.MAP)
    branch = reading.values_of(dataset["branch_of_mode"], *reading.MAP)[0]
    _, n_speeds, _, n_modes = percent.shape
    angles = reading.degrees(dataset["crank_angle"])
    layout = angle_panels.angle_layout([1] * n_speeds, share_y=True)
    with sheet(layout, ax=ax, fewer="choose one speed (speeds=...)") as drawn:
        modes = [f"mode {mode}" for mode in dataset["mode"].values]
        handles = angle_panels.series_and_engines(dataset, modes)
        drawn.header(handles, title, of=dataset)
        angle_panels.label_angles(drawn, angles, "Damping ratio (%)")
        for speed, (axes, text) in enumerate(
            zip(drawn.panels, reading.speed_texts(dataset), strict=True)
        ):
            drawn.title(axes, text)
            scales.scale_y(axes, percent, least_part=LEAST_BAND)
            for mode in range(n_modes):
                one = slice(mode, mode + 1)
                values, along = percent[:, speed, :, one], branch[speed, :, one]
                angle_panels.draw_series(axes, angles, values, along, mode, n_modes)
    return drawn.figure
