"""Small multiples: which modes share a panel, and where each panel stands."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flexmech.plots.style import LABEL_SIZE, crank_angle_axis
from flexmech.types import FloatArray

__all__ = ["contiguous_runs", "degrees", "grid_height", "mode_groups", "panel_grid"]


# Two modes whose bands are this close in ratio can exchange branches; modes further apart
# only seem to, where the crank angles are too coarse to follow a branch.
NEAR_BANDS = 1.1

# From this number of panels on, two columns read better than one tall stack.
TWO_COLUMNS_FROM = 4

# Least height of a panel with its heading, in inches.
PANEL_HEIGHT = 1.4


def degrees(angle: xr.DataArray) -> FloatArray:
    """Angles of a coordinate in degrees, free of the conversion's round-off."""
    turned: FloatArray = np.round(np.degrees(angle.values.astype(float)), 9)
    return turned


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
    order = ("engine", "crank_speed", "crank_angle", "mode")
    branch = dataset["branch_of_mode"].transpose(*order).values
    frequency = dataset["frequency"].transpose(*order).values
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
    groups = [[0]]
    for mode in range(1, n_modes):
        if joined[mode - 1]:
            groups[-1].append(mode)
        else:
            groups.append([mode])
    return groups


def panel_grid(
    figure: Figure,
    sizes: list[int],
    angles: FloatArray,
    y_label: str,
    *,
    share_y: bool = False,
) -> list[Axes]:
    """Stack panels over a shared crank-angle axis, in two columns from four panels on.

    Parameters
    ----------
    figure : Figure
        Where to put them.
    sizes : list of int
        Height of each panel in units, in order.
    angles : ndarray
        Crank angles in degrees, ascending.
    y_label : str
        Label of all y axes, with its unit.
    share_y : bool
        Whether all panels have the same y axis.

    Returns
    -------
    list of Axes
        One a panel, in order.
    """
    columns = _columns(sizes)
    rows = max(sum(sizes[panel] for panel in column) for column in columns)
    grid = figure.add_gridspec(rows, len(columns))
    axes: list[Axes] = []
    for place, column in enumerate(columns):
        row = 0
        top: Axes | None = None
        for panel in column:
            end = row + sizes[panel]
            shared_y = axes[0] if share_y and axes else None
            panel_axes = figure.add_subplot(grid[row:end, place], sharex=top, sharey=shared_y)
            panel_axes.tick_params(labelbottom=panel == column[-1])
            top, row = top or panel_axes, end
            axes.append(panel_axes)
        crank_angle_axis(axes[-1], angles, narrow=len(columns) > 1)
        axes[-1].set_xlabel("Crank angle (deg)")
    if len(axes) == 1:
        axes[0].set_ylabel(y_label)
    else:
        figure.supylabel(y_label, fontsize=LABEL_SIZE)
    return axes


def grid_height(sizes: list[int]) -> float:
    """Height in inches of a panel grid, its crank-angle axis included."""
    columns = _columns(sizes)
    rows = max(sum(sizes[panel] for panel in column) for column in columns)
    return rows * max(PANEL_HEIGHT, 1.9 - 0.3 * rows) + 0.5


def _columns(sizes: list[int]) -> list[list[int]]:
    """Panel numbers of each column; the first column is the taller one."""
    panels = list(range(len(sizes)))
    if len(sizes) == 1 or sum(sizes) < TWO_COLUMNS_FROM:
        return [panels]
    half = (sum(sizes) + 1) // 2
    filled, cut = 0, 0
    while filled < half:
        filled += sizes[cut]
        cut += 1
    return [panels[:cut], panels[cut:]] if cut < len(panels) else [panels]


def contiguous_runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last position of each unbroken run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(start), int(stop) - 1) for start, stop in edges.reshape(-1, 2)]
