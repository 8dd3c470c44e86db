"""Strength: how much of it links and pins use and where, and internal forces along the links."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales, style
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import ZERO, Choice, Curve, Note, Pane, Picture, Span

# In percent: there a part fails.
FAILS = 100.0
# Axes along used strength end at so much over the greatest.
ROOM = 1.12
# On a logarithmic scale: the lower end over the peak of the link that uses least, that end over the
# greatest at least, and room above.
LEAST_OF_PEAK, DECADES, LOG_ROOM = 0.2, 1e-3, 1.3
# Digits of a load factor: loads and strengths are known to fewer.
DIGITS = 3
# Heights in inches: of a part with its words, of the curves along the links, and of the axes.
ROW, CURVES, AXES = 0.38, 1.7, 0.5
# Words over a part's line: how far over it, in rows.
ABOVE = 0.12
# What the parts of each kind are called.
KINDS = {"link": "{}", "fatigue": "{},\nfatigue", "pin": "pin {}"}
LIMIT = Span(FAILS, FAILS, {"color": style.MID_GREY, "lw": 0.8, "ls": ":"}, "fails")
# Height of a row of panels in inches.
PANEL = 1.3
# Internal forces: variable, words, factors and units to choose from.
FORCES = (
    ("axial_force", "Axial force N", reading.FORCE_UNITS),
    ("shear_force", "Shear force V", reading.FORCE_UNITS),
    ("bending_moment", "Bending moment M", reading.TORQUE_UNITS),
)
# Numbers along the axes of a panel.
NUMBERS, NARROW_NUMBERS = 4, 2


@figure
def plot_strength(dataset: xr.Dataset) -> Picture:
    """Draw what part of its strength each link and pin uses, and each link along its length.

    That is one over the least load factor, for ever where endurance is judged: at 100 % a part
    fails. A part has a row, the weakest first, with its load factor, the kind of failure, the place
    from the link's start, and the crank angle. Below, each place of a link is at its worst crank
    angle; links whose layers are not known are left out.

    Parameters
    ----------
    dataset : Dataset
        With ``margin_part``, ``margin_kind``, ``margin_load_factor``, ``margin_position`` in m,
        ``margin_crank_angle`` in rad and ``margin_mode`` (margin), the weakest first;
        ``load_factor`` (engine, link, station, layer, surface) and ``position`` (link, station).
    ax : sequence of Axes, optional
        Two of the user's, or one where pins alone are judged. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    panes, curves = [_parts(dataset)], used_curves(dataset.isel(engine=0))
    heights = [ROW * max(len(panes[0].rows), 2)]
    if curves:
        panes.append(used_pane(curves))
        heights.append(CURVES)
    layout = grid(len(panes), 1, sum(heights) + AXES * len(panes), height_ratios=heights)
    title = f"Strength used at {_drive_text(dataset)}"
    return Picture(panes, "", dataset, title, layout=layout)


def _parts(dataset: xr.Dataset) -> Pane:
    """A row for each link and pin: how much of its strength its worst place uses."""
    links, names = reading.names_of(dataset, "link"), ("part", "kind", "load_factor")
    columns = (*names, "position", "crank_angle", "mode")
    worst: dict[tuple[str, str], tuple[float, float, float, str]] = {}
    for part, kind, *of_part in zip(*(dataset[f"margin_{n}"].values for n in columns), strict=True):
        if kind == "pin" or part in links:
            worst.setdefault((part, kind), tuple(of_part))
    used = np.array([FAILS / factor if factor else np.inf for factor, *_ in worst.values()])
    most = ROOM * float(used[np.isfinite(used)].max(initial=FAILS / 1e3))
    curves, notes = list[Curve](), list[Note]()
    small: style.Look = {"fontsize": "small", "va": "bottom"}
    for row, ((part, kind), (factor, place, angle, mode)) in enumerate(worst.items(), 1):
        number = links.index(part) if kind != "pin" else None
        color = "0.2" if number is None else style.series_style(number).color
        x, y = np.array([0.0, min(used[row - 1], most)]), np.full(2, float(row))
        dot: style.Look = {"color": color, "ls": "", "marker": "o", "ms": 5.0}
        curves += [Curve(x, y, {"color": color, "lw": 1.2}), Curve(x[1:], y[1:], dot)]
        where = f" at {1e3 * place:.4g} mm" if np.isfinite(place) else ""
        words = f"{factor:.{DIGITS}g}: {mode}{where}, crank at {np.degrees(angle):.3g}°"
        notes.append(Note(0.01 * most, row - ABOVE, words, small))
    return Pane(
        "",
        curves,
        title="Load factor and kind of failure",
        spans=(replace(LIMIT, upright=True),) if most > FAILS else (),
        along="1 / load factor (%)",
        rows=[KINDS[kind].format(part) for part, kind in worst],
        notes=notes,
        x_limits=(0.0, ROOM * most),
        apart="number",
    )


def used_curves(own: xr.Dataset, name: str = "", when: Choice | None = None) -> list[Curve]:
    """Strength used along each link in percent, at the worst crank angle of each place.

    Parameters
    ----------
    own : Dataset
        Part of a dataset of a ``Strength`` result by one engine.
    name : str
        What the legend adds to the names of the links.
    when : mapping, optional
        What the reader of a page must have chosen.

    Returns
    -------
    list of Curve
    """
    curves, links = list[Curve](), reading.names_of(own, "link")
    for link in judged_links(own):
        place = 1e3 * own["position"].sel(link=link).values
        known = np.isfinite(place)
        with np.errstate(divide="ignore"):
            percent = FAILS / least_factor(own, link)[known]
        # What breaks without any load has no end.
        percent[np.isinf(percent)] = np.nan
        look = style.series_line(links.index(link))
        curves.append(Curve(place[known], percent, look, f"{link}{name}", when=when or {}))
    return curves


def used_pane(curves: list[Curve]) -> Pane:
    """Strength used along links, on a scale that separates them, and where they fail."""
    most = max(float(np.nanmax(curve.y, initial=0.0)) for curve in curves) or FAILS
    least = min(float(np.nanmax(curve.y, initial=0.0)) or most for curve in curves)
    return Pane(
        "1 / load factor (%)",
        curves,
        title="Along the links",
        spans=(LIMIT,),
        limits=(max(LEAST_OF_PEAK * least, DECADES * most), LOG_ROOM * max(most, FAILS)),
        scale="plain log",
        along="Place from the link's start (mm)",
    )


def judged_links(own: xr.Dataset) -> list[str]:
    """Links of whose places load factors are known, in order."""
    known = own["load_factor"].notnull().any([d for d in own["load_factor"].dims if d != "link"])
    return [name for name in reading.names_of(own, "link") if bool(known.sel(link=name))]


def least_factor(own: xr.Dataset, link: str) -> FloatArray:
    """Least load factor of the layers at each station of a link, infinite where nothing grows."""
    factor = reading.values_of(own["load_factor"].sel(link=link), "station", "layer", "surface")
    return np.asarray(np.nanmin(np.where(np.isnan(factor), np.inf, factor), axis=(1, 2)))


def _drive_text(dataset: xr.Dataset) -> str:
    """Crank speed, and whose internal forces they are."""
    source = str(dataset.attrs["source_of_loads"])
    engine = reading.names_of(dataset, "engine")[0]
    whose = "rigid links" if engine == "rigid" else f"{source}, {engine} engine"
    return f"{reading.drive_text(dataset)} ({whose})"


@figure
def plot_internal_forces(dataset: xr.Dataset) -> Picture:
    """Draw axial force, shear force and bending moment along each link, with their envelopes.

    The envelope lies between the least and the greatest value of the turn at each place; a line
    shows them at the crank angle at which the link is nearest to failure.

    Parameters
    ----------
    dataset : Dataset
        With ``axial_force``, ``shear_force`` and ``bending_moment`` (engine, link, crank_angle,
        station), ``position`` (link, station) in m, ``margin_part``, ``margin_kind`` and
        ``margin_crank_angle`` (margin).
    ax : sequence of Axes, optional
        The user's: a row of three for each link. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    links = reading.names_of(dataset, "link")
    margins = (dataset[f"margin_{name}"].values for name in ("part", "kind", "crank_angle"))
    worst: dict[str, float] = {}
    for part, kind, angle in zip(*margins, strict=True):
        if kind == "link":
            worst[str(part)] = float(angle)
    angles = dataset["crank_angle"].values
    panes, in_units = [], {name: _in_unit(dataset[name][0], units) for name, _, units in FORCES}
    for link in links:
        place = 1e3 * dataset["position"].sel(link=link).values
        known = np.isfinite(place)
        most = NARROW_NUMBERS if style.is_narrow() else NUMBERS
        ticks = scales.ticks_within(float(place[known].min()), float(place[known].max()), most)
        at = f"\n(line: {np.degrees(worst[link]):.4g}°)" if link in worst else ""
        for variable, words, _ in FORCES:
            values, unit = in_units[variable]
            of_link = values.sel(link=link).values[:, known]
            low, high = of_link.min(axis=0), of_link.max(axis=0)
            band: style.Look = {"color": style.LIGHT_GREY, "lw": 0.0}
            curves = [Curve(place[known], low, band, "envelope over the turn", upto=high)]
            curves += [Curve(place[known], edge, _EDGE) for edge in (low, high)]
            if link in worst:
                line = of_link[int(np.abs(angles - worst[link]).argmin())]
                curves.append(Curve(place[known], line, _LINE, "at the angle nearest to failure"))
            symbol = words.split()[-1] if style.is_narrow() else words
            panes.append(
                Pane(
                    f"{link}{at}" if variable == FORCES[0][0] else "",
                    curves,
                    title=f"{symbol} ({unit})" if link == links[0] else "",
                    spans=(ZERO,),
                    along="Place (mm)" if link == links[-1] else "",
                    x_ticks=ticks,
                )
            )
    columns = len(FORCES)
    layout = grid(len(links), columns, PANEL * len(links) + 0.4, narrow=columns, sharex="row")
    title = f"Internal forces along the links at {_drive_text(dataset)}"
    return Picture(panes, "", dataset, title, layout=layout)


def _in_unit(force: xr.DataArray, units: reading.Units) -> tuple[xr.DataArray, str]:
    """Internal forces (crank_angle, station) of links in one unit."""
    values = force.transpose("link", "crank_angle", "station")
    factor, unit = reading.fitting_unit(values.values[np.isfinite(values.values)], units)
    return factor * values, unit


_EDGE: style.Look = {"color": style.MID_GREY, "lw": 0.7}
_LINE: style.Look = {"color": style.series_style(1).color, "lw": 1.4}
