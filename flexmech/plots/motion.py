"""Points and sliders over the crank angle: position, velocity and acceleration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.plots import reading, style
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, grid
from flexmech.plots.picture import ZERO, Curve, Pane, Picture

# More columns are too narrow for the numbers of their axes; what is left out stands in the tables.
MOST_POINTS = 4
HEIGHT = 4.6
VELOCITIES: reading.Units = ((1.0, "m/s"), (1e3, "mm/s"))
ACCELERATIONS: reading.Units = ((1.0, "m/s²"), (1e3, "mm/s²"))
KINDS = (
    ("position", "Position", reading.LENGTH_UNITS),
    ("velocity", "Velocity", VELOCITIES),
    ("acceleration", "Acceleration", ACCELERATIONS),
)
"""What is known of a point: variable, words, and units."""
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
        Of a ``Kinematics`` result.

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
        Of a ``Kinematics`` result.
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
    dataset: xr.Dataset, panes: Sequence[Pane], title: str, y_label: str = ""
) -> Picture:
    """A picture over the crank angle, or over time under a law of motion.

    Parameters
    ----------
    dataset : Dataset
        Over ``crank_angle``, or over ``time``.
    panes : sequence of Pane
    title : str
    y_label : str
        Of all axes along y; left out where they differ.

    Returns
    -------
    Picture
    """
    timed = "time" in dataset.dims
    along = "Time (s)" if timed else "Crank angle (deg)"
    places = positions(dataset)[1]
    kind: Literal["number", "angle"] = "number" if timed else "angle"
    return Picture(panes, along, dataset, title, y_label, kind, places)


def plot_motion(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw position, velocity and acceleration of sliders and points against the crank angle.

    Points of the crank, which go round in a circle, are left out, and more than four.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Kinematics`` result with points or sliders.
    ax : sequence of Axes, optional
        The user's, three for each of the points, in rows of positions, velocities and
        accelerations. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    points = drawn_points(dataset)[:MOST_POINTS]
    layout = grid(3, len(points), HEIGHT, sharex=True, narrow=min(len(points), 2))
    return draw(motion_picture(dataset, points), layout, ax=ax)


def motion_picture(dataset: xr.Dataset, points: list[str]) -> Picture:
    """Rows of position, velocity and acceleration, with a pane for each of the points.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Kinematics`` result.
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
    return over_positions(over, panes, f"Motion of points {reading.conditions(over)}")
