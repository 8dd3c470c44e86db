"""Outputs over what varies: lines, contours or points, with their limits.

The best designs show what one goal costs of the others; uncertain outputs, which input makes them
so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots.drawing import draw, drawing, figure
from flexmech.plots.drawn_linkage.sketch import LinkageSketch
from flexmech.plots.layout import TILE, AxesLike, sheet, tiles
from flexmech.plots.picture import Curve, Note, Pane, Picture, Span, over_angles
from flexmech.plots.reading import degrees, mode_label
from flexmech.plots.style import (
    LIGHT_GREY,
    MID_GREY,
    SERIES_STYLES,
    Look,
    legend_handles,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Large panel of a front and of a panel of contours in inches.
LARGE_PANEL = 3.0
BOUND: Look = {"color": "black", "lw": 1.0, "ls": "--"}
"""Line of a limit."""


def computed(dataset: xr.Dataset) -> xr.Dataset:
    """Designs that can be computed.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a study.

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If there is none.
    """
    known = dataset.isel(design=np.flatnonzero(dataset["status"].values == "ok"))
    if not known.sizes["design"]:
        raise InputError("no design can be computed; see the reasons in designs.csv")
    return known


def outputs_of(dataset: xr.Dataset) -> list[str]:
    """Names of the outputs of a study."""
    return str(dataset.attrs["outputs"]).split()


def variables_of(dataset: xr.Dataset) -> list[str]:
    """Names of what varies in a study."""
    return str(dataset.attrs["variables"]).split("\n")


def varying(dataset: xr.Dataset) -> list[str]:
    """Names of what takes two values or more among the designs; all where nothing does."""
    names = variables_of(dataset)
    return [name for name in names if len(np.unique(dataset[name].values)) > 1] or names


def goals_of(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """Sense (``"min"`` or ``"max"``) and output of each goal of a study."""
    goals = [goal.split(" ", 1) for goal in str(dataset.attrs["goals"]).split("\n") if goal]
    return [(sense, output) for sense, output in goals]


def bounds(values: xr.DataArray) -> list[float]:
    """Limits of an output in the unit in which it is shown."""
    attributes = values.attrs
    return [
        from_si(float(attributes[name]), attributes["shown_unit"])
        for name in ("least", "greatest")
        if name in attributes
    ]


def shown(values: xr.DataArray) -> FloatArray:
    """Values in the unit in which they are shown; texts as they are."""
    if values.dtype.kind == "U":
        return values.values
    return np.asarray(values.values * from_si(1.0, values.attrs["shown_unit"]))


def label(values: xr.DataArray) -> str:
    """Name of a variable or output, with its unit, and of uncertain ones their percentile."""
    name = short_name(str(values.name))
    if statistic := values.attrs.get("statistic"):
        name = f"{name}, {statistic}"
    unit = values.attrs.get("shown_unit", "")
    return f"{name} ({unit or '-'})" if values.dtype.kind != "U" else name


def short_name(name: str) -> str:
    """The last two parts of a key of the model file, which tell what it is, in words."""
    return " ".join(name.split(".")[-2:]).replace("_", " ")


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
        Dataset of a ``DesignSweep``.
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
    return draw(Picture(panes, "", dataset, title), ax=ax)


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
        marks = {"keeps every limit": WITHIN, "beyond a limit": BEYOND, "limit": BOUND}
        handles = legend_handles(marks if limits else {"design": WITHIN})
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
    layout = tiles(len(panes), min(len(variables), 3))
    return draw(Picture(panes, "", known, heading, layout=layout), ax=ax)


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
    """Meaning of the numbers of texts along an axis; empty for numbers and short texts."""
    names = _names(values)
    if max(map(len, names), default=0) <= MOST_LETTERS:
        return ""
    numbered = ", ".join(f"{number}: {value}" for number, value in enumerate(names, 1))
    return f"{label(values)}: {numbered}"


def _names(values: xr.DataArray) -> list[str]:
    """Texts in the order in which they come; none of numbers."""
    return list(dict.fromkeys(values.values.tolist())) if values.dtype.kind == "U" else []


# Linkages of a front that are drawn, what of a panel's height they take, and the size of their
# pins over that in a picture of one linkage.
MOST_LINKAGES, STRIP, PIN = 5, 0.36, 1.4


def plot_pareto(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the trade-off of the goals: the designs that no other is better than.

    Some of them are drawn above it, to one scale, where the dataset has their ``rigid_position``
    (design, link, station, component).

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Optimum``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each goal but the first. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are fewer than two goals.
    """
    goals = goals_of(dataset)
    if len(goals) < 2:
        raise InputError("one goal has one best design, and no front; plot_search draws its search")
    picture = pareto_picture(dataset)
    with drawing(picture, ax=ax) as drawn:
        if "rigid_position" in dataset:
            best = dataset.sortby(goals[0][1])
            for axes, pane in zip(drawn.panels, picture.panes, strict=True):
                _draw_linkages(axes, best, pane.curves[0].x, pane.curves[0].y)
    return drawn.figure


def pareto_picture(dataset: xr.Dataset) -> Picture:
    """Best designs of the first goal and of each further one, as of plot_pareto."""
    (sense, first), *others = goals_of(dataset)
    best = dataset.sortby(first)
    # The front of three goals and more is a surface, which no line follows.
    line = "" if others[1:] else "-"
    look: Look = {"marker": "o", "ms": 4, "lw": 0.8, "ls": line, "color": series_style(0).color}
    along = f"{label(best[first])}, {sense}"
    panes = [
        Pane(
            f"{label(best[output])}, {other}",
            (Curve(shown(best[first]), shown(best[output]), look, "design"),),
            along=along,
        )
        for other, output in others
    ]
    title = "Designs that no other is better than in every goal"
    return Picture(panes, "", dataset, title, layout=tiles(len(panes), 2, LARGE_PANEL))


def _draw_linkages(axes: Axes, best: xr.Dataset, x: FloatArray, y: FloatArray) -> None:
    """Designs along a front as small linkages in a strip above it, each joined to its point."""
    wanted = np.linspace(x[0], x[-1], min(MOST_LINKAGES, x.size))
    chosen = np.unique(np.abs(x - wanted[:, None]).argmin(axis=1))
    sketches = [
        replace(LinkageSketch.of(best.isel(design=int(number))), joint_size=PIN)
        for number in chosen
    ]
    around = Bbox.union([sketch.limits(sketch.links, 0.0) for sketch in sketches])
    limits = around.expanded(1.1, 1.1)
    # The front below the strip, with some room around it.
    room = 0.05 * (float(np.ptp(y)) or abs(float(y[0])) or 1.0)
    low, high = float(y.min()) - room, float(y.max()) + room
    axes.set_ylim(low, low + (high - low) / (1 - STRIP))
    wide = 1 / len(sketches)
    for place, (number, sketch) in enumerate(zip(chosen.tolist(), sketches, strict=True)):
        inside = axes.inset_axes((place * wide, 1 - STRIP + 0.03, 0.95 * wide, STRIP - 0.03))
        sketch.frame(inside, limits)
        sketch.draw(inside, color=series_style(0).color, lw=1.0)
        axes.annotate(
            "",
            (x[number], y[number]),
            ((place + 0.475) * wide, 1 - STRIP + 0.03),
            textcoords="axes fraction",
            arrowprops={"arrowstyle": "-", "color": MID_GREY, "lw": 0.5},
        )


BEST: Look = {"ls": "", "marker": "*", "ms": 9.0, "color": "black", "zorder": 4}


@figure
def plot_search(dataset: xr.Dataset) -> Picture:
    """Draw the goals of all designs of the search over what varies, and the best designs.

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Optimum``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each goal over each variable. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    variables = variables_of(dataset)
    panes = [pane for name in variables for pane in search_panes(dataset, name)][:MOST_PANELS]
    title = f"Designs of the search: {dataset.sizes['trial']}"
    return Picture(panes, "", dataset, title)


def search_panes(dataset: xr.Dataset, variable: str) -> list[Pane]:
    """Goals of all designs of a search over one variable, with the best designs as stars.

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Optimum``.
    variable : str
        Texts stand along x by their numbers.

    Returns
    -------
    list of Pane
        One for each goal.
    """
    best, panes = dataset[variable], list[Pane]()
    within, x = dataset["trial_within"].values, dataset["trial_value"].sel(variable=variable)
    along, is_text = label(best), best.dtype.kind == "U"
    across = x.values if is_text else shown(x.assign_attrs(best.attrs))
    for sense, output in goals_of(dataset):
        goal = shown(dataset[output])
        y = shown(dataset["trial_goal"].sel(goal=output).assign_attrs(dataset[output].attrs))
        curves = [
            Curve(across[which], y[which], look, word)
            for which, look, word in (
                (~within, BEYOND, "beyond a limit"),
                (within, WITHIN, "keeps every limit"),
            )
            if which.any()
        ]
        # A text stands where a design as good was tried.
        tried = across[[int(np.nanargmin(np.abs(y - one))) for one in goal]]
        curves.append(Curve(tried if is_text else shown(best), goal, BEST, "best design"))
        panes.append(Pane(f"{label(dataset[output])}, {sense}", curves, along=along))
    return panes


# Percentiles of frequencies: of the interval of 95 % its lower end, the median, its upper end.
BAND = (2.5, 50.0, 97.5)
# Bars of a distribution at most.
MOST_BARS = 60
# Shares of Sobol's indices: variable, words, and how far beside the row of their input they stand.
SHARES = (("first_order", "first order", -0.12), ("total", "total", 0.12))
# Percentiles of outputs: look and name in the legend.
PERCENTILES: Mapping[str, tuple[Look, str]] = {
    "p50": ({"color": "black", "lw": 1.2}, "median"),
    "p2_5": ({"color": "black", "lw": 0.9, "ls": ":"}, "2.5 and 97.5 %"),
    "p97_5": ({"color": "black", "lw": 0.9, "ls": ":"}, "2.5 and 97.5 %"),
}


@figure
def plot_sensitivity(dataset: xr.Dataset) -> Picture:
    """Draw the share of every input in the variance of every output, with its interval.

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Uncertainty``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each output. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no shares, as of correlated inputs.
    """
    if "total" not in dataset:
        raise InputError(dataset.attrs["no_shares"])
    panes = [_shares(dataset.sel(output=name)) for name in dataset["output"].values.tolist()]
    layout = tiles(len(panes), 2, max(TILE, 0.5 + 0.3 * dataset.sizes["input"]))
    title = "Share of each input in the variance (Sobol)"
    return Picture(panes, "Share of the variance (-)", dataset, title, layout=layout)


def _shares(own: xr.Dataset) -> Pane:
    """Shares of one output as points with their intervals; none where it does not vary."""
    names, curves = own["input"].values.tolist(), list[Curve]()
    for number, (name, words, aside) in enumerate(SHARES):
        row, style = np.arange(1.0, len(names) + 1) + aside, series_style(number)
        dots: Look = {"color": style.color, "ls": "", "marker": style.marker, "ms": 5.0}
        curves.append(Curve(own[name].values, row, dots, words))
        # One line that is broken behind each interval.
        low, high = (own[f"{name}_{end}"].values for end in ("low", "high"))
        x, y = (np.stack([*ends, np.nan * row], axis=-1) for ends in ((low, high), (row, row)))
        curves.append(Curve(x.ravel(), y.ravel(), {"color": style.color}, followed=None))
    centred: Look = {"ha": "center", "va": "center"}
    constant = not np.isfinite(own["total"].values).any()
    notes = [Note(0.5, 0.5, "does not vary", centred, high=True)] if constant else []
    return Pane(
        "",
        curves,
        title=f"Share in {own['output'].item()}",
        spans=(Span(0.0, 0.0, {"color": MID_GREY, "lw": 0.6}, upright=True),),
        rows=list(map(short_name, names)),
        notes=notes,
    )


@figure
def plot_distributions(dataset: xr.Dataset) -> Picture:
    """Draw the distribution of every output, its percentiles and its limit.

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Uncertainty``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each output. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If no design can be computed.
    """
    outputs = outputs_of(dataset)
    panes = [distribution_pane(dataset, name) for name in outputs]
    title, label_y = "Distribution of the outputs", "Probability density"
    return Picture(panes, "", dataset, title, label_y)


def distribution_pane(dataset: xr.Dataset, output: str) -> Pane:
    """How often an output takes its values among the designs; median, 95 % interval and limits.

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Uncertainty``.
    output : str

    Returns
    -------
    Pane
    """
    known = computed(dataset)
    values, unit = shown(known[output]), dataset[output].attrs["shown_unit"]
    count = min(int(known.sizes["design"] ** 0.5), MOST_BARS)
    heights, edges = np.histogram(values, count, density=True)
    x, y = np.repeat(edges, 2)[1:-1], np.repeat(heights, 2)
    bars = Curve(x, 0.0 * y, {"color": series_style(0).color, "alpha": 0.5, "lw": 0}, upto=y)
    places = [(from_si(float(dataset[p].sel(output=output)), unit), p) for p in PERCENTILES]
    spans = [Span(at, at, *PERCENTILES[name], upright=True) for at, name in places]
    limit = BOUND | {"color": series_style(1).color}
    spans += [Span(at, at, limit, "limit", upright=True) for at in bounds(known[output])]
    ends = 0.0, 1.05 * float(heights.max())
    return Pane("", (bars,), spans=spans, limits=ends, along=label(known[output]))


@figure
def plot_frequency_bands(dataset: xr.Dataset) -> Picture:
    """Draw the median of the natural frequencies over the crank angle, and where 95 % lie.

    Parameters
    ----------
    dataset : Dataset
        Dataset of an ``Uncertainty`` whose outputs are found from natural frequencies.
    ax : Axes or sequence of Axes, optional
        The user's, one for each mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no frequencies over the crank angle.
    """
    if "frequency_percentile" not in dataset:
        raise InputError(
            "there are no frequencies over the crank angle; ask for lowest_frequency or another "
            "output that is found from natural frequencies"
        )
    bands = dataset["frequency_percentile"]
    angles, panes = degrees(bands["crank_angle"]), []
    shade: Look = {"color": series_style(0).color, "alpha": 0.3, "lw": 0}
    for mode in bands["mode"].values.tolist():
        low, median, high = (bands.sel(mode=mode, percentile=part).values for part in BAND)
        line = Curve(angles, median, series_line(0), "median")
        interval = Curve(angles, low, shade, "95 % of the designs", upto=high)
        panes.append(Pane("", (line, interval), title=mode_label([mode])))
    title = f"Natural frequencies of {bands.attrs['designs']} designs"
    layout = tiles(len(panes), 3)
    return over_angles(angles, panes, dataset, title, "Frequency (Hz)", layout=layout)
