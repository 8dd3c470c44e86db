"""What a shaper does to a move and its rest, and what rings over the time of a move."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales
from flexmech.plots.layout import AxesLike, sheet, tiles
from flexmech.plots.style import MID_GREY, POINT_SIZE, Look, line_handle, series_style

PLAIN: Look = {"color": MID_GREY, "lw": 1.1}
SHAPED: Look = {"color": series_style(0).color, "lw": 1.1}
_LOOKS = {"plain": PLAIN, "shaped": SHAPED | {"ls": series_style(1).linestyle}}
_OWN: Look = {"color": "0.15", "lw": 0.8, "ls": ":"}
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
    with sheet(scales.time_layout(1 + len(links)), ax=ax) as drawn:
        handles = [line_handle("plain law", **PLAIN), line_handle(shaper, **SHAPED)]
        handles.append(line_handle("end of the law", **(PLAIN | {"ls": ":"})))
        title = f"Plain and shaped law, {reading.engine_label(dataset)}"
        drawn.header(handles, f"{title}\n{reading.conditions(dataset)}", of=dataset)
        names = ["crank_speed_over_time", *["deflection"] * len(links)]
        for number, (axes, name) in enumerate(zip(drawn.panels, names, strict=True)):
            scales.zero_line(axes)
            link = links[number - 1]
            parts = [first[f"{prefix}{name}"] for prefix, *_ in looks]
            units = reading.LENGTH_UNITS if number else reading.crank_speed_units(dataset)
            if number:
                parts = [part.sel(link=link) for part in parts]
            both = np.concatenate([part.values for part in parts])
            factor, unit = reading.fitting_unit(both, units)
            for part, (prefix, look, until) in zip(parts, looks, strict=True):
                time = dataset[f"{prefix}time"].values
                axes.plot(time, factor * part.values, **look)
                axes.axvline(float(dataset.attrs[until]), **(look | {"ls": ":"}), zorder=0.5)
            scales.plain_numbers(axes)
            what = f"{reading.link_label(dataset, link)}\ndeflection" if number else "Crank\nspeed"
            axes.set_ylabel(f"{what} ({unit})")
            axes.set_xlim(0.0, float(dataset["shaped_time"][-1]))
        drawn.label_x("Time (s)")
    return drawn.figure


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
    found, whole = dataset["move_amplitude"], dataset["whole_move_time"]
    greatest = float(found.max()) or 1.0
    modes = [
        int(mode)
        for mode in found["mode"].values
        if float(found.sel(mode=mode).max()) >= _SEEN * greatest
    ] or [int(found["mode"].values[0])]
    names = [str(name) for name in found["law"].values]
    simulated = dataset.get("simulated_move_amplitude")
    with sheet(tiles(len(modes), 2, 2.1, extra=0.5), ax=ax) as drawn:
        drawn.header(_handles(dataset, names), _title(dataset), of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            own = found.sel(mode=mode)
            peaks = own.max(("law", "move_time")).values
            link = str(own["link"].values[int(np.argmax(peaks))])
            factor, unit = reading.fitting_unit(np.array([greatest]), reading.LENGTH_UNITS)
            for name in names:
                place, line = move_line(dataset, name, mode, link)
                look = _LOOKS[name] if place.size > whole.sizes["move_time"] else _dots(name)
                axes.plot(place, factor * line, **look)
                if simulated is None:
                    continue
                at = whole.sel(law=name, move_time=simulated["simulated_move_time"].values)
                points = simulated.sel(mode=mode, link=link, law=name)
                rows = reading.values_of(points, "simulating_engine", "simulated_move_time")
                for number, one in enumerate(rows):
                    axes.plot(at.values, factor * one, **_points(name, number))
            values = factor * found.sel(link=link, mode=mode).values
            low, high = scales.log_limits(values[values > 0] if values.any() else [1.0], _DECADES)
            scales.log_scale(axes, low / 1.5, high)
            axes.axvline(float(dataset.attrs["own_move_time"]), **_OWN, zorder=0.5)
            frequency = float(dataset["move_frequency"].sel(mode=mode))
            axes.set_title(f"Mode {mode}, {frequency:.4g} Hz")
            axes.set_ylabel(f"{reading.link_label(dataset, link)} ({unit})")
        drawn.label_x("Time until the stop (s)")
    return drawn.figure


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
    }


def _handles(dataset: xr.Dataset, names: list[str]) -> list[Artist]:
    labels = {"plain": "plain law", "shaped": str(dataset.attrs.get("shaper", ""))}
    handles = [line_handle(labels[name], **_LOOKS[name]) for name in names]
    if "simulating_engine" in dataset.coords:
        handles += [
            line_handle(str(name), **(_points("plain", number) | {"mec": "0.15"}))
            for number, name in enumerate(dataset["simulating_engine"].values)
        ]
    return [*handles, line_handle("time of the model file", **_OWN)]


def _title(dataset: xr.Dataset) -> str:
    return f"Amplitude of each mode after the stop\n{reading.conditions(dataset)}"
