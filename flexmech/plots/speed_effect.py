"""What each inertial term of the moving linkage does to the natural frequencies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import angle_panels, scales, style
from flexmech.plots.layout import AxesLike
from flexmech.plots.reading import at_highest_speed, degrees, names_of, values_of
from flexmech.plots.series import Look, few_points, line_handle, series_line
from flexmech.types import FloatArray

# Narrowest y axis in Hz: far below what can be measured, far above round-off.
LEAST_BAND = 2e-4
# A term whose greatest change is a smaller part of that of the total in every mode is small.
SMALL_PART = 0.01
SMALL: Look = {"color": style.MID_GREY, "linewidth": 0.8, "linestyle": (0.0, (1.0, 1.0))}


def plot_speed_effect(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the change of each frequency with crank speed, split by term, at the top speed.

    The terms are those of the linkage's equation of motion in link frames: geometric
    stiffness of the axial forces, shift of configuration to the equilibrium, Coriolis,
    centripetal and tangential terms, switched on one after another; black is their sum, the
    frequency at speed minus that at rest. Terms that stay below a hundredth of the total in every
    mode share one look and one entry of the legend.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result made with ``speed_effect=True``; Hz and rad.
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
    if "speed_effect" not in dataset:
        raise InputError(
            "this result does not split the effect of speed by term: compute it with "
            "moving_frequencies(..., speed_effect=True)"
        )
    fastest, speed = at_highest_speed(dataset.sortby("crank_angle"))
    if fastest["speed_effect"].isnull().any():
        raise InputError(
            f"this result does not split the effect of speed by term at {speed}: compute it with "
            "moving_frequencies(..., speed_effect=True)"
        )
    effect = values_of(fastest["speed_effect"], "mode", "term", "crank_angle")
    angles = degrees(fastest["crank_angle"])
    mark = "*" if few_points(angles) else ""
    total: Look = {"color": "black", "linewidth": 1.8, "marker": mark, "markersize": 5}
    with angle_panels.mode_panels(fastest, "Change of frequency (Hz)", ax=ax) as drawn:
        # Coriolis is a name; the others are plain words.
        terms = [name.replace("coriolis", "Coriolis") for name in names_of(dataset, "term")]
        title = f"Change of frequency from rest to {speed}, by term"
        small = _small(effect)
        handles = [line_handle("total", **total)]
        for number, term in enumerate(terms):
            if number not in small:
                handles.append(line_handle(term, **series_line(number, angles)))
        if small:
            words = ", ".join(terms[number] for number in small)
            handles.append(line_handle(f"{words} (below 1 % of the total)", **SMALL))
        drawn.header(handles, title, of=dataset)
        for axes, changes in zip(drawn.panels, effect, strict=True):
            axes.axhline(0.0, color=style.MID_GREY, lw=0.6, zorder=1)
            # Under the terms, so that a term which makes up the whole effect is seen on it.
            whole = changes.sum(axis=0)
            axes.plot(angles, whole, **total, zorder=1.9)
            for number, change in enumerate(changes):
                if number in small:
                    axes.plot(angles, change, **SMALL, zorder=1.8)
                else:
                    angle_panels.draw_line(axes, angles, change, number)
            scales.scale_y(axes, np.vstack([changes, whole, 0.0 * angles]), least=LEAST_BAND)
    return drawn.figure


def _small(effect: FloatArray) -> list[int]:
    """Terms below a hundredth of the total in every mode; shape (mode, term, crank_angle)."""
    greatest = np.abs(effect.sum(axis=1)).max(axis=-1)
    parts = np.abs(effect).max(axis=-1)
    small: list[int] = np.flatnonzero((parts < SMALL_PART * greatest[:, None]).all(axis=0)).tolist()
    return small
