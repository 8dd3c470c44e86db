"""The look of series: each has a colour, a dash and a marker of its own."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

from matplotlib.artist import Artist
from matplotlib.lines import Line2D

from flexmech.errors import InputError
from flexmech.types import FloatArray

# Below this number of angles each computed point is marked: a line alone would suggest a
# resolution that is not there, and a single point would not show at all.
FEW_POINTS = 10
POINT_SIZE = 3.0
Look = dict[str, Any]
"""Properties of a line or a marker, as matplotlib names them."""


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


def series_style(number: int) -> SeriesStyle:
    """Style of the series of a given number from 0; repeats after six."""
    return SERIES_STYLES[number % len(SERIES_STYLES)]


def series_line(number: int, points: FloatArray | None = None) -> Look:
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


def line_handle(label: str, **properties: Any) -> Artist:
    """Legend entry with the properties of a ``Line2D``."""
    return Line2D([], [], label=label, **properties)


def series_handle(number: int, label: str, **properties: Any) -> Artist:
    """Legend entry in the style of a series; properties are those of ``Line2D``."""
    return line_handle(label, **(series_line(number) | properties))


def series_handles(labels: Iterable[str], points: FloatArray | None = None) -> list[Artist]:
    """Legend entries of series in order; each of the points is marked where they are few."""
    return [line_handle(label, **series_line(n, points)) for n, label in enumerate(labels)]


def told_apart(names: list[str]) -> list[str]:
    """Names of series, if there are some and each can have a style of its own."""
    if not 1 <= len(names) <= len(SERIES_STYLES):
        raise InputError(f"one to {len(SERIES_STYLES)} series can be drawn, got {len(names)}")
    return names


def few_points(points: FloatArray) -> bool:
    """Whether the points are few enough to mark each of them."""
    return points.size <= FEW_POINTS
