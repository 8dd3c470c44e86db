"""The publication style: style sheet, page widths, the look of series, and figures as files."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from flexmech.arrays import FloatArray
from flexmech.errors import InputError

# In inches.
MILLIMETRE = 1 / 25.4
# Width in mm of a page of two columns, as journals have it.
TWO_COLUMNS = 180.0
# In mm, half way between the widths of one and of two columns of a journal's page: below it panels
# stand under each other, and letters are a point smaller.
NARROW = 130.0
# Narrower pages cannot hold a legend's entries, wider ones no printer takes.
LEAST_WIDTH, MOST_WIDTH = 80.0, 400.0
# Greys of fillings and lines behind curves, seen beside white, and of words and lines to be
# read.
LIGHT_GREY = "0.90"
MID_GREY = "0.45"
# Size of words inside panels, in points: one less than the numbers along the axes have.
LABEL_POINTS = 7.0
# What the labels of the y axis take of a figure's width in inches, on the safe side.
BESIDE_PANELS = 0.85
# What two axes along x, one below and one on top, take of a figure's height in inches: two rows of
# numbers and two of words.
AXES_HEIGHT = 0.9
TIMES = "\N{MULTIPLICATION SIGN}"
STYLE, NARROW_STYLE = (
    mpl.rc_params_from_file(Path(__file__).with_name(name), use_default_template=False)
    for name in ("publication.mplstyle", "narrow.mplstyle")
)
# An inch: of what is drawn as pixels in a file of lines and letters, such as a spectrogram, as
# journals ask for it.
FINE_DOTS = 300
# Without the time of writing: the same result gives the same file.
UNDATED: dict[str, dict[str, Any]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}

_width: ContextVar[float] = ContextVar("page width in mm", default=TWO_COLUMNS)

# Below this number of angles each computed point is marked: a line alone would suggest a
# resolution that is not there, and a single point would not show at all.
FEW_POINTS = 10
# Size of these marks in points: twice a line's width and more, so that they are seen on it.
POINT_SIZE = 3.0
Look = dict[str, Any]
"""Properties of a line or a marker, as matplotlib names them."""


def figure_width() -> float:
    """Width of new figures in inches: that of a page of two columns, unless another is set."""
    return _width.get() * MILLIMETRE


def is_narrow() -> bool:
    """Whether new figures are as wide as one column of a page, so that panels are stacked."""
    return _width.get() < NARROW


@contextmanager
def page_width(millimetres: float) -> Iterator[None]:
    """Width of the figures that are made in this context.

    On a narrow page panels stand under each other and letters are a point smaller.

    Parameters
    ----------
    millimetres : float
        88 fits one column of the usual journals, 180 (the default) two.

    Raises
    ------
    InputError
        If nothing could be read at this width.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/rotating_arm.toml")
    >>> check = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism))
    >>> with flexmech.plots.page_width(88):
    ...     figure = check.plot()
    >>> round(figure.get_figwidth() * 25.4)
    88
    """
    if not LEAST_WIDTH <= millimetres <= MOST_WIDTH:
        raise InputError(
            f"page width: must lie between {LEAST_WIDTH:g} and {MOST_WIDTH:g} mm, got "
            f"{millimetres:g}"
        )
    token = _width.set(float(millimetres))
    try:
        yield
    finally:
        _width.reset(token)


class _NotebookFigure(Figure):
    """Figure that a notebook shows by itself, though pyplot does not know of it."""

    def _repr_png_(self) -> bytes:
        return figure_png(self)


def figure_png(figure: Figure) -> bytes:
    """Picture of a figure as the content of a PNG file."""
    picture = BytesIO()
    _write_png(figure, picture, figure.dpi)
    return picture.getvalue()


def _write_png(figure: Figure, target: Path | BytesIO, dpi: float) -> None:
    """Lay out a figure and draw it: ``savefig`` draws one that has its layout to come twice."""
    layout, resolution = figure.get_layout_engine(), figure.dpi
    figure.dpi = dpi
    try:
        if layout is not None:
            layout.execute(figure)
        # What a user may have set for figures without a layout of their own.
        with mpl.rc_context({"figure.autolayout": False, "figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)
        figure.savefig(target, format="png", dpi=dpi)
    finally:
        figure.set_layout_engine(layout)
        figure.dpi = resolution


def figure_html(figure: Figure) -> str:
    """Write a figure as an HTML image that holds its own data."""
    return f'<img src="data:image/png;base64,{b64encode(figure_png(figure)).decode()}"/>'


def new_figure(height: float) -> Figure:
    """Empty figure of the page's width and the given height in inches, laid out on drawing."""
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05, wspace=0.03, hspace=0.03)
    return _NotebookFigure(figsize=(figure_width(), height), dpi=150, layout=layout)


def save_figure(figure: Figure, path: Path, *, dpi: int) -> None:
    """Write a figure into a file of the format that its name ends with.

    A PDF embeds its letters as TrueType (Type 42), an SVG holds them as text in DejaVu Sans, so
    that both can be searched and edited.

    Parameters
    ----------
    figure : Figure
    path : Path
        Ends in ``.png``, ``.pdf`` or ``.svg``.
    dpi : int
        Dots per inch of a PNG; what is pixels in the other formats has at least 300.
    """
    kind = path.suffix.removeprefix(".")
    with publication_style():
        if kind == "png":
            _write_png(figure, path, dpi)
        else:
            figure.savefig(path, dpi=max(dpi, FINE_DOTS), metadata=UNDATED[kind])


@contextmanager
def publication_style() -> Iterator[None]:
    """Matplotlib settings of the figures, for as long as the context lasts.

    The plotting functions enter it themselves; enter it too around ``savefig`` to get
    300 dots per inch and fonts that a PDF editor can edit.
    """
    with mpl.rc_context(STYLE), mpl.rc_context(NARROW_STYLE if is_narrow() else None):
        yield


@dataclass(frozen=True)
class SeriesStyle:
    """Look of one series, distinct from the others in colour and without it."""

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


def series_style(number: int) -> SeriesStyle:
    """Style of the series of a given number from 0; repeats after six."""
    return SERIES_STYLES[number % len(SERIES_STYLES)]


def series_line(number: int, points: FloatArray | None = None) -> Look:
    """Properties of a series' line; each of the points is marked where they are few.

    Parameters
    ----------
    number : int
        Number of the series, from 0.
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


def line_handle(label: str, **properties: Any) -> Artist:
    """Legend entry with the properties of a ``Line2D``."""
    return Line2D([], [], label=label, **properties)


def legend_handles(looks: Mapping[str, Look]) -> list[Artist]:
    """Legend entries by their labels: lines, and patches where a look has a face."""
    return [
        (Patch(label=label, **look) if "facecolor" in look else line_handle(label, **look))
        for label, look in looks.items()
    ]


def series_handle(number: int, label: str, **properties: Any) -> Artist:
    """Legend entry in the style of a series; properties are those of ``Line2D``."""
    return line_handle(label, **(series_line(number) | properties))


def distinct_names(names: list[str]) -> list[str]:
    """Names of series, if there are some and each can have a style of its own."""
    if not 1 <= len(names) <= len(SERIES_STYLES):
        raise InputError(f"one to {len(SERIES_STYLES)} series can be drawn, got {len(names)}")
    return names


def few_points(points: FloatArray) -> bool:
    """Whether the points are few enough to mark each of them."""
    return points.size <= FEW_POINTS
