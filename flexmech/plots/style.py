"""The publication style: one style sheet, one width, and figures that notebooks show."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

__all__ = [
    "FIGURE_WIDTH",
    "LIGHT_GREY",
    "MID_GREY",
    "STYLE",
    "figure_html",
    "figure_png",
    "new_figure",
    "publication_style",
]

MILLIMETRE = 1 / 25.4
FIGURE_WIDTH = 180 * MILLIMETRE
"""Width of every figure in inches: the full text width of a two-column journal."""
LIGHT_GREY = "0.90"
MID_GREY = "0.45"
STYLE = mpl.rc_params_from_file(
    Path(__file__).with_name("publication.mplstyle"), use_default_template=False
)


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
    """Empty figure of journal width and the given height in inches, laid out on drawing."""
    layout = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.05, wspace=0.03, hspace=0.03)
    return _NotebookFigure(figsize=(FIGURE_WIDTH, height), dpi=150, layout=layout)


@contextmanager
def publication_style() -> Iterator[None]:
    """Matplotlib settings of the figures, for as long as the context lasts.

    The plotting functions enter it themselves; enter it too around ``savefig`` to get
    300 dots per inch and fonts that a PDF editor can edit.
    """
    with mpl.rc_context(STYLE):
        yield
