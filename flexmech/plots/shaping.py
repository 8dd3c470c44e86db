"""What a shaper does to a move and its rest, and what rings over the time of a move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, tiles
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, Span
from flexmech.plots.style import MID_GREY, POINT_SIZE, Look, series_style

PLAIN: Look = {"color": MID_GREY, "lw": 1.1}
SHAPED: Look = {"color": series_style(0).color, "lw": 1.1}
_LOOKS = {"plain": PLAIN, "shaped": SHAPED | {"ls": series_style(1).linestyle}}
_OWN: Look = {"color": "0.15", "lw": 0.8, "ls": ":", "zorder": 0.5}
# Decades below the greatest amplitude that are drawn; a mode below a hundredth of it is not drawn.
_DECADES, _SEEN = 4.0, 0.01


def plot_shaped(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the speed of the crank and the deflection of each link, by plain and by shaped law.

    Of the first engine. A dotted line is where each law ends.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result with a shaper: ``crank_speed_over_time`` and ``deflection`` over
        ``time``, the same with ``shaped_`` over ``shaped_time``; m, rad/s and s.
    ax : sequence of Axes, optional
        The user's, one for the speed and one for each link that bends. Left out: a new figure is
        made.

    Returns
    -------
    Figure
    """
    links, first = reading.bending_links(dataset), dataset.isel(engine=0)
    shaper = str(dataset.attrs["shaper"])
    looks = (("", PLAIN, "run_up_time"), ("shaped_", SHAPED, "shaped_until"))
    spans, ends = [ZERO], np.array([0.0, float(dataset["shaped_time"][-1])])
    for _, look, until in looks:
        at, dots = float(dataset.attrs[until]), look | {"ls": ":", "zorder": 0.5}
        spans.append(Span(at, at, dots, "end of the law", upright=True))

    def pane(words: str, name: str, units: reading.Units, **place: str) -> Pane:
        curves = [
            Curve(dataset[f"{prefix}time"].values, first[f"{prefix}{name}"].sel(place).values, look)
            for prefix, look, _ in looks
        ]
        named = [replace(one, name=n) for one, n in zip(curves, ("plain law", shaper), strict=True)]
        return Pane(words, named, units, spans=spans)

    panes = [pane("Crank\nspeed", "crank_speed_over_time", reading.crank_speed_units(dataset))]
    for link in links:
        words = f"{reading.link_label(dataset, link)}\ndeflection"
        panes.append(pane(words, "deflection", reading.LENGTH_UNITS, link=link))
    title = f"Plain and shaped law, {reading.engine_label(dataset)}\n{reading.conditions(dataset)}"
    picture = Picture(panes, "Time (s)", dataset, title, places=ends)
    return draw(picture, scales.time_layout(len(panes)), ax=ax)


def plot_move_times(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw what each mode of the standing linkage rings after the stop, over the time of the move.

    A panel for each mode that rings noticeably, in the deflection of the link that shows it most.
    The time is that until the stop, a shaper's included. Lines are by the equations in link frames,
    points by an engine that simulates; a dotted line is the time that the model file states. A
    mode that rises and falls faster than the times of the move can tell is drawn as dots.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result with ``move_amplitude`` (law, move_time, link, mode) in m and
        ``whole_move_time`` (law, move_time) in s; ``move_curve`` (law, curve_move_time, link,
        curve_mode) in m and ``curve_whole_time`` (law, curve_move_time) in s of the modes that its
        times resolve.
    ax : sequence of Axes, optional
        The user's, one for each mode that is drawn. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    picture = move_picture(dataset)
    return draw(picture, tiles(len(picture.panes), 2, 2.1, extra=0.5), ax=ax)


def move_picture(dataset: xr.Dataset) -> Picture:
    """Amplitude of each mode after the stop over the time until it, as of plot_move_times."""
    found, greatest = dataset["move_amplitude"], float(dataset["move_amplitude"].max()) or 1.0
    seen = found.max([d for d in found.dims if d != "mode"]).values >= _SEEN * greatest
    modes = found["mode"].values[seen if seen.any() else slice(0, 1)].tolist()
    factor, unit = reading.fitting_unit(np.array([greatest]), reading.LENGTH_UNITS)
    end, panes = float(dataset.attrs["own_move_time"]), []
    for mode in modes:
        own = found.sel(mode=mode)
        link = str(own["link"].values[int(np.argmax(own.max(("law", "move_time")).values))])
        curves = [
            replace(one, y=factor * one.y)
            for law in reading.names_of(dataset, "law")
            for one in _of_law(dataset, law, mode, link)
        ]
        values = factor * own.sel(link=link).values
        low, high = scales.log_limits(values[values > 0] if values.any() else [1.0], _DECADES)
        panes.append(
            Pane(
                f"{reading.link_label(dataset, link)}\nmode {mode} ({unit})",
                curves,
                title=f"Mode {mode}, {float(dataset['move_frequency'].sel(mode=mode)):.4g} Hz",
                spans=(Span(end, end, _OWN, "time of the model file", upright=True),),
                limits=(low / 1.5, high),
                scale="log",
            )
        )
    title = f"Amplitude of each mode after the stop\n{reading.conditions(dataset)}"
    along = "Time until the stop (s)"
    return Picture(panes, along, dataset, title)


def _of_law(dataset: xr.Dataset, law: str, mode: int, link: str) -> list[Curve]:
    """A mode in a link under one law by the equations, and by the engines that simulated it."""
    place, line = move_line(dataset, law, mode, link)
    resolved = place.size > dataset.sizes["move_time"]
    name = str(dataset.attrs.get("shaper", "")) if law == "shaped" else "plain law"
    curves = [Curve(place, line, _LOOKS[law] if resolved else _dots(law), name)]
    if "simulated_move_amplitude" in dataset:
        points = dataset["simulated_move_amplitude"].sel(mode=mode, link=link, law=law)
        times = points["simulated_move_time"].values
        at = dataset["whole_move_time"].sel(law=law, move_time=times).values
        for number, engine in enumerate(reading.names_of(dataset, "simulating_engine")):
            simulated = points.isel(simulating_engine=number).values
            curves.append(Curve(at, simulated, _points(law, number), engine))
    return curves


def move_line(
    dataset: xr.Dataset, law: str, mode: int, link: str | None = None
) -> tuple[FloatArray, FloatArray]:
    """Amplitude of a mode over the time until the stop: a curve, or its values where it has none.

    Parameters
    ----------
    dataset : Dataset
        As of :func:`plot_move_times`.
    law : str
    mode : int
    link : str, optional
        Left out: the greatest of all links.

    Returns
    -------
    time : ndarray, shape (n,)
        In s.
    amplitude : ndarray, shape (n,)
        In m.
    """
    found, whole = dataset["move_amplitude"].sel(mode=mode), dataset["whole_move_time"]
    if "move_curve" in dataset and mode in dataset["curve_mode"].values:
        found = dataset["move_curve"].sel(curve_mode=mode)
        whole = dataset["curve_whole_time"]
    found = found.max("link") if link is None else found.sel(link=link)
    return whole.sel(law=law).values, found.sel(law=law).values


def _dots(law: str) -> Look:
    """Of amplitudes between which nothing is known."""
    look: Look = {"ls": "", "marker": ".", "markersize": POINT_SIZE, "color": _LOOKS[law]["color"]}
    return look


def _points(law: str, engine: int) -> Look:
    style = series_style(engine + 1)
    return {
        "ls": "",
        "marker": style.marker,
        "markersize": POINT_SIZE + 1,
        "mfc": "none",
        "mec": _LOOKS[law]["color"],
        "color": _LOOKS[law]["color"],
    }
