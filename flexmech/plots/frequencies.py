"""Natural frequencies against crank angle, by crank speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flexmech.plots.angle_lines import draw_line, draw_marks, engine_handles, marked_handles
from flexmech.plots.angle_panels import ONE_MODE, angle_layout, label_angles
from flexmech.plots.branches import MAP, branch_lines, contiguous_runs, mode_groups
from flexmech.plots.labels import mode_label, speed_texts
from flexmech.plots.reading import cell_edges, degrees, values_of
from flexmech.plots.scales import scale_y
from flexmech.plots.sheet import AxesLike, sheet
from flexmech.plots.style import MID_GREY
from flexmech.types import FloatArray

__all__ = ["plot_frequencies"]

# Narrowest y axis as a part of the frequency: below it one would look at round-off.
LEAST_BAND = 4e-3
# Veering can last for a large part of the turn: a strip of this part of a mode's height.
VEERING_STRIP = 0.035
STRIP_GREY = "0.72"


def plot_frequencies(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw natural frequencies against crank angle, one panel a mode, one line a speed.

    Modes lie far apart and the crank speed moves them by about one per cent, so each mode
    has a panel with its own frequency axis. Modes between which a tracked branch passes
    (crossing or veering) share a panel, in which each line follows a branch and is numbered
    by it at its right end. The first engine is drawn as lines, the second as markers;
    a grey strip on the crank-angle axis shows where veering was flagged.

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
    groups, angles = mode_groups(dataset), degrees(dataset["crank_angle"])
    frequency, branch = (values_of(dataset[name], *MAP) for name in ("frequency", "branch_of_mode"))
    veering = dataset["veering"].transpose(*MAP).values.astype(bool)[0]
    layout = angle_layout([len(group) for group in groups])
    with sheet(layout, ax=ax, fewer=ONE_MODE) as drawn:
        handles = marked_handles(dataset, speed_texts(dataset)) + engine_handles(dataset)
        if veering.any():
            handles.append(Patch(color=STRIP_GREY, lw=0, label="veering"))
        drawn.header(handles)
        label_angles(drawn, angles, "Frequency (Hz)")
        for axes, group in zip(drawn.panels, groups, strict=True):
            axes.set_title(mode_label(dataset["mode"].values[group].tolist()))
            scale_y(axes, frequency[..., group], least_part=LEAST_BAND)
            _mark_veering(axes, angles, veering[..., group])
            _draw_speeds(axes, angles, frequency[..., group], branch[0][..., group])
    return drawn.figure


def _mark_veering(axes: Axes, angles: FloatArray, veering: NDArray[np.bool_]) -> None:
    """Grey strip along the axis where a mode veers at any speed; (speed, angle, mode)."""
    # A flagged angle stands for the interval half way to its neighbours.
    edges = np.clip(cell_edges(angles), angles[0], angles[-1])
    for first, last in contiguous_runs(np.any(veering, axis=(0, 2))):
        axes.axvspan(
            edges[first],
            edges[last + 1],
            ymax=VEERING_STRIP / veering.shape[-1],
            color=STRIP_GREY,
            lw=0,
            zorder=0,
        )


def _draw_speeds(axes: Axes, angles: FloatArray, frequency: FloatArray, branch: FloatArray) -> None:
    """All speeds in one panel: frequency (engine, speed, angle, mode), branch without engine."""
    n_engines, n_speeds, _, n_modes = frequency.shape
    for number in range(n_speeds):
        # One mode alone is one line: sorted frequencies do not jump.
        along = branch[number] if n_modes > 1 else np.zeros_like(branch[number])
        lines = branch_lines(frequency[0, number], along)
        for values in lines.values():
            draw_line(axes, angles, values, number)
        for engine in range(1, n_engines):
            draw_marks(axes, angles, frequency[engine, number], number, n_speeds, engine)
        if number == 0 and n_modes > 1:
            _number_branches(axes, lines)


def _number_branches(axes: Axes, lines: dict[int, FloatArray]) -> None:
    """Write each branch's number beside the right end of its line, spread to be read."""
    ends = {number: float(values[-1]) for number, values in lines.items()}
    low, high = axes.get_ylim()
    height = -np.inf
    for number in sorted((n for n in ends if np.isfinite(ends[n])), key=ends.__getitem__):
        height = max(ends[number], height + 0.07 * (high - low))
        axes.annotate(
            f"branch {number}",
            xy=(1.0, height),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
            color=MID_GREY,
        )
