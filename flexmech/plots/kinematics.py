"""The rigid linkage: motion of points and links, joint forces, drive, transmission angles, paths.

The drive is a law of motion, with the vibration after its stop, or a motor.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.plots import angle_panels, reading, scales, style
from flexmech.plots.drawing import draw, drawing, figure
from flexmech.plots.drawn_linkage.sketch import RIGID, SMALL, LinkageSketch
from flexmech.plots.drawn_linkage.symbols import add_symbols, drawn_posture
from flexmech.plots.layout import AxesLike, grid
from flexmech.plots.picture import (
    ZERO,
    Curve,
    Note,
    Pane,
    Picture,
    SecondAxis,
    Span,
    by_engine,
    over_angles,
    series,
)
from flexmech.plots.response import ROTATION_UNITS, engine_panes, over_time
from flexmech.plots.style import MID_GREY, Look

# Motion of a link: variable, what it is, factor from the SI unit, and unit.
MOTIONS = (
    ("angle", "Angle", np.degrees(1.0), "deg"),
    ("angular_velocity", "Angular velocity", 1.0, "rad/s"),
    ("angular_acceleration", "Angular acceleration", 1.0, "rad/s²"),
)
# In points, doubled and trebled at each further round through the styles.
WIDTHS = (1.1, 2.2, 3.3)
# Around forces by distributed masses, which they hardly leave.
LUMPED: style.Look = {"color": "0.25", "linestyle": (0.0, (1.0, 1.4)), "lw": 1.3, "zorder": 1.9}

# Line of the magnitude of a force, behind its components.
MAGNITUDE: style.Look = {"color": "0.6", "lw": 2.2, "zorder": 1.5}

TITLE = "Transmission angle over a turn of the crank"

# Heights of two square panels beside each other, and of three, in inches: as high as they are wide.
HEIGHT, HEIGHT_OF_THREE = 3.6, 2.45
# Room of a close-up over the extent of the loops: what leads into them is seen on both
# sides.
CLOSE_UP_ROOM = 1.5
# Above this extent in m a picture is in m, below it in mm, whose numbers have four digits at most.
METRES = 10.0
# Round-off of an angular velocity that does not change, over the greatest one.
STEADY = 1e-9
# Between dots on a path, in degrees of the crank.
DOTS_APART = 30.0
DOT: style.Look = {"color": "0.2", "ls": "", "marker": "o", "ms": 2.6, "zorder": 3}
MARKS = {"crunode": "o", "cusp": "^"}
# Variables of a dataset of paths that are places in m; height of a path on a page over others.
_PLACES, PAGE_HEIGHT = ("position", "pin_position", "close_up", "framed"), 2.4
# Height of a pin's name over its path, in parts of the height of the first path.
NAME_OVER = 0.03


@figure
def plot_kinematics(dataset: xr.Dataset) -> Picture:
    """Draw angle, angular velocity and angular acceleration of the links but a steady crank's.

    Parameters
    ----------
    dataset : Dataset
        With ``angle``, ``angular_velocity`` and ``angular_acceleration`` (crank_angle, link) in
        SI units; the attributes ``crank_speed`` and ``mechanism``.
    ax : sequence of Axes, optional
        Three of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    over, (dataset, angles) = dataset, positions(dataset)
    links, panes = reading.names_of(dataset, "link"), list[Pane]()
    # The angle of a crank at constant speed is the axis along x.
    speed, acceleration = (
        reading.values_of(dataset[f"angular_{of}"], "link", "crank_angle")
        for of in ("velocity", "acceleration")
    )
    steady = (
        np.ptp(speed, axis=1) + np.abs(acceleration).max(axis=1) <= STEADY * np.abs(speed).max()
    )
    shown = np.flatnonzero(~steady | steady.all())
    for name, words, factor, unit in MOTIONS:
        values = factor * dataset[name].transpose("link", "crank_angle").values
        curves = series(angles, values, links, _link_line)
        panes.append(Pane(f"{words}\n({unit})", [curves[n] for n in shown], spans=(ZERO,)))
    title = f"Motion of the links {reading.conditions(over)}"
    return over_positions(over, panes, title, layout=grid(3, 1, 5.4, sharex=True))


@figure
def plot_joint_forces(dataset: xr.Dataset) -> Picture:
    """Draw the force at each joint, its magnitude and both components; by lumped masses too if any.

    Parameters
    ----------
    dataset : Dataset
        With ``joint_force`` (crank_angle, joint, component) in N, and ``lumped_joint_force`` if
        masses are lumped too; the attributes ``crank_speed`` and ``mechanism``.
    ax : sequence of Axes, optional
        The user's, one a joint. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    over, (dataset, angles) = dataset, positions(dataset)
    panes = []
    for joint in reading.names_of(dataset, "joint"):
        own = dataset.sel(joint=joint)
        force = reading.values_of(own["joint_force"], "component", "crank_angle")
        names = [f"along {name}" for name in reading.names_of(dataset, "component")]
        curves = series(angles, force, names)
        curves.append(Curve(angles, np.linalg.norm(force, axis=0), MAGNITUDE, "magnitude"))
        if "lumped_joint_force" in own:
            lumped = reading.values_of(own["lumped_joint_force"], "component", "crank_angle")
            curves += [_lumped(dataset, angles, line) for line in lumped]
        title = reading.joint_title(dataset, joint)
        panes.append(Pane("", curves, reading.FORCE_UNITS, title, (ZERO,)))
    title = f"Joint forces {reading.conditions(over)}"
    layout = angle_panels.angle_layout([1] * len(panes))
    return over_positions(over, panes, title, "Force", layout=layout)


@figure
def plot_drive(dataset: xr.Dataset) -> Picture:
    """Draw driving torque and power, and the transmission angles of a four-bar.

    Parameters
    ----------
    dataset : Dataset
        With ``driving_torque`` in N m and ``driving_power`` in W over crank_angle; those by
        lumped masses (``lumped_driving_torque``, ``lumped_driving_power``) and
        ``transmission_angle`` and ``reversed_transmission_angle`` in rad where there are any.
    ax : sequence of Axes, optional
        Two of the user's, three with transmission angles. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    over, (dataset, angles) = dataset, positions(dataset)
    both, panes = "transmission_angle" in dataset, []
    shown = [
        ("driving_torque", "Torque", reading.TORQUE_UNITS),
        ("driving_power", "Power", reading.POWER_UNITS),
    ]
    # At constant speed the power is the torque in another unit.
    steady = "time" not in over.dims and over.attrs["crank_speed"]
    right = SecondAxis("Power", float(steady), reading.POWER_UNITS) if steady else None
    for name, words, units in shown[:1] if steady else shown:
        curves = [Curve(angles, dataset[name].values, style.series_line(0, angles))]
        if f"lumped_{name}" in dataset:
            curves.append(_lumped(dataset, angles, dataset[f"lumped_{name}"].values))
        panes.append(Pane(words, curves, units, spans=(ZERO,)))
    panes[0] = replace(panes[0], spans=(ZERO, *_mean_torques(over)), right=right)
    if both:
        angle, turned = (
            np.degrees(dataset[f"{name}transmission_angle"].values) for name in ("", "reversed_")
        )
        panes.append(
            Pane(
                "Transmission\nangle (deg)",
                series(angles, (angle, turned), ("crank drives", "rocker drives")),
                spans=(Span(90.0, 90.0, ZERO.look),),
                limits=(0.0, 180.0),
                ticks=(0.0, 45.0, 90.0, 135.0, 180.0),
            )
        )
    layout = grid(len(panes), 1, 1.7 * len(panes) + 0.3, sharex=True)
    return over_positions(over, panes, f"Drive {reading.conditions(over)}", layout=layout)


def _mean_torques(dataset: xr.Dataset) -> Iterator[Span]:
    """Lines at the root mean square of the torque, and at its mean where the speed is constant."""
    rms = float(reading.sizing(dataset, "rms_torque", "shaft").item())
    yield Span(rms, rms, {"color": MID_GREY, "lw": 0.9, "ls": "--"}, "root mean square")
    if "time" not in dataset.dims and "mean_driving_power" in dataset and rms:
        mean = float(dataset["mean_driving_power"]) / float(dataset.attrs["crank_speed"])
        yield Span(mean, mean, {"color": MID_GREY, "lw": 0.9, "ls": ":"}, "mean")


def _link_line(number: int, points: FloatArray | None = None) -> style.Look:
    """Line of a link: a style of its own, wider for those beyond the styles."""
    width = WIDTHS[min(number // len(style.SERIES_STYLES), len(WIDTHS) - 1)]
    return style.series_line(number, points) | {"lw": width}


def _lumped(dataset: xr.Dataset, angles: FloatArray, values: FloatArray) -> Curve:
    """Forces of masses lumped at points."""
    name = f"{dataset.sizes['lump']} lumped masses"
    return Curve(angles, values, LUMPED, name, followed=None)


@figure
def plot_transmission_angle(dataset: xr.Dataset) -> Picture:
    """Draw transmission angles of linkages over the crank's turn.

    As Elamy et al. 2023, Figure 7.

    Parameters
    ----------
    dataset : Dataset
        With ``transmission_angle`` (linkage, crank_angle) in rad; the names along ``linkage``
        are those of the legend. The attributes ``wanted_least`` and ``wanted_greatest`` in rad
        shade a range, which the legend calls ``wanted_label``; ``title`` is the heading.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no linkages, or more than there are styles to tell them apart.
    """
    names = style.distinct_names(reading.names_of(dataset, "linkage"))
    values = np.degrees(reading.values_of(dataset["transmission_angle"], "linkage", "crank_angle"))
    angles, attrs = reading.degrees(dataset["crank_angle"]), dataset.attrs
    spans = [Span(90.0, 90.0, {"color": style.MID_GREY, "lw": 0.6, "zorder": 1})]
    if "wanted_least" in attrs:
        low, high = np.degrees([attrs["wanted_least"], attrs["wanted_greatest"]])
        words = str(attrs.get("wanted_label", "wanted range"))
        spans.append(Span(low, high, {"color": style.LIGHT_GREY, "zorder": 0}, words))
    pane = Pane("Transmission angle (deg)", series(angles, values, names), spans=spans)
    title = str(attrs.get("title", TITLE))
    return over_angles(angles, [pane], dataset, title, layout=grid(1, 1, 3.2))


def plot_coupler_curve(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw coupler curves of one linkage in several states, their double points and the pins.

    As Singh & Sanyal 2022, Figures 3 to 12.

    Parameters
    ----------
    dataset : Dataset
        With ``position`` (state, crank_angle, component), ``pin_position`` (state, crank_angle,
        pin, component) and ``double_point_position`` (double_point, component) in m, the state
        and kind of each double point as coordinates, and the name of the mechanism. Where there
        are loops, ``close_up`` (state, window, point, component) are fine stretches of the
        paths around them and ``framed`` (framed_place, component) what must be seen, in m.
    ax : sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
        Curves; a close-up of their loops where there are any; paths of A and B.

    Raises
    ------
    InputError
        If there are no states, or more than there are styles to tell them apart.
    """
    picture = coupler_picture(dataset)
    with drawing(picture, ax=ax) as drawn:
        for axes in drawn.panels:
            axes.set_box_aspect(1)
            axes.set_anchor("N")
        last = drawn.panels[-1]
        last.margins(0.15)
        if found := drawn_posture(dataset):
            _draw_linkage(last, LinkageSketch(*found[:2], mark_size=SMALL), _unit(dataset)[0])
    return drawn.figure


def coupler_picture(dataset: xr.Dataset) -> Picture:
    """Coupler curves, a close-up of their loops and the paths of the pins, in the plane.

    Parameters
    ----------
    dataset : Dataset
        As of :func:`plot_coupler_curve`.

    Returns
    -------
    Picture
    """
    states = style.distinct_names(reading.names_of(dataset, "state"))
    angles, of_curve = reading.degrees(dataset["crank_angle"]), _is_curve(dataset)
    factor, unit = _unit(dataset)
    scaled = factor * dataset[[n for n in _PLACES if n in dataset]]
    curves = _paths(scaled["position"].expand_dims("path"), states, angles)
    doubles = _double_points(dataset, factor)
    dots = _at_round_angles(scaled["position"], angles)
    title = "Coupler point" if of_curve else "Point"
    panes = [Pane("", [*curves, *doubles, *dots], title=title)]
    if "close_up" in dataset:
        # Without marks: it is fine whatever the crank angles.
        close = _paths(scaled["close_up"].rename(window="path"), states)
        x, y = _frame(reading.values_of(scaled["framed"], "framed_place", "component"))
        heading = "Close-up of the loops"
        panes.append(Pane("", [*close, *doubles], title=heading, x_limits=x, limits=y))
    pins = _paths(scaled["pin_position"].rename(pin="path"), states, angles)
    names, heading = list[Note](), "Pins A and B" if of_curve else "Ends of its link"
    for name, path in zip(reading.names_of(dataset, "pin"), pins, strict=False):
        top, over = int(path.y.argmax()), NAME_OVER * float(np.ptp(pins[0].y))
        above: Look = {"ha": "center", "va": "bottom"}
        names.append(Note(float(path.x[top]), float(path.y[top]) + over, name, above))
    if found := drawn_posture(dataset):
        heading += f", crank at {np.degrees(found[2]):.4g}°"
    panes.append(Pane("", [*pins, *curves], title=heading, notes=names))
    look: Look = {"label": f"y ({unit})", "along": f"x ({unit})", "height": PAGE_HEIGHT}
    # A page shows the first one alone.
    first, *others = (replace(pane, **look) for pane in panes)
    panes = [first, *(replace(pane, apart="plane") for pane in others)]
    legend = {_counted(dataset, s): style.series_line(n) for n, s in enumerate(states)}
    if dots:
        legend |= {f"every {DOTS_APART:g}° of the crank": DOT}
    # Beyond the crank angles drawn, marks stand off the lines.
    where = "" if np.ptp(angles) > 360.0 - 1e-4 else " of the whole curve"
    for kind, mark in MARKS.items():
        if kind in dataset["double_point_kind"].values:
            legend[kind + where] = {"color": "black", "ls": "", "marker": mark, "mfc": "none"}
    title = "Coupler curve" if of_curve else "Path of a point"
    height = HEIGHT if len(panes) == 2 else HEIGHT_OF_THREE
    layout, along = grid(1, len(panes), height), f"x ({unit})"
    return Picture(panes, along, dataset, title, over="plane", layout=layout, legend=legend)


def _unit(dataset: xr.Dataset) -> tuple[float, str]:
    """Unit of a picture of paths, and how many of it a metre has."""
    extent = dataset["position"].max("crank_angle") - dataset["position"].min("crank_angle")
    return (1.0, "m") if float(extent.max()) > METRES else (1e3, "mm")


def _is_curve(dataset: xr.Dataset) -> bool:
    """Whether it is of a four-bar's coupler, between pins A and B."""
    return reading.names_of(dataset, "pin") == ["A", "B"]


def _counted(dataset: xr.Dataset, state: str) -> str:
    """A state and how many double points of each kind its curve has."""
    if not _is_curve(dataset):
        return state
    of_state = dataset["double_point_state"].values == state
    kinds = dataset["double_point_kind"].values[of_state].tolist()
    counts = [(kinds.count(kind), kind) for kind in MARKS]
    return f"{state}: " + ", ".join(f"{n} {kind}{'' if n == 1 else 's'}" for n, kind in counts)


def _paths(
    places: xr.DataArray, states: Sequence[str], angles: FloatArray | None = None
) -> list[Curve]:
    """Paths of states, with dims state, path, component and places along the path."""
    values = places.transpose("state", "path", "component", ...).values
    return [
        Curve(x, y, style.series_line(number, angles), name, angle=angles)
        for number, (name, paths) in enumerate(zip(states, values, strict=True))
        for x, y in paths
    ]


def _at_round_angles(position: xr.DataArray, angles: FloatArray) -> list[Curve]:
    """Dots on the paths at equal times of a steady crank, from which one reads the speed."""
    at = np.flatnonzero(
        np.isclose(angles % DOTS_APART, 0.0) | np.isclose(angles % DOTS_APART, DOTS_APART)
    )
    if len(at) < 2:
        return []
    places = reading.values_of(position, "state", "component", "crank_angle")[:1, :, at]
    return [Curve(x, y, DOT, followed=None) for x, y in places]


def _double_points(dataset: xr.Dataset, factor: float) -> list[Curve]:
    """Double points of the curves in the colours of their states."""
    places = factor * reading.values_of(
        dataset["double_point_position"], "double_point", "component"
    )
    states = reading.names_of(dataset, "state")
    found = (reading.names_of(dataset, f"double_point_{what}") for what in ("state", "kind"))
    curves = list[Curve]()
    for state, kind, (x, y) in zip(*found, places[..., None], strict=True):
        look: Look = {"ls": "", "ms": 6.0, "mfc": "none", "zorder": 4, "marker": MARKS[kind]}
        color = style.series_style(states.index(state)).color
        curves.append(Curve(x, y, look | {"color": color}, kind))
    return curves


def _draw_linkage(axes: Axes, sketch: LinkageSketch, factor: float) -> None:
    """The linkage behind paths in the unit of a picture."""
    to_axes = Affine2D().scale(factor)
    add_symbols(axes, sketch.ground(), to_axes)
    for link, look in zip(sketch.links, sketch.link_looks(RIGID), strict=True):
        axes.plot(*(factor * link).T, **look, zorder=1)
    add_symbols(axes, sketch.on_links(), to_axes)


def _frame(places: FloatArray) -> list[tuple[float, float]]:
    """Limits of x and y that show places, with room around them."""
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    half = CLOSE_UP_ROOM * np.ptp(places, axis=0).max() / 2
    return [(float(place - half), float(place + half)) for place in middle]


# More columns are too narrow for the numbers of their axes; what is left out stands in the tables.
MOST_POINTS = 4
MOTION_HEIGHT = 4.6
VELOCITIES: reading.Units = ((1.0, "m/s"), (1e3, "mm/s"))
ACCELERATIONS: reading.Units = ((1.0, "m/s²"), (1e3, "mm/s²"))
KINDS = (
    ("position", "Position", reading.LENGTH_UNITS),
    ("velocity", "Velocity", VELOCITIES),
    ("acceleration", "Acceleration", ACCELERATIONS),
)
"""Quantities of a point: variable, words, and units."""
ITS_LINE, COUPLER_POINT = "its line", "coupler point"


class MotionLine(NamedTuple):
    """Motion of a point along one direction.

    Parameters
    ----------
    point, along : str
        Name of the point, and of the direction: ``x``, ``y`` or ``its line``.
    values : tuple of ndarray, shape (A,)
        Position in m, velocity in m/s and acceleration in m/s^2.
    """

    point: str
    along: str
    values: tuple[FloatArray, ...]


def drawn_points(dataset: xr.Dataset) -> list[str]:
    """Names of points whose motion is shown: sliders first, then what does not turn with the crank.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` result.

    Returns
    -------
    list of str
    """
    dataset, _ = positions(dataset)
    sliders = reading.names_of(dataset, "slider") if "slider" in dataset.coords else []
    if "point" not in dataset.coords:
        return sliders
    speed = np.linalg.norm(
        reading.values_of(dataset["point_velocity"], "point", "crank_angle", "component"), axis=-1
    )
    # The end of the crank goes round in a circle at one speed, which needs no picture.
    turns = np.ptp(speed, axis=1) <= SAME_PLACE * speed.max(axis=1)
    turns &= bool(dataset.attrs["crank_speed"])
    names = reading.names_of(dataset, "point")
    others = [name for name, out in zip(names, turns, strict=True) if not out]
    rest = [name for name in others if name not in sliders]
    # The coupler point of a model file, the last one, is what its user asked for.
    rest.sort(key=lambda name: name != COUPLER_POINT)
    return [*sliders, *rest]


def motion_lines(dataset: xr.Dataset, points: list[str]) -> list[MotionLine]:
    """Motion of points along the ground's axes, of sliders along their lines.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` result.
    points : list of str

    Returns
    -------
    list of MotionLine
    """
    sliders = reading.names_of(dataset, "slider") if "slider" in dataset.coords else []
    lines = []
    for point in points:
        if point in sliders:
            along = dataset.sel(slider=point)
            values = tuple(along[f"slider_{name}"].values for name, _, _ in KINDS)
            lines.append(MotionLine(point, ITS_LINE, values))
            continue
        own = dataset.sel(point=point)
        for axis in reading.names_of(dataset, "component"):
            there = own.sel(component=axis)
            values = tuple(there[f"point_{name}"].values for name, _, _ in KINDS)
            lines.append(MotionLine(point, axis, values))
    return lines


def positions(dataset: xr.Dataset) -> tuple[xr.Dataset, FloatArray]:
    """A dataset over positions of the linkage as one over crank_angle, and the places on its axis.

    Parameters
    ----------
    dataset : Dataset
        Over ``crank_angle``, or over ``time`` under a law of motion.

    Returns
    -------
    Dataset
        Over ``crank_angle`` by name alone, where it is over time.
    ndarray, shape (A,)
        Crank angles in degrees, or times in s.
    """
    if "time" not in dataset.dims:
        return dataset, reading.degrees(dataset["crank_angle"])
    renamed = dataset.drop_vars("crank_angle").rename(time="crank_angle")
    return renamed, renamed["crank_angle"].values.astype(float)


def over_positions(
    dataset: xr.Dataset, panes: Sequence[Pane], title: str, y_label: str = "", **options: Any
) -> Picture:
    """A picture over the crank angle, or over time under a law of motion.

    Parameters
    ----------
    dataset : Dataset
        Over ``crank_angle``, or over ``time``.
    panes : sequence of Pane
    title : str
    y_label : str
        Y label of all axes along y; left out where they differ. Further fields of a picture are
        options.

    Returns
    -------
    Picture
    """
    timed = "time" in dataset.dims
    along = "Time (s)" if timed else "Crank angle (deg)"
    places = positions(dataset)[1]
    kind: Literal["number", "angle"] = "number" if timed else "angle"
    return Picture(panes, along, dataset, title, y_label, kind, places, **options)


def plot_motion(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw position, velocity and acceleration of sliders and points against the crank angle.

    Points of the crank, which go round in a circle, are left out, and more than four.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` result with points or sliders.
    ax : sequence of Axes, optional
        The user's, three for each of the points, in rows of positions, velocities and
        accelerations. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    points = drawn_points(dataset)[:MOST_POINTS]
    return draw(motion_picture(dataset, points), ax=ax)


def motion_picture(dataset: xr.Dataset, points: list[str]) -> Picture:
    """Rows of position, velocity and acceleration, with a pane for each of the points.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` result.
    points : list of str

    Returns
    -------
    Picture
    """
    over, (dataset, angles) = dataset, positions(dataset)
    lines = motion_lines(dataset, points)
    # Alphabetical, but for lines of sliders, which are last.
    ways = sorted({line.along for line in lines}, key=lambda way: (way == ITS_LINE, way))
    panes = []
    for row, (_, words, units) in enumerate(KINDS):
        unit = (reading.fitting_unit(np.concatenate([line.values[row] for line in lines]), units),)
        for column, point in enumerate(points):
            curves = tuple(
                Curve(
                    *(angles, line.values[row], style.series_line(ways.index(line.along), angles)),
                    f"along {line.along}",
                )
                for line in lines
                if line.point == point
            )
            label = words if column == 0 or style.is_narrow() else ""
            heading = point.replace("$", r"\$") if row == 0 or style.is_narrow() else ""
            spans = (ZERO,) if row else ()
            panes.append(Pane(label, curves, unit, heading, spans))
    layout = grid(3, len(points), MOTION_HEIGHT, sharex=True, narrow=min(len(points), 2))
    title = f"Motion of points {reading.conditions(over)}"
    return over_positions(over, panes, title, layout=layout)


# Line of the prescribed drive, which is the same for all engines.
PRESCRIBED: Look = {"color": "0.15", "lw": 1.2}
ENVELOPE: Look = {"color": MID_GREY, "lw": 0.9, "zorder": 1.5}
STOP: Look = {"color": MID_GREY, "lw": 0.9, "ls": ":", "zorder": 0.5}
SETTLED: Look = {"color": MID_GREY, "lw": 0.9, "ls": "--", "zorder": 1.2}
# Room beside the range of a speed that fluctuates, over that range.
_ROOM = 0.15
_PANELS: tuple[tuple[str, reading.Units, str], ...] = (
    ("motor_torque", ((1.0, "N m"), (1e3, "N mm")), "Motor\ntorque"),
    ("motor_power", reading.POWER_UNITS, "Motor\npower"),
    ("motor_current", ((1.0, "A"), (1e3, "mA")), "Motor\ncurrent"),
)
_ACCELERATION: reading.Units = ((1.0, "rad/s²"),)


@figure
def plot_law(dataset: xr.Dataset) -> Picture:
    """Draw angle, speed and acceleration of the crank over time.

    A dotted line is where the law ends.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` or ``Response`` result under a law of motion: ``crank_angle``,
        ``crank_speed_over_time`` and ``crank_acceleration`` over time.
    ax : sequence of Axes, optional
        Three of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    time, end = dataset["time"].values, float(dataset.attrs.get("run_up_time", np.inf))
    stop = (Span(end, end, STOP, "end of the law", upright=True),) if end < time[-1] else ()
    panes = [
        Pane(
            f"{what}\n",
            (Curve(time, dataset[name].values, PRESCRIBED),),
            units,
            spans=(ZERO, *stop),
        )
        for name, units, what in (
            ("crank_angle", ROTATION_UNITS, "Angle"),
            ("crank_speed_over_time", reading.crank_speed_units(dataset), "Speed"),
            ("crank_acceleration", _ACCELERATION, "Acceleration"),
        )
    ]
    return over_time(dataset, panes, f"Motion of the crank\n{reading.conditions(dataset)}")


@figure
def plot_residual(dataset: xr.Dataset) -> Picture:
    """Draw the deflection of each link after the crank has stopped, and its envelope.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result under a law that stops: ``deflection``, and
        ``residual_envelope`` about ``residual_middle`` (engine, time, link) in m; the first
        engine's envelope is drawn in grey.
    ax : sequence of Axes, optional
        The user's, one for each link that bends. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    after = dataset.sel(time=dataset["time"] >= float(dataset.attrs["run_up_time"]))
    time, panes = after["time"].values, []
    for link in reading.bending_links(dataset):
        own = after.sel(link=link)
        first = own.isel(engine=0)
        middle = first["residual_middle"].values
        edges = [
            Curve(time, middle + side * first["residual_envelope"].values, ENVELOPE, "envelope")
            for side in (-1.0, 1.0)
        ]
        what = f"{reading.link_label(dataset, link)}\ndeflection"
        curves = (*by_engine(own["deflection"], dataset), *edges)
        panes.append(Pane(what, curves, reading.LENGTH_UNITS, spans=(ZERO,)))
    title = f"Vibration after the stop\n{reading.run_title(dataset)}"
    layout = scales.time_layout(len(panes))
    return Picture(panes, "Time (s)", dataset, title, places=time, layout=layout)


@figure
def plot_motor(dataset: xr.Dataset) -> Picture:
    """Draw the crank's speed, and torque, power and current of the motor on its own shaft.

    Dashed lines are the least and the greatest speed of the rigid linkage's settled motion.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` or ``Response`` result under a motor: ``motor_speed``,
        ``motor_torque`` and ``motor_power`` over time, or (engine, time); ``motor_current`` of a
        DC motor.
    ax : sequence of Axes, optional
        The user's: three, or four of a DC motor. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    time, speed = dataset["time"].values, dataset["crank_speed_over_time"]
    runs = "engine" in dataset["motor_torque"].dims
    settled = "elastic_settled_speed" in dataset.attrs
    name = "settled, found directly" if settled else "rigid links"
    curves = [Curve(time, speed.values, PRESCRIBED | {"zorder": 1.5}, name if runs else "")]
    if runs:
        curves = by_engine(speed + dataset["crank_speed_fluctuation"], dataset) + curves
    spans, limits = [ZERO], None
    if "settled_crank_speed" in dataset:
        found = dataset["settled_crank_speed"].values
        words = "range once settled (rigid links)"
        spans += [Span(end, end, SETTLED, words) for end in (found.min(), found.max())]
    if settled:
        # How the speed fluctuates is to be seen, and not how far it is from zero.
        values = np.concatenate([curve.y for curve in curves])
        values = np.append(values, [span.low for span in spans])
        values = values[np.abs(values) > 0]
        room = _ROOM * float(np.ptp(values))
        limits = float(values.min()) - room, float(values.max()) + room
    units = reading.crank_speed_units(dataset)
    first = Pane("Crank\nspeed", curves, units, spans=spans, limits=limits)
    shown = [(what, dataset[name], units) for name, units, what in _PANELS if name in dataset]
    panes = [first]
    if runs:
        panes += engine_panes(dataset, shown)
    else:
        panes += [
            Pane(what, (Curve(time, values.values, PRESCRIBED),), units, spans=(ZERO,))
            for what, values, units in shown
        ]
    return over_time(dataset, panes, f"Crank and motor\n{reading.conditions(dataset)}")
