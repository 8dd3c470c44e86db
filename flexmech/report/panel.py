"""What a panel of the report is: its drawings, plots, readings, tables and words.

Everything here is plain data. The page's script draws it, moves the cursors and shows readings;
nothing is computed in the browser but the place between two samples.

Plots are pictures of ``flexmech.plots``, drawn by plotly, with a cursor.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache, wraps
from importlib import resources
from typing import Any, Literal

import numpy as np
from matplotlib.colors import to_hex, to_rgb, to_rgba

from flexmech.analyses import Summary, Table
from flexmech.arrays import FloatArray
from flexmech.plots.picture import ZERO, Choice, Curve, Pane, Picture, Span
from flexmech.plots.reading import speed_unit
from flexmech.plots.style import Look
from flexmech.report.results import Kind, Results
from flexmech.units import from_si

FRAME_HEIGHT, PANE_HEIGHT, LEAST_HEIGHT = 110, 130, 320
"""Of a plot in pixels: what its heading, its legend and the axis along x take, what an axis along y
takes, and its height at least."""
# Darker greys are drawn as the page writes, in light and in dark.
INK, DARK = "critical", 0.4
# Colour of grey stripes behind curves, on a light and on a dark page.
STRIPE = "rgba(128,128,128,0.2)"
# Letters beside an axis of one line; the unit of a longer label stands on a second one. Part of the
# axis along x that marks at its ends take.
LONGEST, MARK_ROOM = 18, 0.015
# Pixels of a page in a point.
PIXELS = 4 / 3
SYMBOLS = {"o": "circle", "s": "square", "^": "triangle-up", "D": "diamond", "v": "triangle-down"}
SYMBOLS |= {"P": "cross", "x": "x", "X": "x", ".": "circle", "+": "cross-thin-open"}
CURSORS: dict[str, Literal["angle", "speed", "point", "none"]] = {
    "angle": "angle",
    "speed": "speed",
    "time": "none",
    "number": "none",
    "plane": "point",
}
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot"}


@dataclass(frozen=True)
class Trace:
    """A line or points of a plot.

    Parameters
    ----------
    name : str
        For legend and hover; traces of one name share one entry of the legend.
    x, y : ndarray, shape (n,)
    colour : str
        Any that a browser knows, or ``"critical"``, which is that of letters.
    look : str
        Dashes of a line as plotly has them, or ``"points"``.
    width : float
        Width of the line, or of points, in pixels.
    symbol : str
        Symbol of points, or of those on a line; empty: the line has none.
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
    look: str = "solid"
    width: float = 1.6
    symbol: str = ""
    when: Choice = field(default_factory=dict)
    followed: Choice | None = None
    axis: int = 0
    angle: FloatArray | None = None
    fill: Literal["none", "to previous", "itself"] = "none"
    legend: bool = True
    label: str = ""


@dataclass(frozen=True)
class YAxis:
    """A vertical axis; several of them stand above each other over one horizontal axis.

    Parameters
    ----------
    title : str
    logarithmic : bool
    ends : tuple of float
        Ends of a linear axis; empty: those of the traces.
    height : float
        Over that of other axes.
    """

    title: str
    logarithmic: bool = False
    ends: tuple[float, ...] = ()
    height: float = 1.0


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
    ends : tuple of float
        Ends of the horizontal axis; empty: those of the traces.
    named : tuple of str
        What stands at 1, 2, 3 and so on along it; empty: numbers.
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
    height: int = LEAST_HEIGHT
    title: str = ""
    ends: tuple[float, ...] = ()
    named: tuple[str, ...] = ()


def plotted(name: str, picture: Picture, title: str = "") -> Plot:
    """A picture as a plot of the page, with its panes above each other.

    Parameters
    ----------
    name : str
        Letters, digits and hyphens; unique in the report.
    picture : Picture
    title : str
        Left out: what all axes along y have in common.

    Returns
    -------
    Plot
    """
    panes = [pane for pane in picture.panes if not pane.apart]
    shown = replace(picture, panes=panes).in_units()
    alone = (LEAST_HEIGHT - FRAME_HEIGHT) / PANE_HEIGHT if len(shown.panes) == 1 else 1.0
    axes = tuple(
        YAxis(
            _beside(pane.label or pane.title.partition(",")[0], max(pane.height, alone)),
            pane.scale != "linear",
            pane.limits if pane.limits and pane.scale == "linear" else (),
            pane.height,
        )
        for pane in shown.panes
    )
    traces = tuple(_traces(shown))
    ends = shown.places[[0, -1]] if len(shown.places) > 1 else np.zeros(0)
    if ends.size and any(one.symbol for one in traces):
        ends = ends + MARK_ROOM * np.ptp(ends) * np.array([-1.0, 1.0])
    along = shown.x_label
    seen = ", ".join(axis.title for axis in axes).replace("<br>", " ")
    seen = f"{shown.y_label}: {seen}" if shown.y_label else seen
    return Plot(
        name,
        along,
        axes,
        traces,
        f"{seen} against {along[:1].lower()}{along[1:]}",
        CURSORS[shown.over],
        from_si(1.0, speed_unit(shown.of)) if shown.over == "speed" else 1.0,
        equal=shown.over == "plane",
        tick=60.0 if shown.over == "angle" else None,
        height=max(LEAST_HEIGHT, round(FRAME_HEIGHT + PANE_HEIGHT * sum(a.height for a in axes))),
        title=title or shown.y_label,
        ends=tuple(ends.tolist()),
        named=tuple(map(_markup, shown.panes[0].named)),
    )


def _beside(label: str, height: float) -> str:
    """A label beside an axis, in two lines if it is longer than the axis."""
    words, opening, unit = label.rpartition(" (")
    long = opening and len(label) > LONGEST * height and "\n" not in label
    return _markup(f"{words}\n({unit}" if long else label)


def _markup(label: str) -> str:
    """A label in the markup of plotly, with the dollar signs that names have."""
    return label.replace("\n", "<br>").replace(r"\$", "$")


def _traces(picture: Picture) -> Iterator[Trace]:
    """Traces of all panes, those further back first; the legend names each of a name once."""
    named = set[tuple[str, ...]]()
    for axis, pane in enumerate(picture.panes):
        for span in pane.spans:
            if span.look is not ZERO.look:
                key = (span.name, *span.when.values())
                yield from _of_span(span, pane, axis, legend=bool(span.name) and key not in named)
                named.add(key)
        for curve in sorted(pane.curves, key=lambda one: float(one.look.get("zorder", 2.0))):
            key = (curve.name, *curve.when.values())
            yield from _of_curve(curve, axis, legend=bool(curve.name) and key not in named)
            named.add(key)


def _of_curve(curve: Curve, axis: int, *, legend: bool) -> Iterator[Trace]:
    """A line or points, or both edges of a band."""
    common: dict[str, Any] = {"when": curve.when, "axis": axis, "angle": curve.angle}
    name, colour = _markup(curve.name), _colour(curve.look)
    if curve.upto is not None:
        yield Trace(name, curve.x, curve.y, colour, width=0.0, legend=False, **common)
        yield Trace(
            name,
            curve.x,
            curve.upto,
            colour,
            width=0.0,
            fill="to previous",
            legend=legend,
            **common,
        )
        return
    look = _dashes(curve.look)
    # Where some points of a line are marked, the page marks none.
    marker = "" if "markevery" in curve.look else curve.look.get("marker", "")
    symbol = SYMBOLS.get(str(marker), "")
    size = float(curve.look["ms" if "ms" in curve.look else "markersize"]) if symbol else 4.0
    if curve.look.get("drawstyle") == "steps-post":
        curve = replace(curve, x=np.repeat(curve.x, 2)[1:], y=np.repeat(curve.y, 2)[:-1])
    width = PIXELS * (size if look == "points" else _line_width(curve.look))
    # Grey is what stands behind, but black may be all that there is.
    behind = _is_grey(curve.look) and curve.look["color"] != "black"
    followed = None if look == "points" or behind else curve.followed
    yield Trace(
        *(name, curve.x, curve.y, colour, look, width, symbol),
        followed=followed,
        legend=legend,
        label=_markup(curve.label),
        **common,
    )


def _of_span(span: Span, pane: Pane, axis: int, *, legend: bool) -> Iterator[Trace]:
    """A line, or a rectangle, across what the curves of a pane take; none without curves."""
    across = np.concatenate([np.ravel(one.y if span.upright else one.x) for one in pane.curves])
    if not np.isfinite(across).any():
        return
    ends = np.array([np.nanmin(across), np.nanmax(across)])
    if span.upright and pane.limits:
        ends = np.array(pane.limits)
    ends[1] = ends[0] + span.look.get("ymax", 1.0) * (ends[1] - ends[0])
    common: dict[str, Any] = {"axis": axis, "legend": legend, "when": span.when}
    if span.is_filled:
        corners = np.append(ends, ends[::-1]), np.repeat([span.low, span.high], 2)
        colour = _stripe(span.look)
        x, y = corners[::-1] if span.upright else corners
        yield Trace(_markup(span.name), x, y, colour, width=1.0, fill="itself", **common)
        return
    line = ends, np.full(2, span.low)
    x, y = line[::-1] if span.upright else line
    look, width = _dashes(span.look), PIXELS * _line_width(span.look)
    yield Trace(_markup(span.name), x, y, _colour(span.look), look, width, **common)


def _stripe(look: Look) -> str:
    """Colour of a stripe behind curves, which a dark page shows through as a light one does."""
    face = look["facecolor" if "facecolor" in look else "color"]
    if _is_grey({"color": face}):
        return STRIPE
    if to_rgba(face)[3] < 1.0 or "edgecolor" not in look:
        return _colour({"color": face} | look)
    return _colour({"color": look["edgecolor"], "alpha": 0.3})


def _line_width(look: Look) -> float:
    named = [float(look[name]) for name in ("lw", "linewidth") if name in look]
    return named[0] if named else 1.2


def _dashes(look: Look) -> str:
    """Dashes of a line in pixels, or that it is of points alone."""
    style = look.get("ls", look.get("linestyle", "-"))
    if not isinstance(style, tuple):
        return "points" if str(style).lower() in ("", "none") else DASHES[str(style)]
    return ",".join(f"{PIXELS * _line_width(look) * part:.3g}px" for part in style[1])


def _is_grey(look: Look) -> bool:
    return bool(np.ptp(to_rgb(look["color"])) == 0.0)


def _colour(look: Look) -> str:
    """A colour of matplotlib as a browser has it."""
    red, green, blue, opacity = to_rgba(look["color"], look.get("alpha"))
    if opacity < 1.0:
        parts = ",".join(f"{round(255 * part)}" for part in (red, green, blue))
        return f"rgba({parts},{opacity:.3g})"
    return INK if _is_grey(look) and red <= DARK else to_hex((red, green, blue))


@dataclass(frozen=True)
class Reading:
    """A number beside the linkage that follows the crank angle.

    Parameters
    ----------
    group, label, unit : str
    angle, value : ndarray, shape (n,)
        Crank angle in degrees and the number there.
    error : float
        Error of the number, in its unit; not a number where it is not known.
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
        Kind of the result that the panel shows.

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
        Name of the panel, and of its table in the file.
    said : Summary, optional
        Summary of the result: its answer, table and warnings are the panel's, and all else is
        folded.
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
