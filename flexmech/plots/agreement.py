"""How far two engines differ, against what each says of its own error."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import angle_panels, scales, style
from flexmech.plots.labels import engine_label, speed_texts
from flexmech.plots.layout import AxesLike
from flexmech.plots.reading import degrees, names_of, values_of
from flexmech.plots.series import Look, line_handle, series_handles
from flexmech.plots.speed_colours import colour_bar, has_many_speeds, speed_lines
from flexmech.types import FloatArray

# Zero has no place on a logarithmic axis: equal frequencies are drawn at about machine epsilon.
FLOOR = 1e-16
ERROR: Look = {"color": style.MID_GREY, "linewidth": 0.7, "markersize": 4, "markeredgewidth": 0.8}
ERRORS: tuple[Look, ...] = (
    ERROR | {"linestyle": (0.0, (4.0, 2.0)), "marker": "x"},
    ERROR | {"linestyle": (0.0, (1.0, 1.5)), "marker": "+"},
)


def plot_agreement(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the relative difference of two engines against crank angle, one panel a mode.

    Grey are the discretisation errors that the engines estimate of themselves (the largest
    over the speeds): two engines on the same mesh can agree better than either is right, and
    they should not differ by much more than the sum of both.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result with two engines.
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
    with angle_panels.mode_panels(dataset, "Relative difference (-)", ax=ax, share_y=True) as drawn:
        many = has_many_speeds(dataset)
        handles = [] if many else series_handles(speed_texts(dataset), angles)
        for engine, line in zip(names_of(dataset, "engine"), ERRORS, strict=False):
            handles.append(line_handle(f"estimated error of {engine}", **line))
        first, second = (engine_label(dataset, engine) for engine in (0, 1))
        drawn.header(handles, f"Frequencies of {second} against {first}", of=dataset)
        low, high = _decades(np.concatenate([difference.ravel(), error.ravel()]))
        for mode, axes in enumerate(drawn.panels):
            if many:
                for values, look in zip(difference[mode], speed_lines(dataset), strict=True):
                    axes.plot(angles, values, **look)
            else:
                for number, values in enumerate(difference[mode]):
                    angle_panels.draw_line(axes, angles, values, number)
            for values, line in zip(error[mode], ERRORS, strict=False):
                axes.plot(check_angles, values, **line, zorder=1.5, clip_on=False)
            scales.log_scale(axes, low, high)
        if many:
            colour_bar(drawn, dataset)
    return drawn.figure


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
