"""A picture as plain data: curves in panes over one axis, for matplotlib and for the report's page.

What is shown of a dataset is written down once, as a :class:`Picture`. ``flexmech.plots.drawing``
draws it by matplotlib, ``flexmech.report.plotted`` writes it for plotly; neither computes anything.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.plots.reading import Units, engine_label, fitting_unit, values_of
from flexmech.plots.style import LIGHT_GREY, Look, series_line

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
        Of a line against time that may vibrate faster than its pane can show, how much wider it is
        drawn than others; 0 of any other line.
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
        Of a line or a patch, as matplotlib names it.
    name : str
        In the legend; empty: it is not named.
    upright : bool
        Whether it stands at a place along x.
    """

    low: float
    high: float
    look: Look
    name: str = ""
    upright: bool = False


ZERO = Span(0.0, 0.0, {"color": LIGHT_GREY, "lw": 0.6, "zorder": 0})
"""Where a quantity is zero, behind all else."""


@dataclass(frozen=True)
class Pane:
    """Curves over one axis along y.

    Parameters
    ----------
    label : str
        Of the axis along y, without the unit where there are ``units`` to choose from.
    curves : tuple of Curve
        In the SI unit where there are ``units``.
    units : tuple of (float, str)
        Factors and names of units that the axis may have: the first in which the curves can be
        read is taken. Empty: the curves are in the unit of the label.
    title : str
        Above the pane.
    spans : tuple of Span
    limits : (float, float), optional
        Of the axis along y.
    scale : {"linear", "log", "plain log"}
        Of that axis: a logarithmic one has numbers in powers of ten, or in full.
    ticks : tuple of float
        Along y; empty: as matplotlib chooses them.
    height : float
        Over that of other panes, where they stand above each other on a page.
    """

    label: str
    curves: tuple[Curve, ...]
    units: Units = ()
    title: str = ""
    spans: tuple[Span, ...] = ()
    limits: tuple[float, float] | None = None
    scale: Literal["linear", "log", "plain log"] = "linear"
    ticks: tuple[float, ...] = ()
    height: float = 1.0

    def times(self, factor: float, unit: str) -> Pane:
        """The pane with its curves in a unit, which stands beside them."""
        label = f"{self.label} ({unit})".replace("\n (", "\n(") if self.label else ""
        curves = tuple(
            replace(
                one,
                y=factor * one.y,
                upto=None if one.upto is None else factor * one.upto,
            )
            for one in self.curves
        )
        return replace(self, label=label, curves=curves, units=())


@dataclass(frozen=True)
class Picture:
    """Panes with one axis along x.

    Parameters
    ----------
    panes : tuple of Pane
    x_label : str
        Of the axis along x, with its unit.
    over : {"angle", "time", "speed", "number"}
        What runs along x: crank angle in degrees, time with the crank angle on a second axis, crank
        speed with another unit on it, or any other number.
    places : ndarray
        Along x that the axis shall hold, ascending.
    of : Dataset
        Whose mechanism and terms the heading names.
    title : str
        Below them.
    y_label : str
        Of all axes along y, with the unit or with units to choose from as a pane's label; empty
        where they differ.
    """

    panes: tuple[Pane, ...]
    x_label: str
    over: Literal["angle", "time", "speed", "number"]
    places: FloatArray
    of: xr.Dataset
    title: str = ""
    y_label: str = ""

    def in_units(self) -> Picture:
        """The picture with all curves in the units in which they can be read."""
        if not self.y_label:
            return replace(self, panes=tuple(map(_in_its_unit, self.panes)))
        if not self.panes[0].units:
            return self
        factor, unit = _unit_of(self.panes)
        panes = tuple(pane.times(factor, unit) for pane in self.panes)
        return replace(self, panes=panes, y_label=f"{self.y_label} ({unit})")


def _in_its_unit(pane: Pane) -> Pane:
    return pane.times(*_unit_of([pane])) if pane.units else pane


def _unit_of(panes: Sequence[Pane]) -> tuple[float, str]:
    values = [np.ravel(curve.y) for pane in panes for curve in pane.curves]
    return fitting_unit(np.concatenate(values), panes[0].units)


def over_angles(
    angles: FloatArray, panes: Iterable[Pane], of: xr.Dataset, title: str = "", y_label: str = ""
) -> Picture:
    """A picture over the crank angle in degrees; see :class:`Picture`."""
    return Picture(tuple(panes), "Crank angle (deg)", "angle", angles, of, title, y_label)


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


def joined(pictures: Sequence[tuple[Choice, Picture]]) -> Picture:
    """Pictures of one kind as one, whose reader chooses among them.

    Parameters
    ----------
    pictures : sequence of (mapping, Picture)
        With what must be chosen for their curves to be shown.

    Returns
    -------
    Picture
        With every pane once, by its label and title; all else is of the first one.
    """
    panes: dict[tuple[str, str], Pane] = {}
    for when, picture in pictures:
        for pane in picture.panes:
            curves = tuple(replace(one, when={**one.when, **when}) for one in pane.curves)
            key = pane.label, pane.title
            before = panes[key].curves if key in panes else ()
            panes[key] = replace(pane, curves=before + curves)
    return replace(pictures[0][1], panes=tuple(panes.values()))
