"""What a panel of the report is: its drawings, plots, readings, tables and words.

Everything here is plain data. The page's script draws it, moves the cursors and shows readings;
nothing is computed in the browser but the place between two samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from flexmech.analyses import Table
from flexmech.types import FloatArray

Choice = Mapping[str, str]
"""What the reader must have chosen for something to be shown: ``speed``, ``engine``, ``state`` or
``mode``, such as ``{"speed": "20 rad/s"}``; what is not named does not matter."""

Look = Literal["solid", "dash", "dot", "dashdot", "points"]


@dataclass(frozen=True)
class Trace:
    """A line or points of a plot.

    Parameters
    ----------
    name : str
        For legend and hover; traces of one name share one entry of the legend.
    x, y : ndarray, shape (n,)
    colour : int or str
        Number of a series, or any colour that a browser knows.
    look : {"solid", "dash", "dot", "dashdot", "points"}
    width : float
        Of the line in pixels.
    when : mapping
        What the reader must have chosen for it to be shown.
    followed : mapping or None
        What he must have chosen besides for the cursor's dot to be on it; None: never.
    axis : int
        Which of the plot's axes it belongs to, from 0.
    angle : ndarray, shape (n,), optional
        Crank angle in degrees of each point, where ``x`` is something else.
    fill : {"none", "to previous", "itself"}
    legend : bool
        Whether the legend names it.
    label : str
        Text at its last point.
    """

    name: str
    x: FloatArray
    y: FloatArray
    colour: int | str = 0
    look: Look = "solid"
    width: float = 1.6
    when: Choice = field(default_factory=dict)
    followed: Choice | None = None
    axis: int = 0
    angle: FloatArray | None = None
    fill: Literal["none", "to previous", "itself"] = "none"
    legend: bool = True
    label: str = ""


@dataclass(frozen=True)
class YAxis:
    """A vertical axis; several of them stand above each other over one horizontal axis."""

    title: str
    logarithmic: bool = False


@dataclass(frozen=True)
class Plot:
    """A plot that can be zoomed, with a cursor that the script moves.

    Parameters
    ----------
    name : str
        Letters, digits and hyphens; unique in the report.
    x_title : str
    axes : tuple of YAxis
        From the top.
    traces : tuple of Trace
    text : str
        What is to be seen, for those who do not see it.
    cursor : {"angle", "speed", "point", "none"}
        A vertical line at the crank angle in degrees or at the crank speed, with dots on the
        lines; dots alone, at the place of the crank angle; or nothing.
    speed_scale : float
        Units of the horizontal axis in a rad/s, for a cursor of speed.
    equal : bool
        Whether both axes have one scale.
    x_range : tuple of float, optional
    tick : float, optional
        Distance of the ticks along x.
    height : int
        In pixels.
    title : str
        Above the plot, where a panel has several.
    """

    name: str
    x_title: str
    axes: tuple[YAxis, ...]
    traces: tuple[Trace, ...]
    text: str
    cursor: Literal["angle", "speed", "point", "none"] = "none"
    speed_scale: float = 1.0
    equal: bool = False
    x_range: tuple[float, float] | None = None
    tick: float | None = None
    height: int = 320
    title: str = ""


@dataclass(frozen=True)
class Reading:
    """A number beside the linkage that follows the crank angle.

    Parameters
    ----------
    group, label, unit : str
    angle, value : ndarray, shape (n,)
        Crank angle in degrees and the number there.
    error : float
        Of the number, in its unit; not a number where it is not known.
    when : mapping
    decimals : int
    mode : str
        Number of the mode that it is of, if it is of one; the chosen mode is marked.
    """

    group: str
    label: str
    unit: str
    angle: FloatArray
    value: FloatArray
    error: float
    when: Choice
    decimals: int
    mode: str = ""


@dataclass(frozen=True)
class Panel:
    """A part of the report about one question.

    Parameters
    ----------
    name : str
        Letters, digits and hyphens; unique in the report, and its anchor.
    title : str
    caption : str
        What is shown, in a sentence or two.
    equation : str
        What was solved, as text.
    source : str
        Where the equation stands.
    plots : tuple of Plot
    drawings : tuple of (str, str)
        Drawings that do not move: SVG, and what is to be seen in it.
    readings : tuple of Reading
    tables : tuple of Table
        With their errors; the reader sorts them.
    lines : tuple of str
        What else is to be said: errors, checks.
    warnings : tuple of str
    thinned : tuple of str
        What was left out for the screen.
    """

    name: str
    title: str
    caption: str
    equation: str = ""
    source: str = ""
    plots: tuple[Plot, ...] = ()
    drawings: tuple[tuple[str, str], ...] = ()
    readings: tuple[Reading, ...] = ()
    tables: tuple[Table, ...] = ()
    lines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    thinned: tuple[str, ...] = ()
