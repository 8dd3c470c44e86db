"""Panels over the crank angle: where they stand, and what is on their axes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import accumulate

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots.labels import mode_label
from flexmech.plots.reading import degrees
from flexmech.plots.scales import crank_angle_axis
from flexmech.plots.sheet import AxesLike, Layout, Sheet, sheet
from flexmech.types import FloatArray

__all__ = ["ONE_MODE", "angle_layout", "label_angles", "mode_panels"]

ONE_MODE = "choose one mode (modes=1)"
# From this number of panels on, two columns read better than one tall stack.
TWO_COLUMNS_FROM = 4
# Least height of a panel with its heading, and least width for many ticks, in inches.
PANEL_HEIGHT = 1.4
WIDE = 4.0


def angle_layout(sizes: Sequence[int], *, share_y: bool = False) -> Layout:
    """Panels over a shared crank-angle axis, in two columns from four panels on.

    Parameters
    ----------
    sizes : sequence of int
        Height of each panel in units, in order.
    share_y : bool
        Whether all panels have the same y axis.

    Returns
    -------
    Layout
    """
    columns = _columns(sizes)
    rows = max(sum(sizes[panel] for panel in column) for column in columns)

    def make(figure: Figure) -> list[Axes]:
        cells = figure.add_gridspec(rows, len(columns))
        panels: list[Axes] = []
        for place, column in enumerate(columns):
            ends = accumulate(sizes[panel] for panel in column)
            for panel, end in zip(column, ends, strict=True):
                first = panels[0] if panels else None
                cell = cells[end - sizes[panel] : end, place]
                axes = figure.add_subplot(cell, sharex=first, sharey=first if share_y else None)
                axes.tick_params(labelbottom=panel == column[-1])
                panels.append(axes)
        return panels

    return Layout(len(sizes), rows * max(PANEL_HEIGHT, 1.9 - 0.3 * rows) + 0.5, make)


def _columns(sizes: Sequence[int]) -> list[range]:
    """Panel numbers of each column; the first column is the taller one."""
    whole = range(len(sizes))
    if len(sizes) == 1 or sum(sizes) < TWO_COLUMNS_FROM:
        return [whole]
    half = (sum(sizes) + 1) // 2
    cut = next(n for n, filled in enumerate(accumulate(sizes), start=1) if filled >= half)
    return [part for part in (whole[:cut], whole[cut:]) if part]


def label_angles(drawn: Sheet, angles: FloatArray, y_label: str) -> None:
    """Scale and label the axes of panels over the crank angle.

    Parameters
    ----------
    drawn : Sheet
    angles : ndarray
        Crank angles in degrees, ascending.
    y_label : str
        Label of all y axes, with its unit.
    """
    width = drawn.figure.get_figwidth()
    for axes in drawn.panels:
        crank_angle_axis(axes, angles, narrow=axes.get_position().width * width < WIDE)
    drawn.label_x("Crank angle (deg)")
    drawn.label_y(y_label)


@contextmanager
def mode_panels(
    dataset: xr.Dataset, y_label: str, *, ax: AxesLike | None = None, share_y: bool = False
) -> Iterator[Sheet]:
    """One panel a mode over the crank angle, with its heading.

    Parameters
    ----------
    dataset : Dataset
        Sorted by crank angle.
    y_label : str
        Label of all y axes, with its unit.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode.
    share_y : bool
        Whether all panels have the same y axis.

    Yields
    ------
    Sheet
    """
    layout = angle_layout([1] * dataset.sizes["mode"], share_y=share_y)
    with sheet(layout, ax=ax, fewer=ONE_MODE) as drawn:
        label_angles(drawn, degrees(dataset["crank_angle"]), y_label)
        for axes, mode in zip(drawn.panels, dataset["mode"].values, strict=True):
            axes.set_title(mode_label([mode]))
        yield drawn
