"""Differences of natural frequencies over crank angle: by speed, state, vibration and engine."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots import angle_panels, scales
from flexmech.plots.angle_panels import has_many_speeds, speed_colours, speed_lines
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import Curve, Pane, Picture, Span, over_angles, series
from flexmech.plots.reading import (
    at_highest_speed,
    degrees,
    engine_label,
    mode_label,
    names_of,
    speed_texts,
    values_of,
)
from flexmech.plots.style import (
    MID_GREY,
    Look,
    few_points,
    series_line,
    series_style,
)

# Narrowest y axis in Hz: far below what can be measured, far above round-off.
LEAST_BAND = 2e-4
# A term whose greatest change is a smaller part of that of the total in every mode is small: its
# line would lie on that of zero.
SMALL_PART = 0.01
SMALL: Look = {"color": MID_GREY, "linewidth": 0.8, "linestyle": (0.0, (1.0, 1.0)), "zorder": 1.8}
# Steps of a line between two computed crank angles.
STEPS = 4
NOTHING = Span(0.0, 0.0, {"color": MID_GREY, "lw": 0.6, "zorder": 1})
"""Where nothing changes."""

STATE_LINES: tuple[Look, ...] = (
    {"linestyle": "-", "linewidth": 1.2},
    {"linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.5},
)

# Height of an engine's panel of the effect of vibration in inches.
EFFECT_HEIGHT = 2.0
# Narrowest axis of the difference in percent, a hundredth of the errors by the mesh that are usual:
# below it one would look at these.
LEAST_DIFFERENCE = 1e-3
# Relative difference of frequencies that is round-off: some thousand times machine epsilon.
SAME = 1e-12

# Zero has no place on a logarithmic axis: equal frequencies are drawn at about machine epsilon.
FLOOR = 1e-16
ERROR: Look = {"color": MID_GREY, "linewidth": 0.7, "markersize": 4, "markeredgewidth": 0.8}
ERRORS: tuple[Look, ...] = (
    ERROR | {"linestyle": (0.0, (4.0, 2.0)), "marker": "x"},
    ERROR | {"linestyle": (0.0, (1.0, 1.5)), "marker": "+"},
)


@figure
def plot_speed_effect(dataset: xr.Dataset) -> Picture:
    """Draw the change of each frequency with crank speed, split by term, at the top speed.

    The terms are those of the linkage's equation of motion in link frames: geometric
    stiffness of the axial forces, shift of configuration to the equilibrium, Coriolis,
    centripetal and tangential terms, switched on one after another; black is their sum, the
    frequency at speed minus that at rest. Terms that stay below a hundredth of the total in every
    mode share one look and one entry of the legend.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result made with ``speed_effect=True``; Hz and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no ``speed_effect``.
    """
    fastest, speed = at_highest_speed(dataset.sortby("crank_angle"))
    known = "speed_effect" in dataset
    if not known or fastest["speed_effect"].isnull().any():
        raise InputError(
            f"this result does not split the effect of speed by term{f' at {speed}' * known}: "
            "compute it with moving_frequencies(..., speed_effect=True)"
        )
    effect = values_of(fastest["speed_effect"], "mode", "term", "crank_angle")
    angles, small = degrees(fastest["crank_angle"]), _small(effect)
    mark = "*" if few_points(angles) else ""
    if not few_points(angles):
        # Without corners, and nowhere beyond what is computed.
        computed, angles = angles, np.linspace(angles[0], angles[-1], STEPS * (angles.size - 1) + 1)
        effect = PchipInterpolator(computed, effect, axis=-1)(angles)
    total: Look = {"color": "black", "linewidth": 1.8, "marker": mark, "markersize": 5}
    # Coriolis is a name; the others are plain words.
    terms = [name.replace("coriolis", "Coriolis") for name in names_of(dataset, "term")]
    words = f"{', '.join(terms[number] for number in small)} (below 1 % of the total)"
    panes = []
    for mode, changes in zip(fastest["mode"].values.tolist(), effect, strict=True):
        whole = changes.sum(axis=0)
        # Under the terms, so that a term which makes up the whole effect is seen on it.
        curves = [Curve(angles, whole, total | {"zorder": 1.9}, "total")]
        for number in sorted(range(len(terms)), key=lambda one: (one in small, one)):
            look = series_line(number, angles) | {"zorder": 2.5}
            look, name = (SMALL, words) if number in small else (look, terms[number])
            curves.append(Curve(angles, changes[number], look, name))
        shown = np.vstack([changes, whole, 0.0 * angles])
        limits = scales.limits_around(shown, least=LEAST_BAND)
        title = mode_label([mode])
        panes.append(Pane("", curves, title=title, spans=(NOTHING,), limits=limits))
    title = f"Change of frequency from rest to {speed}, by term"
    label = "Change of frequency (Hz)"
    return over_angles(angles, panes, dataset, title, label, fewer=angle_panels.ONE_MODE)


def _small(effect: FloatArray) -> list[int]:
    """Terms below a hundredth of the total in every mode; shape (mode, term, crank_angle)."""
    greatest = np.abs(effect.sum(axis=1)).max(axis=-1)
    parts = np.abs(effect).max(axis=-1)
    small: list[int] = np.flatnonzero((parts < SMALL_PART * greatest[:, None]).all(axis=0)).tolist()
    return small


@figure
def plot_hygrothermal_effect(dataset: xr.Dataset) -> Picture:
    """Draw the frequencies of both states against crank angle, one panel a mode.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result in two states; Hz and rad. Its first engine is
        drawn, at every speed.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset does not hold two states.
    """
    if dataset.sizes.get("state") != len(STATE_LINES):
        raise InputError("the effect of heat and moisture needs frequencies in two states")
    dataset = dataset.sortby("crank_angle")
    angles = degrees(dataset["crank_angle"])
    order = ("mode", "crank_speed", "state", "crank_angle")
    frequency = values_of(dataset["frequency"].isel(engine=0), *order)
    drawn_at, lines = angles, frequency
    if "frequency_between" in dataset:
        between = values_of(dataset["frequency_between"], *order[:-1], "between_angle")
        drawn_at = np.append(angles, degrees(dataset["between_angle"]))
        sequence = np.argsort(drawn_at, kind="stable")
        drawn_at = drawn_at[sequence]
        lines = np.concatenate([frequency, between], axis=-1)[..., sequence]
    states = names_of(dataset, "state")
    legend: dict[str, Look] = {
        n: {"color": MID_GREY, **one} for n, one in zip(states, STATE_LINES, strict=True)
    }
    looks, texts = speed_lines(dataset) if has_many_speeds(dataset) else [], speed_texts(dataset)
    for number, text in enumerate([] if looks else texts):
        legend[text] = {"color": series_style(number).color, "linewidth": 1.5}
        looks.append(series_line(number, angles))
    panes = []
    for mode, speeds in zip(dataset["mode"].values.tolist(), lines, strict=True):
        curves = tuple(
            Curve(drawn_at, values, look | line, text)
            for states, look, text in zip(speeds, looks, texts, strict=True)
            for values, line in zip(states, STATE_LINES, strict=True)
        )
        limits = scales.limits_around(speeds, least_part=scales.FREQUENCY_BAND)
        panes.append(Pane("", curves, title=mode_label([mode]), limits=limits))
    title = "Natural frequencies in two states of heat and moisture"
    return over_angles(
        angles,
        panes,
        dataset,
        title,
        "Natural frequency (Hz)",
        legend=legend,
        colours=speed_colours(dataset),
        fewer=angle_panels.ONE_MODE,
    )


@figure
def plot_vibration_effect(dataset: xr.Dataset) -> Picture:
    """Draw by how much the running linkage's natural frequencies differ from quasi-static ones.

    For the highest crank speed: frequencies about the states that a simulation runs through over
    those about the quasi-static equilibrium, a line a mode. Only engines in which the two differ
    are drawn, one panel each; in a linear model vibration changes nothing. If none differs, the
    first engine is drawn.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency`` and ``quasi_static_frequency`` (engine, crank_speed, crank_angle,
        mode) in Hz, angles in rad and speeds in rad/s.
    ax : Axes or sequence of Axes, optional
        The user's, one an engine that is drawn. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    fastest, speed = at_highest_speed(dataset.sortby("crank_angle"))
    order = ("engine", "mode", "crank_angle")
    pair = [values_of(fastest[name], *order) for name in ("frequency", "quasi_static_frequency")]
    engines, percent = _affected(*pair), 100.0 * (pair[0] / pair[1] - 1.0)
    limits = scales.limits_around(np.append(percent[engines], 0.0), least=LEAST_DIFFERENCE)
    angles = degrees(fastest["crank_angle"])
    modes = [f"mode {mode}" for mode in fastest["mode"].values.tolist()]
    panes = [
        Pane(
            "",
            series(angles, percent[engine], modes),
            title=engine_label(dataset, engine),
            spans=(NOTHING,),
            limits=limits,
        )
        for engine in engines
    ]
    title = f"Natural frequencies at {speed}, running against quasi-static"
    label = "Difference (%)"
    layout = grid(len(panes), 1, EFFECT_HEIGHT * len(panes) + 0.5, sharex=True)
    return over_angles(angles, panes, dataset, title, label, layout=layout)


def _affected(running: FloatArray, still: FloatArray) -> list[int]:
    """Engines whose two frequencies differ, or the first engine; shape (engine, mode, angle)."""
    differ = ~np.isclose(running, still, rtol=SAME, atol=0.0, equal_nan=True)
    numbers: list[int] = np.flatnonzero(differ.any(axis=(1, 2))).tolist()
    return numbers or [0]


@figure
def plot_agreement(dataset: xr.Dataset) -> Picture:
    """Draw the relative difference of two engines against crank angle, one panel a mode.

    Grey are the discretisation errors that the engines estimate of themselves (the largest
    over the speeds): two engines on the same mesh can agree better than either is right, and
    they should not differ by much more than the sum of both.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result with two engines.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset holds one engine only.
    """
    if dataset.sizes["engine"] < 2:
        raise InputError(
            "agreement needs two engines and this result has one "
            f"({engine_label(dataset)}): compute with both"
        )
    dataset = dataset.sortby(["crank_angle", "check_angle"])
    angles, check_angles = (degrees(dataset[name]) for name in ("crank_angle", "check_angle"))
    difference, error = _relative_difference(dataset), _own_errors(dataset)
    looks, texts = speed_lines(dataset) if has_many_speeds(dataset) else [], speed_texts(dataset)
    legend = {} if looks else {text: series_line(n, angles) for n, text in enumerate(texts)}
    for engine, line in zip(names_of(dataset, "engine"), ERRORS, strict=False):
        legend[f"estimated error of {engine}"] = line
    looks = looks or [series_line(number, angles) | {"zorder": 2.5} for number in range(len(texts))]
    limits = _decades(np.concatenate([difference.ravel(), error.ravel()]))
    panes = []
    for mode, speeds, errors in zip(
        dataset["mode"].values.tolist(), difference, error, strict=True
    ):
        curves = [
            Curve(angles, values, look, text)
            for values, look, text in zip(speeds, looks, texts, strict=True)
        ]
        curves += [
            Curve(check_angles, values, line | {"zorder": 1.5, "clip_on": False})
            for values, line in zip(errors, ERRORS, strict=False)
        ]
        panes.append(Pane("", curves, title=mode_label([mode]), limits=limits, scale="log"))
    first, second = (engine_label(dataset, engine) for engine in (0, 1))
    title = f"Frequencies of {second} against {first}"
    return over_angles(
        angles,
        panes,
        dataset,
        title,
        "Relative difference (-)",
        layout=angle_panels.angle_layout([1] * len(panes), share_y=True),
        legend=legend,
        colours=speed_colours(dataset),
        fewer=angle_panels.ONE_MODE,
    )


def _relative_difference(dataset: xr.Dataset) -> FloatArray:
    """|f_b / f_a - 1| of the first two engines; shape (mode, speed, angle)."""
    frequency = values_of(dataset["frequency"], "engine", "mode", "crank_speed", "crank_angle")
    with np.errstate(divide="ignore", invalid="ignore"):
        difference: FloatArray = np.abs(frequency[1] / frequency[0] - 1)
    return np.where(np.isfinite(difference), np.maximum(difference, FLOOR), np.nan)


def _own_errors(dataset: xr.Dataset) -> FloatArray:
    """Largest discretisation error over the speeds; shape (mode, engine, check_angle)."""
    order = ("crank_speed", "mode", "engine", "check_angle")
    # fmax ignores nan: an angle without an estimate at one speed may have it at another.
    largest = np.fmax.reduce(np.abs(values_of(dataset["discretisation_error"], *order)), axis=0)
    return np.asarray(np.maximum(largest, FLOOR))


def _decades(values: FloatArray) -> tuple[float, float]:
    """Whole decades around values, at least one; around the floor where there are none."""
    finite = values[np.isfinite(values)]
    decades = np.log10(finite if finite.size else [FLOOR])
    low, high = float(np.floor(decades.min())), float(np.ceil(decades.max()))
    return 10.0**low, 10.0 ** max(high, low + 1)
