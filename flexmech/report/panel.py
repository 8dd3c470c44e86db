"""What a panel of the report is: its drawings, plots, readings, tables and words.

Everything here is plain data. The page's script draws it, moves the cursors and shows readings;
nothing is computed in the browser but the place between two samples.

Plots are pictures of ``flexmech.plots``, drawn by plotly, with a cursor.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, wraps
from importlib import resources
from typing import Any, Literal

import numpy as np
from matplotlib.colors import to_hex, to_rgb, to_rgba

from flexmech.analyses import Result, Summary, Table
from flexmech.arrays import FloatArray
from flexmech.plots.picture import ZERO, Choice, Curve, Pane, Picture, Span, beside
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
TRACE = {
    "look": "solid",
    "symbol": "",
    "followed": None,
    "angle": None,
    "fill": "none",
    "label": "",
}
"""A trace but for its numbers: ``look`` is dashes as plotly has them or ``points``, ``symbol`` the
mark of points, ``followed`` what must be chosen besides for the cursor's dot to be on it."""


Plot = dict[str, Any]
"""A picture as the page's script has it, which draws it by plotly with a cursor: names, numbers,
texts and arrays."""


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
    dict
        ``name``, ``title``, ``height`` in pixels, ``text`` for those who do not see it, ``axes``
        along y from the top, ``traces``, and of the axis along x ``xTitle``, ``ends``, ``tick``,
        ``named`` and ``equal``, whether both axes have one scale. ``cursor`` is a line at the crank
        ``angle`` or ``speed``, a ``point`` at the crank angle, or ``none``; ``speedScale`` is in
        units of the axis in a rad/s.
    """
    panes = [pane for pane in beside(picture).panes if not pane.apart]
    shown = replace(picture, panes=panes).in_units()
    alone = (LEAST_HEIGHT - FRAME_HEIGHT) / PANE_HEIGHT if len(panes) == 1 else 1.0
    labels = [
        _beside(pane.label or pane.title.partition(":")[0], max(pane.height, alone))
        for pane in shown.panes
    ]
    traces = list(_traces(shown))
    ends = shown.places[[0, -1]] if len(shown.places) > 1 else np.zeros(0)
    if ends.size and any(trace["symbol"] for trace in traces):
        ends = ends + MARK_ROOM * np.ptp(ends) * np.array([-1.0, 1.0])
    along, seen = shown.x_label, ", ".join(labels).replace("<br>", " ")
    seen = f"{shown.y_label}: {seen}" if shown.y_label else seen
    height = FRAME_HEIGHT + PANE_HEIGHT * sum(pane.height for pane in panes)
    return {
        "name": name,
        "title": title or shown.y_label,
        "text": f"{seen} against {along[:1].lower()}{along[1:]}",
        "height": max(LEAST_HEIGHT, round(height)),
        "xTitle": along,
        "axes": [_axis(*pair) for pair in zip(labels, shown.panes, strict=True)],
        "traces": traces,
        "cursor": CURSORS[shown.over],
        "speedScale": from_si(1.0, speed_unit(shown.of)) if shown.over == "speed" else 1.0,
        "equal": shown.over == "plane",
        "tick": 60.0 if shown.over == "angle" else None,
        "ends": ends.tolist(),
        "named": list(map(_markup, shown.panes[0].named)),
    }


def _axis(title: str, pane: Pane) -> dict[str, Any]:
    """An axis along y, with its ends where it is linear; without them they are the traces'."""
    linear = pane.scale == "linear"
    ends = list(pane.limits or ()) if linear else []
    axis = {"title": title, "logarithmic": not linear, "ends": ends, "height": pane.height}
    return axis | {"rows": list(map(_markup, pane.rows))}


def _beside(label: str, height: float) -> str:
    """A label beside an axis, in two lines if it is longer than the axis."""
    words, opening, unit = label.rpartition(" (")
    long = opening and len(label) > LONGEST * height and "\n" not in label
    return _markup(f"{words}\n({unit}" if long else label)


def _markup(label: str) -> str:
    """A label in the markup of plotly, with the dollar signs that names have."""
    return label.replace("\n", "<br>").replace(r"\$", "$")


def _traces(picture: Picture) -> Iterator[dict[str, Any]]:
    """Traces of all panes, those further back first; the legend names each of a name once."""
    named = set[tuple[str, ...]]()
    for axis, pane in enumerate(picture.panes):
        drawn: list[Curve | Span] = [one for one in pane.spans if one.look is not ZERO.look]
        drawn += sorted(pane.curves, key=lambda one: float(one.look.get("zorder", 2.0)))
        for one in drawn:
            key = (one.name, *one.when.values())
            legend = bool(one.name) and key not in named
            made = _of_span(one, pane) if isinstance(one, Span) else _of_curve(one)
            common = {"name": _markup(one.name), "when": dict(one.when), "axis": axis}
            for trace in made:
                yield TRACE | common | {"legend": legend} | trace
            named.add(key)


def _of_curve(curve: Curve) -> Iterator[dict[str, Any]]:
    """A line or points, or both edges of a band."""
    common = {"x": curve.x, "angle": curve.angle, "colour": _colour(curve.look)}
    if curve.upto is not None:
        yield common | {"y": curve.y, "width": 0.0, "legend": False}
        yield common | {"y": curve.upto, "width": 0.0, "fill": "to previous"}
        return
    look = _dashes(curve.look)
    # Where some points of a line are marked, the page marks none.
    marker = "" if "markevery" in curve.look else curve.look.get("marker", "")
    symbol = SYMBOLS.get(str(marker), "")
    size = float(curve.look["ms" if "ms" in curve.look else "markersize"]) if symbol else 4.0
    width = PIXELS * (size if look == "points" else _line_width(curve.look))
    # Grey is what stands behind, but black may be all that there is.
    behind = _is_grey(curve.look) and curve.look["color"] != "black"
    followed = None if look == "points" or behind else curve.followed
    drawn = {"look": look, "width": width, "symbol": symbol}
    yield common | drawn | {"y": curve.y, "followed": followed, "label": _markup(curve.label)}


def _of_span(span: Span, pane: Pane) -> Iterator[dict[str, Any]]:
    """A line, or a rectangle, across what the curves of a pane take; none without curves."""
    across = np.concatenate([np.ravel(one.y if span.upright else one.x) for one in pane.curves])
    if not np.isfinite(across).any():
        return
    ends = np.array([np.nanmin(across), np.nanmax(across)])
    if span.upright and pane.limits:
        ends = np.array(pane.limits)
    ends[1] = ends[0] + span.look.get("ymax", 1.0) * (ends[1] - ends[0])
    places = ends, np.full(2, span.low)
    if span.is_filled:
        places = np.append(ends, ends[::-1]), np.repeat([span.low, span.high], 2)
        look = {"colour": _stripe(span.look), "width": 1.0, "fill": "itself"}
    else:
        width = PIXELS * _line_width(span.look)
        look = {"colour": _colour(span.look), "width": width, "look": _dashes(span.look)}
    x, y = places[::-1] if span.upright else places
    yield {"x": x, "y": y} | look


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
    plots : tuple of dict
        As :func:`plotted` makes them.
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


def panel_of(
    name: str,
    said: Summary | Iterable[tuple[str, Summary]] = (),
    variant: str = "",
    /,
    **parts: Any,
) -> Panel:
    """A panel with the words that ``panels.toml`` has for it.

    Keywords are fields of the panel; others fill in the caption.

    Parameters
    ----------
    name : str
        Name of the panel, and of its table in the file.
    said : Summary or iterable of (str, Summary)
        Summary of the result, or of several, each with words that its lines begin with: answers,
        tables and warnings are the panel's, and all else is folded.
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
    pairs = [("", said)] if isinstance(said, Summary) else list(said)
    warnings = [f"{at}{line}" for at, one in pairs for line in one.warnings]
    details = [part for _, one in pairs for part in one.details]
    found: dict[str, tuple[Any, ...]] = {
        "answer": tuple(f"{at}{line}" for at, one in pairs for line in one.answer),
        "tables": tuple(one.table for _, one in pairs if one.table is not None),
        "folded": tuple(part for part in details if not isinstance(part, str)),
        "lines": tuple(f"{at}{line}" for at, one in pairs for line in further_lines(one)),
        "warnings": tuple(dict.fromkeys(warnings)),
    }
    return Panel(name, **(words | found | parts))


def further_lines(said: Summary) -> tuple[str, ...]:
    """What a result says after its answer: how far it is known, and all else."""
    return tuple(line for line in said.lines if line not in said.answer)


def told_apart(results: Sequence[Result], names: Iterable[str]) -> list[tuple[str, Summary]]:
    """Summaries of results, lines of which begin with their names, but of one alone.

    Parameters
    ----------
    results : sequence of Result
    names : iterable of str
        What tells each from the others.

    Returns
    -------
    list of (str, Summary)
        For :func:`panel_of`.
    """
    begun = [f"{name}: " if len(results) > 1 else "" for name in names]
    return [(name, one.said) for name, one in zip(begun, results, strict=True)]


@cache
def _words() -> dict[str, Any]:
    text = resources.files("flexmech.report.panels").joinpath("panels.toml").read_text("utf-8")
    return tomllib.loads(text)
