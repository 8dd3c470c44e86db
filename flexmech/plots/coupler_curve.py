"""Coupler curves with their double points, paths of the pins, and angles of the links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.errors import InputError
from flexmech.plots.style import (
    MID_GREY,
    POINT_SIZE,
    SERIES_STYLES,
    crank_angle_axis,
    few_points,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["DrawnPath", "plot_coupler_angles", "plot_coupler_curve"]


HEIGHT, HEIGHT_OF_THREE = 3.6, 2.4
ANGLE_HEIGHT = 4.2
CLOSE_UP_ROOM = 1.5
# Above this extent in m a picture is in m, below it in mm.
METRES = 10.0
MARKS = {"crunode": "o", "cusp": "^"}


@dataclass(frozen=True)
class DrawnPath:
    """What is drawn of a coupler point's path.

    Parameters
    ----------
    crank_angle : ndarray, shape (A,)
        In rad.
    position : ndarray, shape (A, 2)
        Of the coupler point in m.
    pins : ndarray, shape (A, 2, 2)
        Of A and B in m.
    angles : ndarray, shape (A, 2)
        Of coupler and rocker in rad.
    double_points : tuple of tuple of str and ndarray
        Kind (``"crunode"`` or ``"cusp"``) and place (2,) of each in m.
    close_up : tuple of ndarray, shape (K, 2)
        Stretches of the path around loops of any state, finely drawn, in m.
    framed : ndarray, shape (F, 2)
        Places that the close-up shall show, in m.
    """

    crank_angle: FloatArray
    position: FloatArray
    pins: FloatArray
    angles: FloatArray
    double_points: tuple[tuple[str, FloatArray], ...] = ()
    close_up: tuple[FloatArray, ...] = ()
    framed: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))


def plot_coupler_curve(paths: Mapping[str, DrawnPath], title: str = "") -> Figure:
    """Draw coupler curves of one linkage in several states, their double points and the pins.

    As Singh & Sanyal 2022, Figures 3 to 12.

    Parameters
    ----------
    paths : mapping of str to DrawnPath
        By what the legend calls their states.
    title : str

    Returns
    -------
    Figure
        Curves; a close-up of their loops where there are any; paths of A and B.

    Raises
    ------
    InputError
        If there are no paths, or more than there are styles to tell them apart.
    """
    _refuse_count(paths)
    close = any(path.close_up for path in paths.values())
    scale, unit = _unit(paths)
    with publication_style():
        handles = _state_handles(paths, counted=True) + _mark_handles(paths)
        figure = new_figure((HEIGHT_OF_THREE if close else HEIGHT) + header_height(handles, title))
        panels = figure.subplots(1, 3 if close else 2)
        _draw_paths(panels[0], paths, scale, unit, close_up=False)
        panels[0].set_title("Coupler point")
        if close:
            _draw_paths(panels[1], paths, scale, unit, close_up=True)
            _frame(panels[1], scale * np.concatenate([path.framed for path in paths.values()]))
            panels[1].set_title("Close-up of the loops")
        _draw_pins(panels[-1], paths, scale, unit)
        header_legend(figure, handles, title)
    return figure


def plot_coupler_angles(paths: Mapping[str, DrawnPath], title: str = "") -> Figure:
    """Draw the angles of coupler and rocker against the crank's, and how they change.

    Parameters
    ----------
    paths : mapping of str to DrawnPath
        By what the legend calls their states; changes are against the first.
    title : str

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no paths, or more than there are styles to tell them apart.
    """
    _refuse_count(paths)
    first = next(iter(paths.values()))
    degrees = np.degrees(first.crank_angle)
    changes = len(paths) > 1
    with publication_style():
        handles = _state_handles(paths, counted=False)
        height = ANGLE_HEIGHT if changes else ANGLE_HEIGHT / 2 + 0.5
        figure = new_figure(height + header_height(handles, title))
        panels = figure.subplots(2 if changes else 1, 2, sharex=True, squeeze=False)
        for link, name in enumerate(("Coupler", "Rocker")):
            symbol = rf"$\theta_{link + 3}$"
            panels[0, link].set_title(f"{name}, {symbol}")
            for number, path in enumerate(paths.values()):
                line = _line(number, path)
                panels[0, link].plot(degrees, np.degrees(path.angles[:, link]), **line)
                if number:
                    change = _nearest(path.angles[:, link] - first.angles[:, link])
                    panels[1, link].plot(degrees, np.degrees(change), **line)
            for axes in panels[:, link]:
                plain_numbers(axes)
            panels[0, link].set_ylabel(f"{symbol} (deg)")
            if changes:
                panels[1, link].axhline(0.0, color=MID_GREY, lw=0.6, zorder=1)
                panels[1, link].set_ylabel(f"Change of {symbol} (deg)")
            crank_angle_axis(panels[-1, link], degrees)
            panels[-1, link].set_xlabel("Crank angle (deg)")
        header_legend(figure, handles, title)
    return figure


def _refuse_count(paths: Mapping[str, DrawnPath]) -> None:
    if not 1 <= len(paths) <= len(SERIES_STYLES):
        raise InputError(f"one to {len(SERIES_STYLES)} paths can be drawn, got {len(paths)}")


def _line(number: int, path: DrawnPath) -> dict[str, Any]:
    """Style of a state's line, marked at each computed point where these are few."""
    style = series_style(number)
    marker = style.marker if few_points(path.crank_angle) else None
    return {
        "color": style.color,
        "linestyle": style.linestyle,
        "marker": marker,
        "markersize": POINT_SIZE,
    }


def _unit(paths: Mapping[str, DrawnPath]) -> tuple[float, str]:
    extent = max(float(np.ptp(path.position, axis=0).max()) for path in paths.values())
    return (1.0, "m") if extent > METRES else (1e3, "mm")


def _state_handles(paths: Mapping[str, DrawnPath], *, counted: bool) -> list[Artist]:
    handles: list[Artist] = []
    for number, (state, path) in enumerate(paths.items()):
        style = series_style(number)
        label = f"{state}: {_counts(path)}" if counted else state
        handles.append(Line2D([], [], color=style.color, linestyle=style.linestyle, label=label))
    return handles


def _counts(path: DrawnPath) -> str:
    kinds = [kind for kind, _ in path.double_points]
    words = [f"{kinds.count(k)} {k}{'' if kinds.count(k) == 1 else 's'}" for k in MARKS]
    return ", ".join(words)


def _mark_handles(paths: Mapping[str, DrawnPath]) -> list[Artist]:
    kinds = {kind for path in paths.values() for kind, _ in path.double_points}
    # Beyond the crank angles drawn, marks stand off the lines.
    whole = all(np.ptp(path.crank_angle) > 2 * np.pi - 1e-6 for path in paths.values())
    where = "" if whole else " of the whole curve"
    hollow: dict[str, Any] = {"color": "black", "linestyle": "", "markerfacecolor": "none"}
    return [
        Line2D([], [], marker=mark, label=f"{kind}{where}", **hollow)
        for kind, mark in MARKS.items()
        if kind in kinds
    ]


def _draw_paths(
    axes: Axes, paths: Mapping[str, DrawnPath], scale: float, unit: str, *, close_up: bool
) -> None:
    for number, path in enumerate(paths.values()):
        style = series_style(number)
        # A close-up is fine whatever the crank angles.
        line = _line(number, path) | ({"marker": None} if close_up else {})
        for part in path.close_up if close_up else (path.position,):
            axes.plot(*(scale * part.T), **line)
        for kind, place in path.double_points:
            axes.plot(
                *(scale * place),
                marker=MARKS[kind],
                markersize=6,
                markerfacecolor="none",
                color=style.color,
                zorder=4,
            )
    _label(axes, unit)


def _draw_pins(axes: Axes, paths: Mapping[str, DrawnPath], scale: float, unit: str) -> None:
    for number, path in enumerate(paths.values()):
        for pin in (0, 1):
            place = scale * path.pins[:, pin]
            axes.plot(*place.T, **_line(number, path))
            if number == 0:
                top = place[place[:, 1].argmax()]
                axes.annotate(
                    "AB"[pin], top, xytext=(0, 3), textcoords="offset points", ha="center"
                )
    _label(axes, unit)
    axes.margins(y=0.12)
    axes.set_title("Pins A and B")


def _label(axes: Axes, unit: str) -> None:
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_box_aspect(1)
    axes.set_xlabel(f"x ({unit})")
    axes.set_ylabel(f"y ({unit})")


def _frame(axes: Axes, places: FloatArray) -> None:
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    half = CLOSE_UP_ROOM * float(np.ptp(places, axis=0).max()) / 2
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)


def _nearest(change: FloatArray) -> FloatArray:
    """A change of angle without the whole turns that two unwrapped angles may be apart."""
    return np.asarray(change - 2 * np.pi * np.round(change.mean() / (2 * np.pi)))
