"""The look shared by all figures: one style sheet, one palette, one crank-angle axis."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import (
    LogLocator,
    MaxNLocator,
    MultipleLocator,
    NullFormatter,
    ScalarFormatter,
)
from numpy.typing import ArrayLike

from flexmech.types import FloatArray
from flexmech.units import ANGULAR_SPEED, from_si

__all__ = [
    "FIGURE_WIDTH",
    "LABEL_SIZE",
    "LIGHT_GREY",
    "MARK_SIZE",
    "MID_GREY",
    "POINT_SIZE",
    "SERIES_STYLES",
    "TITLE_SIZE",
    "NotebookFigure",
    "SeriesStyle",
    "crank_angle_axis",
    "few_points",
    "header_height",
    "header_legend",
    "legend_columns",
    "line_handle",
    "log_scale",
    "mode_label",
    "new_figure",
    "plain_numbers",
    "publication_style",
    "scale_y",
    "series_handle",
    "series_line",
    "series_style",
    "speed_label",
]

MILLIMETRE = 1 / 25.4
FIGURE_WIDTH = 180 * MILLIMETRE
"""Width of every figure in inches: the full text width of a two-column journal."""
LABEL_SIZE = TITLE_SIZE = 9.0
LIGHT_GREY = "0.90"
MID_GREY = "0.45"

# Below this number of angles each computed point is marked: a line alone would suggest a
# resolution that is not there, and a single point would not show at all.
FEW_POINTS = 10
POINT_SIZE = 3.0
MARK_SIZE = 4.2
"""Size of markers that carry a meaning of their own, in points."""
# Half the height of a y axis over the span of the values on it.
HALF_AXIS = 0.58
# Mean width of a letter of the font as a fraction of its size, on the safe side.
MEAN_LETTER = 0.62

_STYLE = mpl.rc_params_from_file(
    Path(__file__).with_name("publication.mplstyle"), use_default_template=False
)


@dataclass(frozen=True)
class SeriesStyle:
    """How one series is told from the others, in colour and without it."""

    color: str
    linestyle: Literal["-"] | tuple[float, tuple[float, ...]]
    marker: str


SERIES_STYLES = (
    SeriesStyle("#0072B2", "-", "o"),
    SeriesStyle("#D55E00", (0.0, (5.0, 1.6)), "s"),
    SeriesStyle("#009E73", (0.0, (5.0, 1.5, 1.2, 1.5)), "^"),
    SeriesStyle("#CC79A7", (0.0, (1.2, 1.2)), "D"),
    SeriesStyle("#E69F00", (0.0, (5.0, 1.4, 1.2, 1.4, 1.2, 1.4)), "v"),
    SeriesStyle("#56B4E9", (0.0, (9.0, 2.0)), "P"),
)
"""Okabe and Ito's colours (safe for colour-blind readers), each with a dash and a marker."""


class NotebookFigure(Figure):
    """Figure that a notebook shows by itself, though pyplot does not know of it."""

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png", dpi=self.dpi)
        return picture.getvalue()


@contextmanager
def publication_style() -> Iterator[None]:
    """Matplotlib settings of the figures, for as long as the context lasts.

    The plotting functions enter it themselves; enter it too around ``savefig`` to get
    300 dots per inch and fonts that a PDF editor can edit.
    """
    with mpl.rc_context(_STYLE):
        yield


def new_figure(height: float) -> Figure:
    """Empty figure of journal width and the given height in inches, laid out on drawing."""
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05, wspace=0.03, hspace=0.03)
    return NotebookFigure(figsize=(FIGURE_WIDTH, height), dpi=150, layout=layout)


def series_style(number: int) -> SeriesStyle:
    """Style of the series of a given number from 0; repeats after six."""
    return SERIES_STYLES[number % len(SERIES_STYLES)]


def series_line(number: int, points: FloatArray | None = None) -> dict[str, Any]:
    """Properties of a series' line; each of the points is marked where they are few.

    Parameters
    ----------
    number : int
        Of the series, from 0.
    points : ndarray, optional
        Abscissas of the computed points. Without them no point is marked.

    Returns
    -------
    dict
        For ``Axes.plot``.
    """
    style = series_style(number)
    marked = points is not None and few_points(points)
    return {
        "color": style.color,
        "linestyle": style.linestyle,
        "marker": style.marker if marked else "",
        "markersize": POINT_SIZE,
    }


def line_handle(label: str, **properties: Any) -> Line2D:
    """Legend entry with the properties of a ``Line2D``."""
    return Line2D([], [], label=label, **properties)


def series_handle(number: int, label: str, **properties: Any) -> Line2D:
    """Legend entry in the style of a series; properties are those of ``Line2D``."""
    return line_handle(label, **(series_line(number) | properties))


def few_points(points: FloatArray) -> bool:
    """Whether the points are few enough to mark each of them."""
    return points.size <= FEW_POINTS


def crank_angle_axis(axes: Axes, angles: FloatArray, *, narrow: bool = False) -> None:
    """Scale the x axis to crank angles given in degrees, with ticks at round angles.

    Parameters
    ----------
    axes : Axes
        Its x axis is set, without a label.
    angles : ndarray, shape (n,)
        Crank angles in degrees, ascending.
    narrow : bool
        Whether the panel has room for few ticks only (90 deg on a full turn, else 60).
    """
    first, last = float(angles[0]), float(angles[-1])
    span = last - first
    if span == 0:
        axes.set_xlim(first - 1.0, last + 1.0)
        axes.set_xticks([first])
    else:
        # The points of a coarse map are marked, and a mark must not hang over the edge.
        room = 0.03 * span if few_points(angles) else 0.0
        axes.set_xlim(first - room, last + room)
        most = 4 if narrow else 6
        if angles.size <= most + 1 and np.diff(angles).min() >= span / (most + 1):
            axes.set_xticks(angles)
        else:
            axes.xaxis.set_major_locator(MultipleLocator(_tick_step(span, most)))
    axes.xaxis.set_major_formatter(ScalarFormatter(useOffset=False))


def _tick_step(span: float, most: int) -> float:
    """Smallest round step in degrees that cuts a span into at most so many parts."""
    for step in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 90.0, 180.0):
        if span <= step * most * (1 + 1e-9):
            return step
    return 360.0 * float(np.ceil(span / (360.0 * most)))


def plain_numbers(axes: Axes) -> None:
    """Write the y ticks in full: no offset and no power of ten apart from the axis."""
    formatter = ScalarFormatter(useOffset=False)
    formatter.set_scientific(False)
    axes.yaxis.set_major_formatter(formatter)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))


def scale_y(axes: Axes, values: ArrayLike, *, least: float = 1e-9, least_part: float = 0.0) -> None:
    """Fit the y axis to values, in plain numbers, and never so closely that one sees round-off.

    Parameters
    ----------
    axes : Axes
    values : array_like
        All that the axis shall hold; not a number is left out.
    least : float
        Least span of the axis.
    least_part : float
        Least span as a part of the mean of the greatest and the least value.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    middle = (low + high) / 2
    half = HALF_AXIS * max(high - low, least_part * abs(middle), least)
    axes.set_ylim(middle - half, middle + half)
    plain_numbers(axes)


def log_scale(axes: Axes, low: float, high: float) -> None:
    """Make the y axis logarithmic between two limits, ticked at every decade or every few."""
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator(base=10, numticks=7))
    axes.yaxis.set_minor_formatter(NullFormatter())


def speed_label(speed: float, unit: str = ANGULAR_SPEED.unit) -> str:
    """Crank speed, given in rad/s, as text in a unit such as rpm, with a true minus sign."""
    return f"{from_si(speed, unit):.4g} {unit}".replace("-", "\N{MINUS SIGN}")


def mode_label(numbers: Sequence[int]) -> str:
    """Heading of a panel for one mode or several neighbours."""
    if len(numbers) == 1:
        return f"Mode {numbers[0]}"
    return f"Modes {numbers[0]} {'and' if len(numbers) == 2 else 'to'} {numbers[-1]}"


def header_legend(figure: Figure, handles: Sequence[Artist], title: str = "") -> None:
    """Put one legend for all panels above them, under an optional heading line.

    Entries run along the rows, as many a row as the figure's width holds.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    handles : sequence of matplotlib.artist.Artist
        With their labels.
    title : str
        Heading line; none by default.
    """
    columns = legend_columns([str(handle.get_label()) for handle in handles])
    figure.legend(
        # Matplotlib fills a legend column by column; every column but the last ones is full.
        handles=[handle for start in range(columns) for handle in handles[start::columns]],
        loc="outside upper center",
        ncols=columns,
        title=title or None,
    )


def header_height(handles: Sequence[Artist], title: str = "") -> float:
    """Height in inches that the legend above the panels takes."""
    columns = legend_columns([str(handle.get_label()) for handle in handles])
    rows = -(-len(handles) // columns) + bool(title)
    return 0.12 + 0.165 * rows


def legend_columns(labels: list[str]) -> int:
    """Columns of legend entries, filled along the rows, that the figure's width holds.

    As few rows as possible, and these as equally filled as possible.
    """
    em = _STYLE["legend.fontsize"] / 72
    around = _STYLE["legend.handlelength"] + _STYLE["legend.columnspacing"] + 0.8
    widths = [(around + MEAN_LETTER * len(label)) * em for label in labels]

    def fits(columns: int) -> bool:
        needed: float = sum(max(widths[n::columns]) for n in range(columns))
        return needed <= FIGURE_WIDTH - 0.1

    most = next((n for n in range(len(labels), 1, -1) if fits(n)), 1)
    balanced = -(-len(labels) // -(-len(labels) // most))
    return balanced if fits(balanced) else most
