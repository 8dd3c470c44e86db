"""Natural frequencies over crank angle and over crank speed, and damping ratios."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.plots import angle_panels, reading, scales, style
from flexmech.plots.angle_panels import Between, has_many_speeds, speed_colours, speed_lines
from flexmech.plots.drawing import figure
from flexmech.plots.picture import Curve, Pane, Picture, Span, over_angles
from flexmech.plots.style import Look

# Two modes whose bands are this close in ratio can exchange branches: frequencies that veer are
# less than a tenth apart. Modes further apart only seem to, where the crank angles are too coarse.
NEAR_BANDS = 1.1

# Veering can last for a large part of the turn: a strip of this part of a mode's height is seen and
# hides no line.
VEERING_STRIP = 0.035
STRIP: Look = {"facecolor": "0.72", "lw": 0}

# Lines of a panel: of more crank angles the map over the angle says more.
MOST_ANGLES = 6
# Crank angles that make no curve over the angle, and crank speeds that make one.
POINTS, CURVE = 2, 3

# More panels than these are too many to compare, and six fill three rows of two.
MOST_SPEEDS = 6
# Narrowest axis of damping as a part of the mean ratio, which is known to two digits at best.
LEAST_BAND = 0.02


@figure
def plot_frequencies(dataset: xr.Dataset) -> Picture:
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
        Dataset of a ``MovingFrequencies`` result; frequencies in Hz, angles in rad, speeds in
        rad/s.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = dataset.sortby("crank_angle")
    angles, panes = reading.degrees(dataset["crank_angle"]), []
    frequency, branch = (
        reading.values_of(dataset[name], *reading.MAP) for name in ("frequency", "branch_of_mode")
    )
    veering = dataset["veering"].transpose(*reading.MAP).values.astype(bool)[0]
    looks = speed_lines(dataset) if has_many_speeds(dataset) else []
    texts, between = reading.speed_texts(dataset), points_between(dataset)
    for group in mode_groups(dataset):
        shown, curves = frequency[..., group], list[Curve]()
        # One mode alone is one line: sorted frequencies do not jump.
        along = branch[0][..., group] if len(group) > 1 else np.zeros_like(shown[0])
        for number, (text, points) in enumerate(zip(texts, between, strict=True)):
            engines = slice(0, 1) if looks else slice(None)
            values, series = shown[engines, number], (number, len(texts), text)
            of_group = _of_modes(points, group)
            found = angle_panels.series_curves(angles, values, along[number], series, of_group)
            curves += [replace(one, look=looks[number]) for one in found] if looks else found
        title = reading.mode_label(dataset["mode"].values[group].tolist())
        panes.append(
            Pane(
                "",
                curves,
                title=title,
                spans=_where_veering(angles, veering[..., group]),
                limits=scales.limits_around(shown, least_part=scales.FREQUENCY_BAND),
            )
        )
    if looks:
        legend: dict[str, Look] = {reading.engine_label(dataset): {"color": style.MID_GREY}}
    else:
        legend = angle_panels.series_and_engines(dataset, texts)
    if any(pane.spans for pane in panes):
        legend["veering"] = STRIP
    return over_angles(
        angles,
        panes,
        dataset,
        y_label="Frequency (Hz)",
        layout=angle_panels.angle_layout([len(group) for group in mode_groups(dataset)]),
        legend=legend,
        colours=speed_colours(dataset),
        fewer=angle_panels.ONE_MODE,
    )


def mode_groups(dataset: xr.Dataset) -> list[list[int]]:
    """Modes that share a panel: neighbours between which a tracked branch passes.

    Frequencies sorted at each angle keep to one panel a mode until two branches cross or
    veer; then the branch is what a reader follows, and both modes belong in one panel.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency`` and ``branch_of_mode``.

    Returns
    -------
    list of list of int
        Positions along the mode dimension, ascending.
    """
    dataset = dataset.sortby("crank_angle")
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


def _where_veering(angles: FloatArray, veering: NDArray[np.bool_]) -> tuple[Span, ...]:
    """Grey strip along the axis where a mode veers at any speed; (speed, angle, mode)."""
    # A flagged angle stands for the interval half way to its neighbours.
    edges = np.clip(reading.cell_edges(angles), angles[0], angles[-1])
    look = STRIP | {"ymax": VEERING_STRIP / veering.shape[-1], "zorder": 0}
    runs = unbroken_runs(np.any(veering, axis=(0, 2)))
    return tuple(Span(edges[r.start], edges[r.stop], look, "veering", upright=True) for r in runs)


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


def has_few_angles(dataset: xr.Dataset) -> bool:
    """Whether a map has few crank angles and more crank speeds, so that these make the curves."""
    angles, speeds = dataset.sizes["crank_angle"], dataset.sizes["crank_speed"]
    return angles <= MOST_ANGLES and speeds >= max(CURVE, angles + 1)


def has_no_curve_over_angle(dataset: xr.Dataset) -> bool:
    """Whether that map has so few crank angles that over them there are points alone."""
    return has_few_angles(dataset) and dataset.sizes["crank_angle"] <= POINTS


@figure
def plot_frequencies_over_speed(dataset: xr.Dataset) -> Picture:
    """Draw natural frequencies against crank speed, one panel a mode, one line a crank angle.

    Modes are in order of frequency at each speed. The first engine is drawn as lines, the others as
    markers. At most six crank angles are drawn, evenly spread.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result; frequencies in Hz, angles in rad, speeds in
        rad/s.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = dataset.sortby(["crank_speed", "crank_angle"])
    count = dataset.sizes["crank_angle"]
    places = np.round(np.linspace(0, count - 1, min(count, MOST_ANGLES))).astype(int)
    dataset = dataset.isel(crank_angle=places)
    frequency = reading.values_of(dataset["frequency"], *reading.MAP)
    speeds, panes = reading.speeds_of(dataset), []
    names = [f"{angle:.6g} deg" for angle in reading.degrees(dataset["crank_angle"]).tolist()]
    nowhere = np.zeros((len(speeds), 1))
    for number, mode in enumerate(dataset["mode"].values.tolist()):
        curves = list[Curve]()
        for place, name in enumerate(names):
            values, series = frequency[:, :, place, number, None], (place, len(names), name)
            curves += angle_panels.series_curves(speeds, values, nowhere, series)
        limits = scales.limits_around(frequency[..., number], least_part=scales.FREQUENCY_BAND)
        heading = reading.mode_label([mode])
        panes.append(Pane("", curves, title=heading, limits=limits))
    label, title = reading.speed_unit(dataset), "Natural frequencies over crank speed"
    ends = np.array(scales.speed_limits(dataset))
    return Picture(
        panes,
        f"Crank speed ({label})",
        dataset,
        title,
        "Frequency (Hz)",
        places=ends,
        layout=angle_panels.angle_layout([1] * len(panes)),
        legend=angle_panels.series_and_engines(dataset, names, along="crank_speed"),
        fewer=angle_panels.ONE_MODE,
    )


def damping_of(dataset: xr.Dataset) -> str:
    """Variable that holds the damping ratio: by modal strain energy where plies have some.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result.

    Returns
    -------
    str
    """
    by_energy = "strain_energy_damping"
    return by_energy if by_energy in dataset else "damping_ratio"


@figure
def plot_damping(dataset: xr.Dataset) -> Picture:
    """Draw the damping ratio against crank angle, one panel a speed, one line a mode.

    By modal strain energy where the specific damping of plies is known, else
    -Re(lambda)/abs(lambda) of frozen positions. With rotation terms these may have either sign and
    are no damping; an undamped mechanism has these alone. Modes are in order of frequency at each
    angle. Where two of them change places a line breaks off and goes on elsewhere: it does not
    join the damping of different vibrations. The first engine is drawn as lines, the others as
    markers. At most six speeds are drawn, evenly spread.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a speed. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    name = damping_of(dataset)
    title = "Kelvin-Voigt damping of frozen positions"
    if dataset.attrs.get("damped_by", "Kelvin-Voigt") != "Kelvin-Voigt":
        title = "Damping ratios of frozen positions"
    if name == "strain_energy_damping":
        title = "Damping by modal strain energy"
    count = dataset.sizes["crank_speed"]
    # The first and the last among them.
    places = np.round(np.linspace(0, count - 1, min(count, MOST_SPEEDS))).astype(int)
    dataset = dataset.sortby("crank_angle").isel(crank_speed=places)
    percent = 100.0 * reading.values_of(dataset[name], *reading.MAP)
    branch = reading.values_of(dataset["branch_of_mode"], *reading.MAP)[0]
    angles, panes = reading.degrees(dataset["crank_angle"]), []
    limits = scales.limits_around(percent, least_part=LEAST_BAND)
    modes = dataset["mode"].values.tolist()
    for speed, text in enumerate(reading.speed_texts(dataset)):
        curves = list[Curve]()
        for number, mode in enumerate(modes):
            values, along = percent[:, speed, :, [number]], branch[speed, :, [number]]
            series = number, len(modes), f"mode {mode}"
            curves += angle_panels.series_curves(
                angles, np.moveaxis(values, 0, -1), along.T, series
            )
        panes.append(Pane("", curves, title=text, limits=limits))
    return over_angles(
        angles,
        panes,
        dataset,
        title,
        "Damping ratio (%)",
        layout=angle_panels.angle_layout([1] * len(panes), share_y=True),
        legend=angle_panels.series_and_engines(dataset, [f"mode {mode}" for mode in modes]),
        fewer="choose one speed (speeds=...)",
    )
