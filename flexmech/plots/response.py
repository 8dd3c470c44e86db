"""What the running linkage does against time: deflections, strains, torque and forces.

A shaped move stands beside the plain one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.plots import reading, scales
from flexmech.plots.drawing import figure
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, SecondAxis, Span, by_engine
from flexmech.plots.style import MID_GREY, Look, series_line, series_style

ROTATION_UNITS: reading.Units = ((np.degrees(1.0), "deg"),)
SPEED_UNITS: reading.Units = ((1.0, "rad/s"), (1e3, "mrad/s"), (1e6, "µrad/s"))

# Thinner than the engines' lines, which it covers where the links are as good as rigid.
RIGID: Look = {"color": "0.25", "lw": 0.6, "zorder": 3}

# Strain behind the deflection, which it follows closely, and its width over that of a line.
STRAIN, WIDE = Look(color="0.75", zorder=1.5, solid_capstyle="butt"), 3.5


@figure
def plot_response(dataset: xr.Dataset) -> Picture:
    """Draw the deflection of each link, and bending strains in the middle, against time.

    One panel for the deflection of each link that is not rigid: of its middle from the line
    between its pins, with the bending strain there by the first engine on a second axis, or of a
    clamped link's tip. Under them the rotation and speed of a shaft that is free, against what is
    prescribed. The axis on top gives the crank angle. A periodic motion is drawn over one turn.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result; m, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = reading.a_turn(dataset)
    links = reading.bending_links(dataset)
    shown = [
        (f"{reading.link_label(dataset, name)}\ndeflection", dataset["deflection"].sel(link=name))
        for name in links
    ]
    panes = [
        replace(pane, right=_strain(dataset.sel(link=name)))
        for name, pane in zip(
            links,
            engine_panes(dataset, [(*one, reading.LENGTH_UNITS) for one in shown]),
            strict=True,
        )
    ]
    panes += shaft_panes(dataset)
    fewer = "choose one link (links=...)"
    return over_time(dataset, panes, reading.run_title(dataset), fewer=fewer)


def _strain(own: xr.Dataset) -> SecondAxis | None:
    """Strain in the middle of a link by the first engine; none of a link watched at its tip."""
    if own["probe"] != "middle":
        return None
    time, values = own["time"].values, own["strain"].isel(engine=0).values
    curve = Curve(time, values, STRAIN, "strain (right axis)", wave=WIDE)
    label = f"{str(own['link'].item()).capitalize()}\nstrain"
    return SecondAxis(label, 1.0, reading.STRAIN_UNITS, [curve])


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


@figure
def plot_forces(dataset: xr.Dataset) -> Picture:
    """Draw driving torque and magnitudes of joint forces against time, and where engines differ.

    Power stands on a second axis of the torque at constant speed, below it under a law of motion.
    Forces are those of all joints, bearings included, as far as the run's band lets them through:
    vibrations of the links along their length are too fast to be distinguished. Beside them stand
    the forces of rigid links (dark grey). Below is the difference of the second engine's magnitudes
    from the first's. A periodic motion is drawn over one turn.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result; N m, N, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = reading.a_turn(dataset)
    torque = dataset["driving_torque"], dataset["rigid_driving_torque"]
    varies = "drive" in dataset.attrs or "crank_speed_fluctuation" in dataset
    varies = varies or bool(dataset.attrs.get("run_up_time"))
    speed = 0.0 if varies else float(dataset.attrs["crank_speed"])
    right = SecondAxis("Driving\npower", speed, reading.POWER_UNITS) if speed else None
    curves = elastic_and_rigid(dataset, *torque)
    panes = [Pane("Driving\ntorque", curves, reading.TORQUE_UNITS, spans=(ZERO,), right=right)]
    if "driving_power" in dataset:
        power = "Driving\npower", dataset["driving_power"], reading.POWER_UNITS
        panes += engine_panes(dataset, [power])
    forces, rigid = (_magnitude(dataset[f"{of}joint_force"]) for of in ("", "rigid_"))
    joints = reading.names_of(dataset, "joint")
    for joint in joints:
        title = reading.joint_title(dataset, joint)
        curves = elastic_and_rigid(dataset, forces.sel(joint=joint), rigid.sel(joint=joint))
        panes.append(Pane(f"Force\nat {joint}", curves, reading.FORCE_UNITS, title, (ZERO,)))
    if dataset.sizes["engine"] > 1:
        apart = reading.values_of(forces[1] - forces[0], "joint", "time")
        # In other colours than the engines have.
        differing = [
            Curve(forces["time"].values, line, series_line(number), wave=1.0, label=joint)
            for number, (line, joint) in enumerate(zip(apart, joints, strict=True), 2)
        ]
        title = f"Force by {' less force by '.join(reading.names_of(dataset, 'engine')[1::-1])}"
        panes.append(Pane("Difference", differing, reading.FORCE_UNITS, title, (ZERO,)))
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
    """Magnitude of a force with dim component, at each sample."""
    size: xr.DataArray = xr.apply_ufunc(
        lambda parts: np.linalg.norm(parts, axis=-1), force, input_core_dims=[["component"]]
    )
    return size


@figure
def plot_frame_motion(dataset: xr.Dataset) -> Picture:
    """Draw the motion of a frame on springs, and the shaking force that reaches the floor.

    Beside the force on the floor stands what the mechanism puts on the frame (dark grey).

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result of a mechanism with a frame on springs:
        ``frame_displacement`` (engine, time, component) in m, ``frame_rotation`` in rad and
        ``floor_force`` and ``shaking_force`` in N.
    ax : Axes or sequence of Axes, optional
        The user's, five of them. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset = reading.a_turn(dataset)
    along = [(one, dataset.sel(component=one)) for one in reading.names_of(dataset, "component")]
    shown = [
        (f"Frame\nalong {one}", own["frame_displacement"], reading.LENGTH_UNITS)
        for one, own in along
    ]
    shown.append(("Frame\nrotation", dataset["frame_rotation"], ROTATION_UNITS))
    panes = engine_panes(dataset, shown)
    for one, own in along:
        curves = by_engine(own["floor_force"], dataset)
        shaking = own["shaking_force"][0].values
        curves.append(Curve(own["time"].values, shaking, RIGID, "shaking force on the frame"))
        what = f"Force on the\nfloor along {one}"
        panes.append(Pane(what, curves, reading.FORCE_UNITS, spans=(ZERO,)))
    title = f"Frame on springs\n{reading.run_title(dataset)}"
    return over_time(dataset, panes, title)


PLAIN: Look = {"color": MID_GREY, "lw": 1.1}
SHAPED: Look = {"color": series_style(0).color, "lw": 1.1}


@figure
def plot_shaped(dataset: xr.Dataset) -> Picture:
    """Draw the speed of the crank and the deflection of each link, by plain and by shaped law.

    The first engine's run is drawn. A dotted line marks the end of each law.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result with a shaper: ``crank_speed_over_time`` and ``deflection``
        over ``time``, the same with ``shaped_`` over ``shaped_time``; m, rad/s and s.
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
