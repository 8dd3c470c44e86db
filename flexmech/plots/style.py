"""The publication style: one style sheet, the widths of a page, and figures as files."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from flexmech.errors import InputError

MILLIMETRE = 1 / 25.4
TWO_COLUMNS = 180.0
# Below this width in mm panels stand under each other, and letters are a point smaller.
NARROW = 130.0
LEAST_WIDTH, MOST_WIDTH = 80.0, 400.0
LIGHT_GREY = "0.90"
MID_GREY = "0.45"
STYLE, NARROW_STYLE = (
    mpl.rc_params_from_file(Path(__file__).with_name(name), use_default_template=False)
    for name in ("publication.mplstyle", "narrow.mplstyle")
)
# Of what is drawn as pixels in a file of lines and letters, such as a spectrogram.
FINE_DOTS = 300
# Without the time of writing: the same result gives the same file.
UNDATED: dict[str, dict[str, Any]] = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}

_width: ContextVar[float] = ContextVar("page width in mm", default=TWO_COLUMNS)


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
    figure.savefig(picture, format="png", dpi=figure.dpi)
    return picture.getvalue()


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
            figure.savefig(path, dpi=dpi)
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
