"""The sheet of a figure: new panels or the user's, in one style, under one legend."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox, blended_transform_factory
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots.reading import mechanism_name, terms_text
from flexmech.plots.style import (
    BESIDE_PANELS,
    figure_width,
    is_narrow,
    new_figure,
    publication_style,
)

# Mean width of a letter of the font as a fraction of its size, on the safe side.
MEAN_LETTER = 0.62
# Height of a tile in inches.
TILE = 2.1
# Displacements below this part of a linkage's extent are not enlarged: they are round-off.
ROUND_OFF = 1e-10

AxesLike = Axes | Sequence[Axes] | NDArray[np.object_]
"""One Axes of matplotlib or several, such as an array from ``plt.subplots``."""


@dataclass(frozen=True)
class Layout:
    """Panels of a figure: their number, their height together in inches, and their maker."""

    count: int
    height: float
    make: Callable[[Figure], list[Axes]]


def grid(
    rows: int,
    columns: int,
    height: float,
    *,
    count: int | None = None,
    narrow: int = 1,
    **options: Any,
) -> Layout:
    """Panels in rows and columns; options are those of ``Figure.subplots``, as ``sharex=True``.

    A last row that is not full stands in the middle.

    Parameters
    ----------
    rows, columns : int
    height : float
        Height of all rows in inches, without the header.
    count : int, optional
        Number of panels, where the last row is not full.
    narrow : int
        Columns at most on a narrow page, where the panels of a row go on in further rows.

    Returns
    -------
    Layout
    """
    number = rows * columns if count is None else count
    if is_narrow() and columns > narrow:
        before, columns = rows, narrow
        rows = -(-number // columns)
        height *= rows / before
        if options.get("sharex") == "col":
            # Panels of different columns stand under each other now.
            options["sharex"] = False

    def make(figure: Figure) -> list[Axes]:
        panels = list(figure.subplots(rows, columns, squeeze=False, **options).flat)
        for axes in panels[number:]:
            axes.remove()
        panels, lacking = panels[:number], rows * columns - number
        if lacking:
            # Half columns, of which each panel takes two.
            heights = options.get("height_ratios")
            cells = figure.add_gridspec(rows, 2 * columns, height_ratios=heights)
            for place, axes in enumerate(panels):
                row, column = divmod(place, columns)
                start = 2 * column + (lacking if row == rows - 1 else 0)
                axes.set_subplotspec(cells[row, start : start + 2])
                if row == rows - 2:
                    # No panel stands in line below this one, whose numbers could be read.
                    axes.tick_params(labelbottom=True)
        return panels

    return Layout(number, height, make)


def tiles(
    count: int, columns: int, panel: float = TILE, *, extra: float = 0.0, **options: Any
) -> Layout:
    """Panels of one size in as many rows as they need; further options are those of ``grid``.

    Parameters
    ----------
    count, columns : int
        Number of panels, and how many stand in a row at most.
    panel, extra : float
        Height of a row, and what stands between them and the header, in inches.

    Returns
    -------
    Layout
    """
    columns = min(count, columns)
    rows = -(-count // columns)
    return grid(rows, columns, rows * panel + extra, count=count, **options)


@dataclass(frozen=True)
class Sheet:
    """Panels to draw in.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    panels : list of Axes
    is_new : bool
        Whether the figure is made for them; else they are the user's.
    """

    figure: Figure
    panels: list[Axes]
    is_new: bool = True

    def header(
        self, handles: Sequence[Artist], title: str = "", *, of: xr.Dataset | None = None
    ) -> None:
        """Put legend and title above the panels; the legend alone on the first of the user's.

        Both begin at the left edge of the first panel, or of a narrow page. Entries run along the
        rows, as many a row as the figure's width holds.

        Parameters
        ----------
        handles : sequence of matplotlib.artist.Artist
            With their labels.
        title : str
            Heading; none by default. Lines are broken where the figure ends.
        of : Dataset, optional
            Whose mechanism is named above the heading, if it has one, and the rotation terms that
            are counted, if some are not.
        """
        if not self.is_new:
            if handles:
                self.panels[0].legend(handles=handles)
            return
        name, room = "" if of is None else mechanism_name(of), _heading_width()
        terms = "" if of is None else terms_text(of)
        texts = (name, terms[:1].upper() + terms[1:], *title.split("\n"))
        lines = [line for text in texts for line in wrapped(text, room)]
        columns = legend_columns([str(handle.get_label()) for handle in handles])
        rows = -(-len(handles) // columns) + len(lines)
        height = 0.12 + 0.165 * rows
        self.figure.set_figheight(self.figure.get_figheight() + height)
        below = 1.0 - height / self.figure.get_figheight()
        layout = self.figure.get_layout_engine()
        if isinstance(layout, ConstrainedLayoutEngine):
            layout.set(rect=(0.0, 0.0, 1.0, below))
        # A narrow page has no room to lose beside its axes.
        page = self.figure.transFigure
        left_edge = page if is_narrow() else self.panels[0].transAxes
        self.figure.legend(
            # Matplotlib fills a legend column by column; every column but the last ones is full.
            handles=[handle for start in range(columns) for handle in handles[start::columns]],
            loc="upper left",
            bbox_to_anchor=(0.02 * is_narrow(), 1.0 - 0.05 / self.figure.get_figheight()),
            bbox_transform=blended_transform_factory(left_edge, page),
            borderpad=0.0,
            borderaxespad=0.0,
            alignment="left",
            ncols=columns,
            title="\n".join(lines) or None,
        )

    def title(self, axes: Axes, text: str, **options: Any) -> None:
        """Head a panel that has no axis on top; options are those of ``set_title``."""
        # Matplotlib would measure the numbers of its axes several times to find room for a title.
        axes.set_title(text, y=1.0 if self.is_new else None, **options)

    def colour_bar(self, colours: ScalarMappable, label: str, **options: Any) -> None:
        """Put the scale of colours beside the panels; options are those of ``colorbar``."""
        look = {"pad": 0.02, "aspect": 30} | options
        bar = self.figure.colorbar(colours, ax=self.panels, **look)
        bar.set_label(label)
        bar.outline.set_linewidth(0.6)

    def label_x(self, label: str, which: slice = slice(None)) -> None:
        """Label the x axes, of all panels or some of them, where there are numbers along them."""
        for axes in self.panels[which]:
            if axes.xaxis.get_tick_params().get("labelbottom", True):
                axes.set_xlabel(label)

    def label_y(self, label: str) -> None:
        """Label the y axes with numbers, or all of several panels of a new figure at once."""
        if self.is_new and len(self.panels) > 1:
            self.figure.supylabel(label)
        else:
            for axes in self.panels:
                if axes.yaxis.get_tick_params().get("labelleft", True):
                    axes.set_ylabel(label)


@contextmanager
def sheet(layout: Layout, *, ax: AxesLike | None = None, fewer: str = "") -> Iterator[Sheet]:
    """Panels of a new figure in the publication style, or the user's under his settings.

    Parameters
    ----------
    layout : Layout
        Layout of a new figure; the user's panels must be as many.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.
    fewer : str
        Choice that leaves one panel, for the message, such as "choose one mode".

    Yields
    ------
    Sheet

    Raises
    ------
    InputError
        If ``ax`` is not as many Axes as there are panels.
    """
    if ax is not None:
        panels = _given(ax, layout.count, fewer)
        # Letters and lines are the user's; headings stand at the left in any case.
        with mpl.rc_context({"axes.titlelocation": "left"}):
            yield Sheet(panels[0].figure.figure, panels, is_new=False)
        return
    with publication_style():
        figure = new_figure(layout.height)
        yield Sheet(figure, layout.make(figure))
        if any(axes.get_ylabel() for axes in figure.axes):
            # Alignment measures the numbers of all panels for each of them.
            figure.align_ylabels()


def _given(ax: AxesLike, count: int, fewer: str) -> list[Axes]:
    """Panels of the user, as many as there must be."""
    given = list(np.ravel(np.array(ax, dtype=object)))
    wrong = [each for each in given if not isinstance(each, Axes)]
    if wrong:
        raise InputError(f"ax: must be Axes of matplotlib or several of them, got {wrong[0]!r}")
    if len(given) != count:
        remedy = f", or {fewer}, which leaves one panel" if fewer and count > 1 else ""
        panels = f"{count} panel{'' if count == 1 else 's'}"
        raise InputError(
            f"ax: this figure has {panels} and {len(given)} Axes are given; give one Axes a panel"
            + remedy
        )
    return given


def _heading_width() -> float:
    """Width in inches that a legend and a title may take."""
    return figure_width() - (0.1 if is_narrow() else BESIDE_PANELS)


def legend_columns(labels: list[str]) -> int:
    """Columns of legend entries, filled along the rows, that the figure's width holds.

    As few rows as possible, and these as equally filled as possible.
    """
    with publication_style():
        em = mpl.rcParams["legend.fontsize"] / 72
        around = mpl.rcParams["legend.handlelength"] + mpl.rcParams["legend.columnspacing"] + 0.8
    widths = [(around + MEAN_LETTER * len(label)) * em for label in labels]

    def fits(columns: int) -> bool:
        needed: float = sum(max(widths[n::columns], default=0.0) for n in range(columns))
        return needed <= _heading_width()

    count = max(len(labels), 1)
    most = next((n for n in range(count, 1, -1) if fits(n)), 1)
    balanced = -(-count // -(-count // most))
    return balanced if fits(balanced) else most


def wrapped(text: str, width: float) -> list[str]:
    """Lines of a heading that a width holds, broken at words, in letters of the style.

    Parameters
    ----------
    text : str
    width : float
        In inches.

    Returns
    -------
    list of str
    """
    with publication_style():
        letters = int(width * 72 / (MEAN_LETTER * mpl.rcParams["legend.title_fontsize"]))
    return textwrap.wrap(text, letters)


def height_of(limits: Bbox, width: float, least: float, most: float) -> float:
    """Height of a panel of a width that shows what is within limits at one scale.

    Parameters
    ----------
    limits : Bbox
    width, least, most : float
        Width of the panel, and what its height may be, in inches.

    Returns
    -------
    float
    """
    return float(min(max(width * limits.height / limits.width, least), most))


def round_enlargement(displacement: FloatArray, extent: float, part: float) -> float:
    """Factor that draws the greatest displacement as a part of a linkage's extent.

    Parameters
    ----------
    displacement : ndarray, shape (..., 2)
    extent : float
        In the unit of the displacement.
    part : float
        Wanted.

    Returns
    -------
    float
        1, 2 or 5 times a power of ten, at least 1: the nearest in ratio to what is wanted; 1 where
        the displacement is round-off.
    """
    greatest = float(np.nanmax(np.hypot(displacement[..., 0], displacement[..., 1]), initial=0.0))
    if greatest <= ROUND_OFF * extent:
        return 1.0
    wanted = max(part * extent / greatest, 1.0)
    decade = 10.0 ** np.floor(np.log10(wanted))
    rounds = [float(round(step * decade)) for step in (1, 2, 5, 10)]
    return min(rounds, key=lambda value: abs(np.log(value / wanted)))


def round_length(most: float) -> float:
    """Longest of 1, 2 and 5 times a power of ten that is not above a length."""
    decade = 10.0 ** np.floor(np.log10(most))
    return float(decade * max(step for step in (1, 2, 5) if step * decade <= most * (1 + 1e-9)))
