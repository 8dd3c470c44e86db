"""Outputs over what varies: lines, contours or points, with their limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.plots.designs.reading import (
    BOUND,
    LARGE_PANEL,
    PANEL,
    bounds,
    computed,
    label,
    outputs_of,
    shown,
    varying,
)
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, sheet, tiles
from flexmech.plots.picture import Curve, Pane, Picture, Span
from flexmech.plots.style import (
    LIGHT_GREY,
    MID_GREY,
    SERIES_STYLES,
    Look,
    line_handle,
    line_handles,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Panels of a picture at most: the first outputs over the first variables.
MOST_PANELS = 12
# Letters of a text that stands at its place along an axis; longer ones are numbered.
MOST_LETTERS = 12
# Contours in a panel.
CONTOURS = 7
WITHIN: Look = {"ls": "", "marker": "o", "ms": 3.0, "mew": 0.0, "color": series_style(0).color}
BEYOND: Look = {"ls": "", "marker": "x", "ms": 3.0, "mew": 0.7, "color": series_style(1).color}


def plot_designs(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the outputs over what varies, with their limits.

    Every combination of one quantity's values is a line, with a list of texts one for each of
    them; every combination of two quantities is drawn as contours over both. Samples, and
    combinations of more, are points over each variable.

    Parameters
    ----------
    dataset : Dataset
        Of a ``DesignSweep``.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If no design can be computed.
    """
    known, variables = computed(dataset), varying(dataset)
    texts = _texts(dataset)
    numbers = [name for name in variables if name not in texts]
    if _every_combination(dataset, variables):
        if len(numbers) == 2 and not texts:
            return _contours(dataset, numbers, ax)
        if len(numbers) == 1 and len(_lines(dataset, texts)) <= len(SERIES_STYLES):
            return _curves(dataset, numbers[0], texts, ax)
    return _scatter(known, variables, ax)


def _every_combination(dataset: xr.Dataset, variables: list[str]) -> bool:
    """Whether the designs are all combinations of the values of the variables, each once."""
    places = [np.unique(dataset[name].values, return_inverse=True) for name in variables]
    count = int(np.prod([values.size for values, _ in places], dtype=float))
    rows = np.stack([place for _, place in places], axis=-1)
    return count > 1 and count == len(rows) == len(np.unique(rows, axis=0))


def _texts(dataset: xr.Dataset) -> list[str]:
    """Variables whose values are texts."""
    return [name for name in varying(dataset) if dataset[name].dtype.kind == "U"]


def _lines(dataset: xr.Dataset, texts: list[str]) -> list[tuple[str, ...]]:
    """Combinations of texts in the order of the designs."""
    rows = zip(*(dataset[name].values.tolist() for name in texts), strict=True)
    return list(dict.fromkeys(rows)) or [()]


def _curves(dataset: xr.Dataset, variable: str, texts: list[str], ax: AxesLike | None) -> Figure:
    """Lines of every output over the only number that varies."""
    lines, x = _lines(dataset, texts), shown(dataset[variable])
    points = np.unique(x)
    panes = []
    for output in outputs_of(dataset):
        curves = []
        for number, line in enumerate(lines):
            own = [dataset[name].values == text for name, text in zip(texts, line, strict=True)]
            which = np.flatnonzero(np.logical_and.reduce(own)) if own else np.arange(x.size)
            which = which[np.argsort(x[which], kind="stable")]
            y, look = shown(dataset[output])[which], series_line(number, points)
            curves.append(Curve(x[which], y, look, ", ".join(line)))
        panes.append(_pane(dataset, output, variable, curves))
    title = f"Outputs over {label(dataset[variable])}"
    picture = Picture(panes, "", dataset, title)
    return draw(picture, tiles(len(panes), 2, PANEL), ax=ax)


def _contours(dataset: xr.Dataset, variables: list[str], ax: AxesLike | None) -> Figure:
    """Contours of every output over two numbers, what is beyond a limit in grey."""
    outputs = outputs_of(dataset)
    first, second = (dataset[name] for name in variables)
    x, y = (np.unique(shown(values)) for values in (first, second))
    order = np.lexsort([first.values, second.values])
    known = computed(dataset)
    within = known["within"].values
    fields = {
        name: np.ma.masked_invalid(shown(dataset[name])[order].reshape(y.size, x.size))
        for name in outputs
    }
    limits = [
        (name, end, from_si(dataset[name].attrs[end], dataset[name].attrs["shown_unit"]))
        for name in outputs
        for end in ("least", "greatest")
        if end in dataset[name].attrs
    ]
    with sheet(tiles(len(outputs), 2, LARGE_PANEL), ax=ax) as drawn:
        handles = [line_handle("design", **WITHIN)]
        if limits:
            handles = _marks()
        drawn.header(handles, "Outputs over what varies", of=dataset)
        for axes, output in zip(drawn.panels, outputs, strict=True):
            # Limits of all outputs: the best of one lies on the limit of another.
            for name, end, bound in limits:
                _beyond(axes, (x, y), fields[name], bound, least=end == "least")
            if np.ma.ptp(fields[output]) > 0:
                drawn_lines = axes.contour(
                    x, y, fields[output], CONTOURS, colors=MID_GREY, linewidths=0.8
                )
                axes.clabel(drawn_lines, fontsize="small")
            for which, look in ((~within, BEYOND), (within, WITHIN)):
                axes.plot(*(shown(known[name])[which] for name in variables), **look)
            # Designs at the ends of a range are drawn whole.
            axes.use_sticky_edges = False
            axes.margins(0.04)
            axes.set_title(label(dataset[output]), loc="left")
            axes.set_xlabel(label(first))
            axes.set_ylabel(label(second))
    return drawn.figure


def _beyond(
    axes: Axes,
    along: tuple[FloatArray, FloatArray],
    field: FloatArray,
    bound: float,
    *,
    least: bool,
) -> None:
    """A limit as a line, and in grey where a field is beyond it."""
    low, high = float(field.min()), float(field.max())
    ends = (low, min(bound, high)) if least else (max(bound, low), high)
    if ends[0] < ends[1]:
        axes.contourf(*along, field, ends, colors=LIGHT_GREY)
    if low < bound < high:
        look = {"colors": BOUND["color"], "linewidths": BOUND["lw"], "linestyles": BOUND["ls"]}
        axes.contour(*along, field, [bound], **look)


def _scatter(known: xr.Dataset, variables: list[str], ax: AxesLike | None) -> Figure:
    """Every output over every variable, designs that keep all limits apart from the others."""
    every = [(output, variable) for output in outputs_of(known) for variable in variables]
    pairs, heading = every[:MOST_PANELS], "Outputs of the designs over what varies"
    if len(every) > MOST_PANELS:
        heading += f": the first {MOST_PANELS} of {len(every)} pairs"
    heading += "".join(f"\n{key}" for name in variables if (key := key_of(known[name])))
    panes = [design_pane(known, *pair) for pair in pairs]
    picture = Picture(panes, "", known, heading)
    return draw(picture, tiles(len(panes), min(len(variables), 3), PANEL), ax=ax)


def design_pane(known: xr.Dataset, output: str, variable: str) -> Pane:
    """Designs as points of an output over a variable, those beyond a limit apart, and limits.

    Parameters
    ----------
    known : Dataset
        Designs that can be computed.
    output, variable : str

    Returns
    -------
    Pane
        Texts stand along x by their numbers.
    """
    bounded = any(bounds(known[name]) for name in outputs_of(known))
    within, names = known["within"].values | (not bounded), _names(known[variable])
    x, y = shown(known[variable]), shown(known[output])
    if names:
        x = np.array([names.index(value) + 1.0 for value in x.tolist()])
    curves = [
        Curve(x[which], y[which], look, word)
        for which, look, word in (
            (~within, BEYOND, "beyond a limit"),
            (within, WITHIN, "keeps every limit" if bounded else ""),
        )
        if which.any()
    ]
    short = max(map(len, names), default=0) <= MOST_LETTERS
    ticks = tuple(name if short else str(n) for n, name in enumerate(names, 1))
    return replace(_pane(known, output, variable, curves), named=ticks)


def _pane(dataset: xr.Dataset, output: str, variable: str, curves: list[Curve]) -> Pane:
    """A pane of an output over a variable with its limits."""
    spans = tuple(Span(bound, bound, BOUND, "limit") for bound in bounds(dataset[output]))
    along = label(dataset[variable])
    return Pane(label(dataset[output]), curves, spans=spans, along=along)


def key_of(values: xr.DataArray) -> str:
    """What the numbers of texts along an axis mean; empty of numbers and of short texts."""
    names = _names(values)
    if max(map(len, names), default=0) <= MOST_LETTERS:
        return ""
    told = ", ".join(f"{number}: {value}" for number, value in enumerate(names, 1))
    return f"{label(values)}: {told}"


def _names(values: xr.DataArray) -> list[str]:
    """Texts in the order in which they come; none of numbers."""
    return list(dict.fromkeys(values.values.tolist())) if values.dtype.kind == "U" else []


def _marks() -> list[Artist]:
    """Legend of designs and limits."""
    looks = {"keeps every limit": WITHIN, "beyond a limit": BEYOND, "limit": BOUND}
    return line_handles(looks)
