"""Pictures drawn by matplotlib: their panes, axes, legend, and lines that vibrate fast."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import WRAPPER_ASSIGNMENTS, wraps
from typing import Any, Protocol, cast

import numpy as np
import xarray as xr
from matplotlib import rcParams, rcParamsDefault
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.arrays import FloatArray
from flexmech.plots import angle_panels, scales
from flexmech.plots.layout import AxesLike, Layout, Sheet, sheet, tiles
from flexmech.plots.picture import Curve, Pane, Picture, Span
from flexmech.plots.reading import spread
from flexmech.plots.style import MID_GREY, Look, legend_handles, line_handle

# Width in points of a line with at most so many turning points in a panel of 450 points' width, so
# that waves stay apart.
LINE_WIDTHS = ((80, 1.1), (350, 0.7), (np.inf, 0.5))
# The waves of a line with more turning points in a panel of that width run together into a blot:
# its envelope is drawn, by the least and greatest value in each of so many stretches.
MOST_TURNING_POINTS, STRETCHES = 700, 300
ENVELOPE: Look = {"alpha": 0.25, "lw": 0.0}
# Between turning points a line goes up or down by this part of its panel, less is hardly seen.
RIPPLE = 0.03
# Width of a panel over that of the figure, of one that has a row for itself.
ALONE = float(rcParamsDefault["figure.subplot.right"] - rcParamsDefault["figure.subplot.left"])
# Opacity of a line that turns at more than a third of its samples, so that each wave has less than
# six, and at more than so many places: it is a band, through which others are seen.
VEIL = 0.6
# Height of a label in inches, with some room.
LABEL_HEIGHT = 0.12
# Above the first of the rows of a pane and below the last, over their distance.
ROW_ROOM = 0.6
# Entries of looks that say where something is drawn.
NOT_IN_LEGEND = ("zorder", "ymax", "markevery", "clip_on")
MOST_TURNING, LEAST_VEILED = 0.33, 100


class PlotFunction(Protocol):
    """Function that draws a dataset: into a new figure, or into the user's axes."""

    picture: Callable[[xr.Dataset], Picture]
    """The picture that it draws, which the page of a report shows too."""

    def __call__(self, dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
        """Draw a dataset."""


def figure(picture: Callable[[xr.Dataset], Picture]) -> PlotFunction:
    """Turn a function that selects what a picture shows into one that draws it.

    Parameters
    ----------
    picture : callable
        From a dataset to its picture; its docstring is that of the function that draws.

    Returns
    -------
    callable
        Plot function with ``ax`` as a keyword; ``picture`` is an attribute of it.
    """

    @wraps(picture, [name for name in WRAPPER_ASSIGNMENTS if name != "__annotations__"])
    def plot(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
        return draw(picture(dataset), ax=ax)

    # Signature and types are those of the function that draws.
    made: Any = plot
    del made.__wrapped__
    made.picture = picture
    return cast(PlotFunction, made)


def draw(picture: Picture, *, ax: AxesLike | None = None) -> Figure:
    """Draw a picture into a new figure, or into the user's axes.

    Parameters
    ----------
    picture : Picture
    ax : Axes or sequence of Axes, optional
        The user's, one a pane.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If ``ax`` is not as many Axes as there are panes.
    """
    with drawing(picture, ax=ax) as drawn:
        return drawn.figure


@contextmanager
def drawing(picture: Picture, *, ax: AxesLike | None = None) -> Iterator[Sheet]:
    """Panels with a picture in them, to which more can be added by hand.

    Parameters
    ----------
    picture : Picture
    ax : Axes or sequence of Axes, optional
        The user's, one a pane.

    Yields
    ------
    Sheet

    Raises
    ------
    InputError
        If ``ax`` is not as many Axes as there are panes.
    """
    picture = picture.in_units()
    with sheet(picture.layout or _layout(picture), ax=ax, fewer=picture.fewer) as drawn:
        handles = _legend(picture) if picture.legend is None else legend_handles(picture.legend)
        if any(_is_blot(drawn.panels[0], one) for pane in picture.panes for one in pane.curves):
            handles.append(Patch(color="0.35", label="envelope of the vibration", **ENVELOPE))
        drawn.header(handles, picture.title, of=picture.of)
        _draw_panes(drawn, picture)
        if picture.colours:
            drawn.colour_bar(*picture.colours)
        yield drawn


def _layout(picture: Picture) -> Layout:
    """Panels of a picture that has no layout of its own."""
    count = len(picture.panes)
    if picture.over == "time":
        return scales.time_layout(count)
    return angle_panels.angle_layout([1] * count) if picture.over == "angle" else tiles(count, 2)


def _draw_panes(drawn: Sheet, picture: Picture) -> None:
    """Draw the panes of a picture in their units, and scale and label all axes."""
    pairs = list(zip(drawn.panels, picture.panes, strict=True))
    shared = replace(drawn, panels=[axes for axes, pane in pairs if not pane.apart])
    if picture.over == "angle":
        scales.label_angles(shared, picture.places)
    elif picture.over == "time":
        scales.label_times(shared, picture.of)
    elif picture.over == "speed":
        for axes in shared.panels:
            axes.set_xlim(*scales.speed_limits(picture.of))
    elif picture.places.size:
        for axes in shared.panels:
            axes.set_xlim(float(picture.places[0]), float(picture.places[-1]))
    for axes, pane in pairs:
        draw_pane(axes, pane)
        if "plane" in (pane.apart, picture.over):
            axes.set_aspect("equal", adjustable="datalim")
        if pane.title:
            drawn.title(axes, pane.title)
    if picture.x_label:
        shared.label_x(picture.x_label)
    if picture.y_label:
        drawn.label_y(picture.y_label)
    if picture.over == "speed":
        scales.second_speed_axis(drawn.panels[0], picture.of)


def _legend(picture: Picture) -> list[Artist]:
    """Entries of curves and spans in order, those of one name once."""
    named: dict[str, list[Curve | Span]] = {}
    for kind in ("curves", "spans"):
        for pane in picture.panes:
            for one in getattr(pane, kind):
                named.setdefault(one.name, []).append(one)
    return [_entry(same) for name, same in named.items() if name]


def _entry(same: Sequence[Curve | Span]) -> Artist:
    """Legend entry of curves or spans of one name: bands of several colours are grey."""
    one = same[0]
    filled = one.is_filled if isinstance(one, Span) else one.upto is not None
    look = {key: value for key, value in one.look.items() if key not in NOT_IN_LEGEND}
    if not filled:
        return line_handle(one.name, **look)
    if any(other.look.get("color") != look.get("color") for other in same):
        look["color"] = MID_GREY
    return Patch(label=one.name, **_hatched(look))


def _hatched(look: Look) -> Look:
    """Look of a filling, whose hatch is white on its colour."""
    if not look.get("hatch") or "color" not in look:
        return look
    rest = {key: value for key, value in look.items() if key != "color"}
    return rest | {"facecolor": look["color"], "edgecolor": "white"}


def draw_pane(axes: Axes, pane: Pane) -> None:
    """Draw the spans and curves of a pane, and scale and label its axis along y.

    Parameters
    ----------
    axes : Axes
    pane : Pane
        In its unit.
    """
    for span in pane.spans:
        if span.is_filled:
            fill = axes.axvspan if span.upright else axes.axhspan
            fill(span.low, span.high, **span.look)
        else:
            line = axes.axvline if span.upright else axes.axhline
            line(span.low, **span.look)
    for number, curve in enumerate(pane.curves):
        if curve.upto is not None:
            axes.fill_between(curve.x, curve.y, curve.upto, **_hatched(curve.look))
        elif curve.wave:
            _draw_wave(axes, curve, filled=number == 0)
        else:
            axes.plot(curve.x, curve.y, **curve.look)
            _mark_lone_points(axes, curve)
    if pane.scale != "linear":
        low, high = pane.limits or axes.get_ylim()
        scales.log_scale(axes, low, high, plain=pane.scale == "plain log")
    else:
        scales.plain_numbers(axes)
        if pane.limits:
            axes.set_ylim(*pane.limits)
    if len(pane.x_ticks):
        axes.set_xticks(pane.x_ticks)
    if pane.x_limits:
        axes.set_xlim(*pane.x_limits)
    if pane.apart == "none":
        axes.xaxis.set_visible(False)
        axes.spines["bottom"].set_visible(False)
    if pane.ticks:
        axes.set_yticks(pane.ticks)
    if pane.named:
        axes.set_xticks(range(1, len(pane.named) + 1), pane.named)
    if pane.rows:
        axes.set_yticks(range(1, len(pane.rows) + 1), pane.rows)
        axes.set_ylim(len(pane.rows) + ROW_ROOM, 1 - ROW_ROOM)
    if pane.along:
        axes.set_xlabel(pane.along)
    for note in pane.notes:
        across: Look = {"transform": axes.get_xaxis_transform()} if note.high else {}
        axes.text(note.x, note.y, note.text, **across, **note.look)
    _label_ends(axes, pane)
    if pane.label:
        axes.set_ylabel(pane.label)
    if pane.right:
        factor = pane.right.factor
        there_and_back = (lambda value: factor * value, lambda value: value / factor)
        axes.secondary_yaxis("right", functions=there_and_back).set_ylabel(pane.right.label)


def _label_ends(axes: Axes, pane: Pane) -> None:
    """Write what stands at the ends of curves: beside the axes, apart from each other, or in them.

    A curve that leaves the axes at their top has its label to the left of it, as above may stand
    another axis.
    """
    look: Look = {"textcoords": "offset points", "fontsize": rcParams["xtick.labelsize"]}
    right, aside = axes.get_xlim()[1], list[tuple[float, Curve]]()
    bottom = axes.get_ylim()[0]
    for one in pane.curves:
        # What lies below a logarithmic axis has no place on it.
        if not one.label or not np.isfinite(one.y[-1]) or (bottom > 0 and one.y[-1] <= 0):
            continue
        end = float(one.x[-1]), float(one.y[-1])
        if len(one.x) > 1 and one.x[-1] >= right:
            aside.append((float((axes.transData - axes.transAxes).transform(end)[1]), one))
            continue
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
        inside: Look = {"xytext": (-2, -3), "ha": "right", "va": "top", "bbox": box}
        axes.annotate(one.label, end, color=_ink(one), **inside, **look)
    height = axes.get_position().height * axes.figure.bbox.height / axes.figure.dpi
    aside.sort(key=lambda pair: pair[0])
    places = spread(np.array([place for place, _ in aside]), LABEL_HEIGHT / height)
    for place, (_, one) in zip(places, aside, strict=True):
        beside: Look = {"xycoords": "axes fraction", "xytext": (4, 0), "va": "center"}
        axes.annotate(one.label, (1.0, float(place)), color=_ink(one), **beside, **look)


def _ink(curve: Curve) -> str:
    """Colour of the words at a curve: its own, or a grey that can be read."""
    colour = curve.look["color"]
    return MID_GREY if np.ptp(to_rgb(colour)) == 0 else str(colour)


def _mark_lone_points(axes: Axes, curve: Curve) -> None:
    """Draw a dot where a value of a named line stands alone, between others that are not known."""
    if curve.look.get("marker") or not curve.name or len(curve.x) < 2:
        return
    present = np.concatenate([[False], np.isfinite(curve.y), [False]])
    alone = present[1:-1] & ~present[:-2] & ~present[2:]
    if alone.any():
        axes.plot(curve.x[alone], curve.y[alone], ".", color=curve.look["color"], ms=3)


def _draw_wave(axes: Axes, curve: Curve, *, filled: bool) -> None:
    """Draw a line against time that may vibrate faster than its panel can show.

    Lines become thinner the more vibrations stand side by side, and translucent where they
    are faster than the samples tell apart: a band through which other lines can be seen. Of
    more vibrations than a panel can show the envelope is drawn.
    """
    if _is_blot(axes, curve):
        time, low, high = _envelope(curve.x, curve.y)
        if filled:
            axes.fill_between(time, low, high, color=curve.look["color"], **ENVELOPE)
        for edge in (low, high):
            axes.plot(time, edge, **(curve.look | {"lw": LINE_WIDTHS[1][1]}))
        return
    turns = _turning_points(curve.y)
    width = next(width for most, width in LINE_WIDTHS if turns <= _room(axes) * most)
    opacity = VEIL if turns > max(MOST_TURNING * curve.y.size, LEAST_VEILED) else 1.0
    wider = curve.wave if opacity == 1.0 else 1.0
    axes.plot(curve.x, curve.y, **curve.look, lw=wider * width, alpha=opacity)


def _is_blot(axes: Axes, curve: Curve) -> bool:
    """Whether the waves of a line run together in a panel."""
    return bool(curve.wave) and _turning_points(curve.y) > _room(axes) * MOST_TURNING_POINTS


def _room(axes: Axes) -> float:
    """Width of a panel over that of one that has a row for itself, at most 1."""
    return min(1.0, axes.get_position(original=True).width / ALONE)


def _turning_points(line: FloatArray) -> int:
    """How often a line turns from rising to falling or back, but for ripples."""
    turns = line[np.flatnonzero(np.diff(np.sign(np.diff(line)))) + 1]
    return int(np.count_nonzero(np.abs(np.diff(turns)) > RIPPLE * np.ptp(line)))


def _envelope(time: FloatArray, line: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, and the least and greatest value of a line about each of them."""
    starts = np.linspace(0, line.size, STRETCHES, endpoint=False).astype(int)
    low, high = (one.reduceat(line, starts) for one in (np.minimum, np.maximum))
    middle = (starts + np.append(starts[1:], line.size) - 1) // 2
    # From the first to the last sample.
    return np.r_[time[0], time[middle[1:-1]], time[-1]], low, high
