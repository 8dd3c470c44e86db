"""What the running linkage does against time: deflections, strains, torque and forces.

What a shaper does to a move and its rest, and what rings over the time of a move.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales
from flexmech.plots.drawing import draw, figure
from flexmech.plots.layout import AxesLike, tiles
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, Span, by_engine
from flexmech.plots.style import MID_GREY, POINT_SIZE, Look, series_style

ROTATION_UNITS: reading.Units = ((np.degrees(1.0), "deg"),)
SPEED_UNITS: reading.Units = ((1.0, "rad/s"), (1e3, "mrad/s"), (1e6, "µrad/s"))

# Thinner than the engines' lines, which it covers where the links are as good as rigid.
RIGID: Look = {"color": "0.25", "lw": 0.6, "zorder": 3}

# Panels of forces that fit a page: with more of them magnitudes stand alone, without components.
MOST_FORCE_PANELS = 7


@figure
def plot_response(dataset: xr.Dataset) -> Picture:
    """Draw the deflection of each link, and bending strains in the middle, against time.

    One panel for the deflection of each link that is not rigid: of its middle from the line
    between its pins, or of a clamped link's tip. Under them the bending strain of those links
    whose middle is watched, and the rotation and speed of a shaft that is free, against what is
    prescribed. The axis on top gives the crank angle.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; m, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    links = reading.bending_links(dataset)
    strained = [name for name in links if dataset["probe"].sel(link=name) == "middle"]
    watched = [("deflection", name, reading.LENGTH_UNITS) for name in links]
    watched += [("strain", name, reading.STRAIN_UNITS) for name in strained]
    shown = [
        (f"{reading.link_label(dataset, name)}\n{of}", dataset[of].sel(link=name), units)
        for of, name, units in watched
    ]
    panes = [*engine_panes(dataset, shown), *shaft_panes(dataset)]
    fewer = "choose one link that is watched at its tip (links=...)"
    return over_time(dataset, panes, reading.run_title(dataset), fewer=fewer)


def shaft_panes(dataset: xr.Dataset) -> list[Pane]:
    """Rotation and speed of a free shaft against what is prescribed; none of a driven one."""
    if "shaft_rotation" not in dataset:
        return []
    rotation = "Shaft\nrotation", dataset["shaft_rotation"], ROTATION_UNITS
    speed = "Shaft speed\nfluctuation", dataset["crank_speed_fluctuation"], SPEED_UNITS
    return engine_panes(dataset, [rotation, speed])


def over_time(
    dataset: xr.Dataset, panes: Sequence[Pane], title: str, *, fewer: str = ""
) -> Picture:
    """A picture against time, with the crank angle on a second axis.

    Parameters
    ----------
    dataset : Dataset
        With ``time`` and ``crank_angle``.
    panes : sequence of Pane
    title, fewer : str
        As of a picture.

    Returns
    -------
    Picture
    """
    time = dataset["time"].values
    return Picture(panes, "Time (s)", dataset, title, over="time", places=time, fewer=fewer)


def engine_panes(
    dataset: xr.Dataset, shown: Iterable[tuple[str, xr.DataArray, reading.Units]]
) -> list[Pane]:
    """Panes of quantities by all engines against time.

    Parameters
    ----------
    dataset : Dataset
    shown : iterable of (str, DataArray, tuple)
        Words, values with dims engine and time in the SI unit, and units to choose from.

    Returns
    -------
    list of Pane
    """
    return [
        Pane(what, by_engine(values, dataset), units, spans=(ZERO,))
        for what, values, units in shown
    ]


def plot_forces(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the driving torque and the pin forces against time, with those of rigid links.

    Forces are those of the pins between links, or of the clamped joint where there is no
    pin, as far as the run's band lets them through: what the links vibrate along themselves
    is too fast to be told apart. Of each the magnitude and both components are drawn, of more
    than two joints the magnitudes alone, so that a page holds them. Beside them those of rigid
    links (dark grey).

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; N m, N, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    pins = dataset.isel(joint=np.flatnonzero(dataset["joint_kind"].values == "pin"))
    shown = pins if pins.sizes["joint"] else dataset
    components = reading.names_of(dataset, "component")
    if 1 + shown.sizes["joint"] * (1 + len(components)) > MOST_FORCE_PANELS:
        components = []
    return draw(forces_picture(shown, components), ax=ax)


def forces_picture(dataset: xr.Dataset, components: Sequence[str] = ()) -> Picture:
    """Driving torque and the size of each joint's force, of elastic and of rigid links.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result.
    components : sequence of str
        Those shown besides the size.

    Returns
    -------
    Picture
    """
    torque = dataset["driving_torque"], dataset["rigid_driving_torque"]
    curves = elastic_and_rigid(dataset, *torque)
    panes = [Pane("Driving\ntorque", curves, reading.TORQUE_UNITS, spans=(ZERO,))]
    for joint in reading.names_of(dataset, "joint"):
        forces = [dataset[name].sel(joint=joint) for name in ("joint_force", "rigid_joint_force")]
        parts = {"magnitude": [_magnitude(force) for force in forces]}
        parts |= {one: [force.sel(component=one) for force in forces] for one in components}
        for part, (elastic, rigid) in parts.items():
            curves = elastic_and_rigid(dataset, elastic, rigid)
            title = reading.joint_title(dataset, joint) if part == "magnitude" else ""
            what = f"Force at {joint},\n{part}"
            panes.append(Pane(what, curves, reading.FORCE_UNITS, title, (ZERO,)))
    band = dataset.attrs.get("force_band")
    up_to = "" if band is None else f", forces up to {band:.4g} Hz"
    return over_time(dataset, panes, reading.run_title(dataset) + up_to)


def elastic_and_rigid(
    dataset: xr.Dataset, elastic: xr.DataArray, rigid: xr.DataArray
) -> tuple[Curve, ...]:
    """A load by all engines against time, and of rigid links.

    Parameters
    ----------
    dataset : Dataset
    elastic, rigid : DataArray
        With dims engine and time, and time.

    Returns
    -------
    tuple of Curve
    """
    line = Curve(rigid["time"].values, rigid.values, RIGID, "rigid links", followed=None)
    return (*by_engine(elastic, dataset), line)


def _magnitude(force: xr.DataArray) -> xr.DataArray:
    """Of a force with dim component, at each sample."""
    size: xr.DataArray = xr.apply_ufunc(
        lambda parts: np.linalg.norm(parts, axis=-1), force, input_core_dims=[["component"]]
    )
    return size


@figure
def plot_frame_motion(dataset: xr.Dataset) -> Picture:
    """Draw displacement and rotation of a frame on springs, and force on the floor, against time.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result of a mechanism with a frame on springs: ``frame_displacement``
        (engine, time, component) in m, ``frame_rotation`` in rad and ``floor_force`` in N.
    ax : Axes or sequence of Axes, optional
        The user's, five of them. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    along = [(one, dataset.sel(component=one)) for one in reading.names_of(dataset, "component")]
    shown = [
        (f"Frame\nalong {one}", own["frame_displacement"], reading.LENGTH_UNITS)
        for one, own in along
    ]
    shown.append(("Frame\nrotation", dataset["frame_rotation"], ROTATION_UNITS))
    shown += [
        (f"Force on the\nfloor along {one}", own["floor_force"], reading.FORCE_UNITS)
        for one, own in along
    ]
    title = f"Frame on springs\n{reading.run_title(dataset)}"
    return over_time(dataset, engine_panes(dataset, shown), title)


PLAIN: Look = {"color": MID_GREY, "lw": 1.1}
SHAPED: Look = {"color": series_style(0).color, "lw": 1.1}
_LOOKS = {"plain": PLAIN, "shaped": SHAPED | {"ls": series_style(1).linestyle}}
_OWN: Look = {"color": "0.15", "lw": 0.8, "ls": ":", "zorder": 0.5}
# Decades below the greatest amplitude that are drawn; a mode below a hundredth of it is not drawn.
_DECADES, _SEEN = 4.0, 0.01


@figure
def plot_shaped(dataset: xr.Dataset) -> Picture:
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
    layout = scales.time_layout(len(panes))
    return Picture(panes, "Time (s)", dataset, title, places=ends, layout=layout)


@figure
def plot_move_times(dataset: xr.Dataset) -> Picture:
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
    layout = tiles(len(panes), 2, extra=0.5)
    return Picture(panes, "Time until the stop (s)", dataset, title, layout=layout)


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
