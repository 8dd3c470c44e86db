"""One picture of an animation: the rigid linkage and the enlarged deflected one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle
from numpy.typing import NDArray

from flexmech.plots.reading import engine_label
from flexmech.plots.style import (
    FIGURE_WIDTH,
    LIGHT_GREY,
    MID_GREY,
    header_height,
    header_legend,
    new_figure,
    series_style,
    speed_label,
)
from flexmech.types import FloatArray

__all__ = ["DOTS_AN_INCH", "FRAMES_A_SECOND", "EnlargedMotion", "Picture", "Scene"]

Picture = NDArray[np.uint8]

MOST_FRAMES = 120
FRAMES_A_SECOND = 20
# Wide enough to read, small enough for a web page: about 640 pixels.
DOTS_AN_INCH = 90
# Largest displacement as drawn, as a fraction of the linkage's extent.
ENLARGED_TO = 0.1
# Places closer than this fraction of the extent are the same place.
SAME_PLACE = 1e-6
# Displacements below this fraction of the extent are not enlarged.
ROUND_OFF = 1e-10
# A digit's width, so that the title does not tremble while the numbers grow.
FIGURE_SPACE = "\N{FIGURE SPACE}"
JOINT: dict[str, Any] = {
    "ls": "",
    "marker": "o",
    "ms": 5,
    "mfc": "white",
    "mec": "0.25",
    "mew": 0.9,
}


@dataclass(frozen=True)
class EnlargedMotion:
    """What there is to draw, with the stored samples of the time shown.

    Parameters
    ----------
    time, angle : ndarray, shape (n,)
        In s and rad.
    rigid, deflected : ndarray, shape (n, link, station, 2)
        In m, the latter with enlarged displacements.
    frames : ndarray of int
        Samples that are drawn.
    traced : tuple of int
        Link and station whose path is drawn.
    trace_name, run_name : str
        What is traced and what is running, in words.
    enlargement : float
        Factor on the displacements.
    """

    time: FloatArray
    angle: FloatArray
    rigid: FloatArray
    deflected: FloatArray
    frames: NDArray[np.int64]
    traced: tuple[int, int]
    trace_name: str
    run_name: str
    enlargement: float

    @classmethod
    def of(cls, dataset: xr.Dataset, engine: int, enlargement: float | None) -> EnlargedMotion:
        """Take the last turn of one engine's run.

        Parameters
        ----------
        dataset : xarray.Dataset
            Of a response.
        engine : int
            Which of its engines.
        enlargement : float or None
            Factor on the displacements; a round one is chosen where it is None.

        Returns
        -------
        EnlargedMotion
        """
        angle = dataset["crank_angle"].values.astype(float)
        # Round-off must not lose the sample a full turn before the last one.
        shown = np.abs(angle[-1] - angle) <= 2 * np.pi * (1 + 1e-9)
        order = ("time", "link", "station", "component")
        rigid = dataset["rigid_position"].transpose(*order).values[shown].astype(float)
        elastic = dataset["displacement"].isel(engine=engine).transpose(*order).values[shown]
        if enlargement is None:
            enlargement = _round_enlargement(_extent(rigid), elastic)
        links = [str(name) for name in dataset["link"].values]
        link = links.index("coupler") if "coupler" in links else len(links) - 1
        probe = str(dataset["probe"].values[link])
        station = rigid.shape[2] // 2 if probe == "middle" else rigid.shape[2] - 1
        speed = speed_label(float(dataset.attrs["crank_speed"]))
        name = str(dataset.attrs["mechanism"])
        frames = _frames(angle[shown])
        seconds = float(np.ptp(dataset["time"].values[shown]))
        slower = len(frames) / FRAMES_A_SECOND / seconds if seconds > 0 else 1.0
        pace = f", {slower:.2g} times slower than real" if slower > 1.05 else ""
        return cls(
            time=dataset["time"].values.astype(float)[shown],
            angle=angle[shown],
            rigid=rigid,
            deflected=rigid + enlargement * elastic,
            frames=frames,
            traced=(link, station),
            trace_name=f"path of the {links[link]}'s {probe}",
            run_name=f"{name[:1].upper()}{name[1:]} at {speed}, "
            f"{engine_label(dataset, engine)}{pace}",
            enlargement=enlargement,
        )


def _frames(angle: FloatArray) -> NDArray[np.int64]:
    """Equally spaced samples up to the last one; a full turn's first is its last again."""
    last = angle.size - 1
    full_turn = abs(angle[-1] - angle[0]) > 2 * np.pi * (1 - 1e-6)
    step = max(1, -(-last // (MOST_FRAMES if full_turn else MOST_FRAMES - 1)))
    chosen = np.arange(last, 0 if full_turn else -1, -step)
    return chosen[::-1].astype(np.int64)


def _extent(rigid: FloatArray) -> float:
    """Largest diagonal over time of the box around the linkage, in m."""
    ends = rigid[:, :, [0, -1]].reshape(len(rigid), -1, 2)
    return float(np.hypot(*(ends.max(axis=1) - ends.min(axis=1)).T).max())


def _round_enlargement(extent: float, elastic: FloatArray) -> float:
    """1, 2 or 5 times a power of ten, at least 1: the nearest in ratio to what is wanted."""
    greatest = float(np.nanmax(np.hypot(elastic[..., 0], elastic[..., 1]), initial=0.0))
    if greatest <= ROUND_OFF * extent:
        return 1.0
    wanted = max(ENLARGED_TO * extent / greatest, 1.0)
    decade = 10.0 ** np.floor(np.log10(wanted))
    rounds = [float(round(step * decade)) for step in (1, 2, 5, 10)]
    return min(rounds, key=lambda value: abs(np.log(value / wanted)))


class Scene:
    """The picture: a ground drawn once, and what moves drawn on it for each frame.

    Parameters
    ----------
    motion : EnlargedMotion
    """

    def __init__(self, motion: EnlargedMotion) -> None:
        self._motion = motion
        extent = _extent(motion.rigid)
        n_links = motion.rigid.shape[1]
        blue, orange = series_style(0).color, series_style(1).color
        self._rigid = [Line2D([], [], color="0.65", lw=1.0, zorder=1) for _ in range(n_links)]
        self._trace = Line2D([], [], color=orange, lw=1.0, zorder=2, label=motion.trace_name)
        self._deflected = [Line2D([], [], color=blue, lw=2.2, zorder=3) for _ in range(n_links)]
        self._joints = Line2D([], [], zorder=4, **JOINT)
        self._rigid[0].set_label("rigid linkage")
        self._deflected[0].set_label(f"displacement enlarged {_times(motion.enlargement)}")
        self._ends = _joints(motion.rigid, extent)
        handles = [self._rigid[0], self._deflected[0], self._trace]
        figure, self._axes = _empty_picture(motion, handles)
        # Any: matplotlib leaves the methods of this canvas without types.
        self._canvas = cast(Any, FigureCanvasAgg(figure))
        _draw_ground(self._axes, motion.rigid, extent)
        self._clock = self._axes.set_title("time")
        self._moving = [*self._rigid, self._trace, *self._deflected, self._joints]
        for line in self._moving:
            self._axes.add_line(line)
        for artist in (*self._moving, self._clock):
            # Left out of the drawing of the ground.
            artist.set_animated(True)
        self._canvas.draw()
        self._ground = self._canvas.copy_from_bbox(figure.bbox)

    def picture(self, sample: int) -> Picture:
        """Pixels with everything moved to a sample; shape (height, width, 3)."""
        motion = self._motion
        rigid, deflected = motion.rigid[sample], motion.deflected[sample]
        for lines, links in ((self._rigid, rigid), (self._deflected, deflected)):
            for line, link in zip(lines, links, strict=True):
                line.set_data(link[:, 0], link[:, 1])
        link, station = motion.traced
        self._trace.set_data(*motion.deflected[: sample + 1, link, station].T)
        places = np.reshape([deflected[end] for end in self._ends], (-1, 2))
        self._joints.set_data(places[:, 0], places[:, 1])
        turned = round(float(np.degrees(motion.angle[sample]))) % 360
        angle = str(turned).rjust(3, FIGURE_SPACE)
        self._clock.set_text(f"time {motion.time[sample]:.4f} s    crank angle {angle}°")
        self._canvas.restore_region(self._ground)
        for artist in (*self._moving, self._clock):
            self._axes.draw_artist(artist)
        return np.array(self._canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()


def _times(factor: float) -> str:
    digits = f"{factor:,.0f}".replace(",", "\N{THIN SPACE}")
    return f"{digits if factor >= 1000 else f'{factor:.4g}'} times"


def _empty_picture(motion: EnlargedMotion, handles: list[Line2D]) -> tuple[Figure, Axes]:
    """Figure with limits that hold the whole motion, its legend and room for the title."""
    points = np.concatenate([motion.rigid, motion.deflected]).reshape(-1, 2)
    hub = np.hypot(*motion.rigid[0, 0, 0]) * np.array([[-1.0, -1.0], [1.0, 1.0]])
    points = np.concatenate([points, hub])
    room = 0.03 * float(np.ptp(points, axis=0).max())
    # Supports hang below.
    left, low = np.nanmin(points, axis=0) - [room, 2.5 * room]
    right, high = np.nanmax(points, axis=0) + room
    title_height = 0.35
    tall = FIGURE_WIDTH * (high - low) / (right - left)
    # Codecs of moving pictures want an even number of pixels.
    height = min(max(tall, 2.0), 5.2) + title_height + header_height([*handles], motion.run_name)
    figure = new_figure(2 * round(height * DOTS_AN_INCH / 2) / DOTS_AN_INCH)
    figure.set_dpi(DOTS_AN_INCH)
    figure.set_figwidth(2 * round(FIGURE_WIDTH * DOTS_AN_INCH / 2) / DOTS_AN_INCH)
    axes = figure.add_subplot()
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal")
    axes.set_axis_off()
    header_legend(figure, [*handles], motion.run_name)
    return figure, axes


def _joints(rigid: FloatArray, extent: float) -> list[tuple[int, int]]:
    """Link and station of one end at each joint: where ends meet or the ground holds one."""
    chosen: list[tuple[int, int]] = []
    ends = [(link, station) for link in range(rigid.shape[1]) for station in (0, -1)]
    for link, station in ends:
        path = rigid[:, link, station]
        apart = [np.abs(path - rigid[:, other, end]).max() for other, end in ends]
        together = [end for end, far in zip(ends, apart, strict=True) if far <= SAME_PLACE * extent]
        held = bool(np.ptp(path, axis=0).max() <= SAME_PLACE * extent) and len(rigid) > 1
        if together[0] == (link, station) and (held or len(together) > 1):
            chosen.append((link, station))
    return chosen


def _draw_ground(axes: Axes, rigid: FloatArray, extent: float) -> None:
    """Hatched supports under the ends that stay in place, and a hub on its shaft."""
    ends = rigid[:, :, [0, -1]].reshape(len(rigid), -1, 2)
    still = np.ptp(ends, axis=0).max(axis=-1) <= SAME_PLACE * extent
    places = [place for place, stays in zip(ends[0], still, strict=True) if stays]
    hub_radius = float(np.hypot(*rigid[0, 0, 0]))
    if not still[0]:
        # By convention the first link is the driven one, on a shaft at the ground's origin.
        axes.add_patch(Circle((0, 0), hub_radius, fc=LIGHT_GREY, ec=MID_GREY, lw=0.7, zorder=0.5))
        axes.plot(0, 0, zorder=4, **JOINT)
        places.append(np.zeros(2))
    deep = max(0.035 * extent, 0.0 if still[0] else 1.4 * hub_radius)
    half = 0.6 * deep
    for x, y in places:
        corners = [(x, y), (x - half, y - deep), (x + half, y - deep)]
        axes.add_patch(Polygon(corners, fc="white", ec="0.25", lw=0.9, zorder=0.8))
        ground = Rectangle((x - 1.7 * half, y - 1.5 * deep), 3.4 * half, 0.5 * deep)
        ground.set(facecolor="none", edgecolor="0.25", linewidth=0.0, hatch="////////", zorder=0.8)
        axes.add_patch(ground)
        axes.plot([x - 1.7 * half, x + 1.7 * half], [y - deep] * 2, color="0.25", lw=0.9)
