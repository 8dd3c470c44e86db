"""A picture as plain data: curves in panes over one axis, for matplotlib and for the report's page.

What is shown of a dataset is written down once, as a :class:`Picture`. ``flexmech.plots.drawing``
draws it by matplotlib, ``flexmech.report.panel`` writes it for plotly; neither computes anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable

from flexmech.arrays import FloatArray
from flexmech.plots.layout import Layout
from flexmech.plots.reading import Units, engine_label, fitting_unit, values_of
from flexmech.plots.style import LIGHT_GREY, Look, series_line

# For bars and bands of several series, whose colours are alike in grey.
HATCHES = ("", "////", "....", "xx", "--")
BARS = 0.8
"""Bars of the distance of two places, that all bars at a place take together."""
Choice = Mapping[str, str]
"""What the reader of a page must have chosen for something to be shown: ``speed``, ``engine``,
``state`` or ``mode``, such as ``{"speed": "20 rad/s"}``; what is not named does not matter."""


@dataclass(frozen=True)
class Curve:
    """A line, points, or a band between two lines.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Not a number is a gap.
    look : dict
        As matplotlib names it: ``color``, ``ls``, ``lw``, ``marker``, ``alpha``, ``zorder``.
    name : str
        In the legend, which has curves of one name once; empty: it is not named.
    upto : ndarray, shape (n,), optional
        The other edge of a band, which is filled; its look is that of a patch.
    wave : float
        For a line against time that may vibrate faster than its pane can show, how much wider
        it is drawn than others; 0 of any other line.
    when : mapping
        What the reader of a page must have chosen for it to be shown.
    followed : mapping or None
        What he must have chosen besides for the cursor's dot to be on it; None: never.
    angle : ndarray, shape (n,), optional
        Crank angle in degrees of each point of a path.
    label : str
        Beside its last point.
    """

    x: FloatArray
    y: FloatArray
    look: Look
    name: str = ""
    upto: FloatArray | None = None
    wave: float = 0.0
    when: Choice = field(default_factory=dict)
    followed: Choice | None = field(default_factory=dict)
    angle: FloatArray | None = None
    label: str = ""


@dataclass(frozen=True)
class Span:
    """A straight line across a pane, or a stripe between two values.

    Parameters
    ----------
    low, high : float
        Equal of a line.
    look : dict
        Look of a line or a patch, as matplotlib names it.
    name : str
        In the legend; empty: it is not named.
    upright : bool
        Whether it stands at a place along x.
    when : mapping
        What the reader of a page must have chosen for it to be shown.
    """

    low: float
    high: float
    look: Look
    name: str = ""
    upright: bool = False
    when: Choice = field(default_factory=dict)

    @property
    def is_filled(self) -> bool:
        """Whether it is a stripe, which may have no width."""
        return self.low < self.high or "facecolor" in self.look


@dataclass(frozen=True)
class Note:
    """Words at a place of a pane.

    Parameters
    ----------
    x, y : float
        In the units of the axes, or ``y`` as a part of the height of the pane.
    text : str
    look : dict
        As matplotlib names it.
    high : bool
        Whether ``y`` is a part of the height.
    """

    x: float
    y: float
    text: str
    look: Look
    high: bool = False


ZERO = Span(0.0, 0.0, {"color": LIGHT_GREY, "lw": 0.6, "zorder": 0})
"""Where a quantity is zero, behind all else."""


@dataclass(frozen=True)
class SecondAxis:
    """A further quantity of a pane, on an axis at its right edge.

    Parameters
    ----------
    label : str
        Without the unit.
    factor : float
        From the pane's quantity in its SI unit to this one in its own, where they are
        proportional.
    units : tuple of (float, str)
        To choose from.
    curves : sequence of Curve
        The further quantity where they are not proportional: both zeros are at one height, and
        the greatest values as far from it.
    """

    label: str
    factor: float
    units: Units
    curves: Sequence[Curve] = ()


@dataclass(frozen=True)
class Pane:
    """Curves over one axis along y.

    Parameters
    ----------
    label : str
        Label of the axis along y, without the unit where there are ``units`` to choose from.
    curves : sequence of Curve
        In the SI unit where there are ``units``, as spans and limits.
    units : tuple of (float, str)
        Factors and names of units that the axis may have: the first in which the curves can be
        read is taken. Empty: the curves are in the unit of the label.
    title : str
        Above the pane.
    spans : sequence of Span
    limits : (float, float), optional
        Limits of the axis along y.
    scale : {"linear", "log", "plain log"}
        Scale of that axis: a logarithmic one has numbers in powers of ten, or in full.
    ticks : sequence of float
        Along y; empty: as matplotlib chooses them.
    height : float
        Over that of other panes, where they stand above each other on a page.
    along : str
        Label of its axis along x, where panes differ in it.
    named : sequence of str
        What stands at 1, 2, 3 and so on along x; empty: numbers.
    rows : sequence of str
        What stands at 1, 2, 3 and so on along y, from the top; empty: numbers.
    notes : sequence of Note
        A page leaves them out.
    x_limits, x_ticks : sequence of float
        Limits and ticks of the axis along x, where the pane has its own; empty: as matplotlib
        chooses them.
    apart : {"", "number", "plane", "none"}
        What runs along x of a pane beside those of the picture, which a page leaves out: another
        number, a place in the plane, at one scale, or nothing.
    right : SecondAxis, optional
        A page has a pane for its curves.
    """

    label: str
    curves: Sequence[Curve]
    units: Units = ()
    title: str = ""
    spans: Sequence[Span] = ()
    limits: tuple[float, float] | None = None
    scale: Literal["linear", "log", "plain log"] = "linear"
    ticks: Sequence[float] = ()
    height: float = 1.0
    along: str = ""
    named: Sequence[str] = ()
    rows: Sequence[str] = ()
    notes: Sequence[Note] = ()
    x_limits: tuple[float, float] | None = None
    x_ticks: Sequence[float] | FloatArray = ()
    apart: Literal["", "number", "plane", "none"] = ""
    right: SecondAxis | None = None

    def times(self, factor: float, unit: str) -> Pane:
        """The pane with its curves in a unit, which stands beside them."""
        label = f"{self.label} ({unit})".replace("\n (", "\n(") if self.label else ""
        curves = [
            replace(
                one,
                y=factor * one.y,
                upto=None if one.upto is None else factor * one.upto,
            )
            for one in self.curves
        ]
        limits = None if self.limits is None else (factor * self.limits[0], factor * self.limits[1])
        spans = [
            one if one.upright else replace(one, low=factor * one.low, high=factor * one.high)
            for one in self.spans
        ]
        right = self.right
        if right is not None:
            values, ratio = np.concatenate([one.y for one in self.curves]), right.factor
            if right.curves:
                greatest = float(np.abs(values).max()) or 1.0
                values = np.concatenate([one.y for one in right.curves])
                ratio = (float(np.abs(values).max()) or 1.0) / greatest
                curves += [replace(one, y=factor / ratio * one.y) for one in right.curves]
                values = values / ratio
            size, name = fitting_unit(ratio * values, right.units)
            label_right = f"{right.label} ({name})"
            right = replace(right, label=label_right, factor=size * ratio / factor, units=())
        made: Look = {"label": label, "curves": curves, "spans": spans, "limits": limits}
        return replace(self, **made, units=(), right=right)


@dataclass(frozen=True)
class Picture:
    """Panes with one axis along x.

    Parameters
    ----------
    panes : sequence of Pane
    x_label : str
        Label of the axis along x, with its unit.
    of : Dataset
        Whose mechanism and terms the heading names.
    title : str
        Below them.
    y_label : str
        Label of all axes along y, with the unit or with units to choose from as a pane's label;
        empty where they differ.
    over : {"angle", "time", "speed", "number", "plane"}
        What runs along x: crank angle in degrees, time with the crank angle on a second axis, crank
        speed with another unit on it, any other number, or a place in the plane, at one scale.
    places : ndarray
        Along x that the axis shall hold, ascending; empty: what the curves take.
    layout : Layout, optional
        Layout of its panes in a new figure. Left out: over time and over the crank angle a stack,
        or two of many panes; else tiles in two columns.
    legend : mapping of str to dict, optional
        Looks by their labels. Left out: the names of curves and spans, once.
    colours : (ScalarMappable, str), optional
        Scale of colours beside the panes, and its label.
    fewer : str
        Choice that leaves one pane, for the message where the user's axes do not fit.
    """

    panes: Sequence[Pane]
    x_label: str
    of: xr.Dataset
    title: str = ""
    y_label: str = ""
    over: Literal["angle", "time", "speed", "number", "plane"] = "number"
    places: FloatArray = field(default_factory=lambda: np.zeros(0))
    layout: Layout | None = None
    legend: Mapping[str, Look] | None = None
    colours: tuple[ScalarMappable, str] | None = None
    fewer: str = ""

    def in_units(self) -> Picture:
        """The picture with all curves in the units in which they can be read."""
        if not self.y_label:
            return replace(self, panes=[_in_its_unit(pane) for pane in self.panes])
        if not self.panes[0].units:
            return self
        factor, unit = _unit_of(self.panes)
        panes = [pane.times(factor, unit) for pane in self.panes]
        return replace(self, panes=panes, y_label=f"{self.y_label} ({unit})")


def _in_its_unit(pane: Pane) -> Pane:
    return pane.times(*_unit_of([pane])) if pane.units else pane


def _unit_of(panes: Sequence[Pane]) -> tuple[float, str]:
    curves = [curve for pane in panes for curve in pane.curves]
    values = [np.ravel(y) for curve in curves for y in (curve.y, curve.upto) if y is not None]
    return fitting_unit(np.concatenate(values), panes[0].units)


def over_angles(
    angles: FloatArray,
    panes: Sequence[Pane],
    of: xr.Dataset,
    title: str = "",
    y_label: str = "",
    **options: Any,
) -> Picture:
    """A picture over the crank angle.

    Parameters
    ----------
    angles : ndarray
        In degrees, ascending.
    panes : sequence of Pane
    of : Dataset
    title, y_label : str
        As of :class:`Picture`, whose further fields are options.

    Returns
    -------
    Picture
    """
    return Picture(panes, "Crank angle (deg)", of, title, y_label, "angle", angles, **options)


def series(
    x: FloatArray,
    rows: Iterable[FloatArray],
    names: Iterable[str],
    look: Callable[[int, FloatArray], Look] = series_line,
) -> list[Curve]:
    """Rows of numbers as curves, each in the style of its number.

    Parameters
    ----------
    x : ndarray, shape (n,)
    rows : iterable of ndarray, shape (n,)
    names : iterable of str
        In the legend.
    look : callable
        Look by number and ``x``.

    Returns
    -------
    list of Curve
    """
    named = enumerate(zip(rows, names, strict=True))
    return [Curve(x, row, look(number, x), name) for number, (row, name) in named]


def phase_pane(label: str, curves: Sequence[Curve]) -> Pane:
    """A pane of phases in degrees, from half a turn below zero to half a turn above."""
    return Pane(label, curves, limits=(-190.0, 190.0), ticks=(-180.0, -90.0, 0.0, 90.0, 180.0))


def bars(
    places: FloatArray, rows: Sequence[FloatArray], looks: Sequence[Look], names: Sequence[str]
) -> list[Curve]:
    """Bars of several series beside each other, from zero, at places a unit apart.

    Parameters
    ----------
    places : ndarray, shape (n,)
    rows : sequence of ndarray, shape (n,)
        Rows of each series.
    looks : sequence of dict
        Looks of each series, as of a patch.
    names : sequence of str
        In the legend.

    Returns
    -------
    list of Curve
    """
    width, curves = BARS / len(rows), []
    for number, (row, look, name) in enumerate(zip(rows, looks, names, strict=True)):
        left = places - BARS / 2 + number * width
        x = np.stack([left, left + width, left + width], axis=-1).ravel()
        height = np.stack([row, row, np.full(len(row), np.nan)], axis=-1).ravel()
        hatched = look | {"lw": 0, "hatch": HATCHES[number % len(HATCHES)]}
        curves.append(Curve(x, 0.0 * height, hatched, name, upto=height))
    return curves


def by_engine(values: xr.DataArray, dataset: xr.Dataset) -> list[Curve]:
    """Values of every engine against time, named as in a legend.

    Parameters
    ----------
    values : DataArray
        With dims engine and time.
    dataset : Dataset
        It is of.

    Returns
    -------
    list of Curve
    """
    lines, time = values_of(values, "engine", "time"), values["time"].values
    # What lies under a line must be seen between its dashes and beside them.
    return [
        Curve(
            *(time, line, series_line(number), engine_label(dataset, number)),
            wave=1.4 if number < len(lines) - 1 else 1.0,
        )
        for number, line in enumerate(lines)
    ]


def beside(picture: Picture) -> Picture:
    """The picture with a pane of its own for curves on a second axis, behind all others."""
    rest = [pane if pane.right is None else replace(pane, right=None) for pane in picture.panes]
    further = [
        Pane(axis.label, list(map(_alone, axis.curves)), axis.units, spans=pane.spans)
        for pane in picture.panes
        if (axis := pane.right) and axis.curves
    ]
    return replace(picture, panes=[*rest, *further])


def _alone(curve: Curve) -> Curve:
    return replace(curve, name="", look=series_line(0))


def joined(pictures: Sequence[tuple[Choice, Picture]]) -> Picture:
    """Pictures of one kind as one, whose reader chooses among them.

    Parameters
    ----------
    pictures : sequence of (mapping, Picture)
        With what must be chosen for their curves to be shown.

    Returns
    -------
    Picture
        With every pane once, by its label and title, and limits that hold those of all; all else is
        of the first one, and places along x only where all have the same.
    """
    panes: dict[tuple[str, str], Pane] = {}
    for when, picture in pictures:
        for pane in beside(picture).panes:
            curves = [replace(one, when={**one.when, **when}) for one in pane.curves]
            spans = [replace(one, when={**one.when, **when}) for one in pane.spans]
            key = pane.label, pane.title
            limits, before = pane.limits, panes.get(key)
            if before is not None:
                curves, spans = [*before.curves, *curves], [*before.spans, *spans]
                if limits and before.limits:
                    (low, high), (least, most) = limits, before.limits
                    limits = min(low, least), max(high, most)
            panes[key] = replace(pane, curves=curves, spans=spans, limits=limits)
    first = pictures[0][1]
    same = all(np.array_equal(picture.places, first.places) for _, picture in pictures)
    places = first.places if same else np.zeros(0)
    return replace(first, panes=list(panes.values()), places=places)
