"""What a panel of the report is: its drawings, plots, readings, tables and words.

Everything here is plain data. The page's script draws it, moves the cursors and shows readings;
nothing is computed in the browser but the place between two samples.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, wraps
from importlib import resources
from typing import Any, Literal

from flexmech.analyses import Summary, Table
from flexmech.arrays import FloatArray
from flexmech.report.results import Kind, Results
from flexmech.units import from_si

Choice = Mapping[str, str]
"""What the reader must have chosen for something to be shown: ``speed``, ``engine``, ``state`` or
``mode``, such as ``{"speed": "20 rad/s"}``; what is not named does not matter."""

Look = Literal["solid", "dash", "dot", "dashdot", "points"]
FRAME_HEIGHT = 110
"""Of a plot in pixels: what its heading, its legend and the axis along x take."""
GREY = "#8c8c8c"
"""Of what lies behind curves: limits, rays of orders, rigid links."""


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
    tick: float | None = None
    height: int = 320
    title: str = ""


def over_angle(name: str, axes: tuple[YAxis, ...], traces: Iterable[Trace], **of: Any) -> Plot:
    """A plot over the crank angle, whose cursor follows it.

    Further keywords are fields of the plot.

    Parameters
    ----------
    name : str
    axes : tuple of YAxis
    traces : iterable of Trace

    Returns
    -------
    Plot
    """
    along: dict[str, Any] = {"x_title": "Crank angle (deg)", "cursor": "angle", "tick": 60.0}
    return Plot(name, axes=axes, traces=tuple(traces), **(along | of))


def over_speed(
    name: str, unit: str, axes: tuple[YAxis, ...], traces: Iterable[Trace], text: str
) -> Plot:
    """A plot over the crank speed, whose cursor follows the speed chosen.

    Parameters
    ----------
    name : str
    unit : str
        Of the crank speed.
    axes : tuple of YAxis
    traces : iterable of Trace
    text : str
        What is to be seen.

    Returns
    -------
    Plot
    """
    scale, title = from_si(1.0, unit), f"Crank speed ({unit})"
    shown = tuple(traces)
    return Plot(name, title, axes, shown, text, "speed", speed_scale=scale, height=440)


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
    answer : tuple of str
        What the result says first, above everything else.
    equation : str
        What was solved, as text.
    source : str
        Where the equation stands.
    plots : tuple of Plot
    drawings : tuple of (str, str)
        Drawings that do not move: SVG, and what is to be seen in it.
    readings : tuple of Reading
    tables : tuple of Table
        What the answer rests on; the reader sorts them.
    folded : tuple of Table
        Further ones, which the reader unfolds.
    lines : tuple of str
        What else is to be said: errors, checks; the reader unfolds them with the equation.
    warnings : tuple of str
    thinned : tuple of str
        What was left out for the screen.
    """

    name: str
    title: str
    caption: str
    answer: tuple[str, ...] = ()
    equation: str = ""
    source: str = ""
    plots: tuple[Plot, ...] = ()
    drawings: tuple[tuple[str, str], ...] = ()
    readings: tuple[Reading, ...] = ()
    tables: tuple[Table, ...] = ()
    folded: tuple[Table, ...] = ()
    lines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    thinned: tuple[str, ...] = ()

    @property
    def details(self) -> str:
        """What is folded, in words; empty if nothing is."""
        folded = (
            (any(any(table.groups) for table in self.folded), "tables"),
            (self.equation, "equation"),
            (any(self.lines), "errors and checks"),
        )
        return ", ".join(words for part, words in folded if part).capitalize()


PanelMaker = Callable[[Results], Panel | None]


def shows(kind: type[Kind]) -> Callable[[Callable[[Kind, Results], Panel | None]], PanelMaker]:
    """Make a panel's function of the first result of a kind one of all results.

    Parameters
    ----------
    kind : type
        Of the result that the panel shows.

    Returns
    -------
    callable
        Decorator; without such a result there is no panel.
    """

    def of_results(make: Callable[[Kind, Results], Panel | None]) -> PanelMaker:
        @wraps(make)
        def panel(results: Results) -> Panel | None:
            result = results.first(kind)
            return None if result is None else make(result, results)

        return panel

    return of_results


def panel_of(name: str, said: Summary | None = None, variant: str = "", /, **parts: Any) -> Panel:
    """A panel with the words that ``panels.toml`` has for it.

    Keywords are fields of the panel; others fill in the caption.

    Parameters
    ----------
    name : str
        Of the panel, and of its table in the file.
    said : Summary, optional
        Of the result: its answer, table and warnings are the panel's, and all else is folded.
    variant : str
        Which of several tables of words, where the panel has several.

    Returns
    -------
    Panel
    """
    words = _words()[name]
    words = words[variant] if variant else words
    texts = {key: parts.pop(key) for key in set(parts) - set(Panel.__dataclass_fields__)}
    words = words | {"caption": words["caption"].format(**texts)}
    if said is not None:
        own: dict[str, Any] = {
            "answer": said.answer,
            "tables": () if said.table is None else (said.table,),
            "folded": tuple(part for part in said.details if not isinstance(part, str)),
            "lines": further_lines(said),
            "warnings": said.warnings,
        }
        parts = own | parts
    return Panel(name, **(words | parts))


def further_lines(said: Summary) -> tuple[str, ...]:
    """What a result says after its answer: how far it is known, and all else.

    Parameters
    ----------
    said : Summary

    Returns
    -------
    tuple of str
    """
    return tuple(line for line in said.lines if line not in said.answer)


@cache
def _words() -> dict[str, Any]:
    text = resources.files("flexmech.report.panels").joinpath("panels.toml").read_text("utf-8")
    return tomllib.loads(text)
