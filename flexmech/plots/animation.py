"""Moving pictures of a running linkage, its deflections enlarged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.animation import FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from PIL import Image

from flexmech.arrays import FloatArray, StepProgress, silent
from flexmech.errors import InputError
from flexmech.plots import reading, style
from flexmech.plots.drawn_linkage.figures import part_handles
from flexmech.plots.drawn_linkage.sketch import RIGID, LinkageSketch
from flexmech.plots.drawn_linkage.symbols import (
    SAME_PLACE,
    LinkageParts,
    add_symbols,
    extent_of,
    move_symbols,
    parts_of,
)
from flexmech.plots.layout import grid, height_of, round_enlargement, sheet
from flexmech.plots.style import Look, line_handle, publication_style, series_style

# As many pictures as make a film of six seconds, which nobody waits for too long.
MOST_FRAMES, FRAMES_A_SECOND = 120, 20
# Wide enough to read, small enough for a web page: about 640 pixels.
DOTS_AN_INCH = 90
# Height of the line with time and crank angle, in inches: letters of 9 points and room around
# them.
TITLE_HEIGHT = 0.35
# Marks of joints over those of a figure: links are drawn nearly twice as wide.
JOINT_SIZE = 1.4
# Largest displacement as drawn over the linkage's extent: seen at once, and the linkage is still
# itself.
ENLARGED_TO = 0.1
# A digit's width, so that the title does not tremble while the numbers grow.
FIGURE_SPACE = "\N{FIGURE SPACE}"

Pictures = Iterator[NDArray[np.uint8]]

# Colours of a GIF's palette, which may have 256: a few hues with their blends into white take no
# more.
COLOURS = 128
# Level of 255: entries of the palette that are lighter throughout are paper; the lightest
# grey is darker.
NEARLY_WHITE = 240


@dataclass(frozen=True)
class EnlargedMotion:
    """Everything that is drawn, with the stored samples of the time shown.

    Parameters
    ----------
    time, angle : ndarray, shape (n,)
        In s and rad.
    rigid, deflected : ndarray, shape (n, link, station, 2)
        In m, the latter with enlarged displacements.
    parts : LinkageParts
        What belongs to the linkage besides its links.
    path : ndarray, shape (n, 2)
        Places of the point whose path is drawn, in m, its displacement as it is.
    trace_name, run_name : str
        What is traced and what is running, in words.
    enlargement : float
        Factor on the displacements.
    """

    time: FloatArray
    angle: FloatArray
    rigid: FloatArray
    deflected: FloatArray
    parts: LinkageParts
    path: FloatArray
    trace_name: str
    run_name: str
    enlargement: float

    @classmethod
    def of(cls, dataset: xr.Dataset, enlargement: float | None) -> EnlargedMotion:
        """Take the last turn of the first engine's run.

        Parameters
        ----------
        dataset : xarray.Dataset
            Dataset of a response.
        enlargement : float or None
            Factor on the displacements; a round one is chosen where it is None.

        Returns
        -------
        EnlargedMotion
        """
        if "frame_time" in dataset.dims:
            # A stored run holds the places of some samples of this turn alone.
            names = {"frame_time": "time", "frame_angle": "crank_angle"}
            dataset = dataset.drop_dims("time").rename(names)
        angle = reading.values_of(dataset["crank_angle"], "time")
        # Round-off must not lose the sample a full turn before the last one.
        shown = np.abs(angle[-1] - angle) <= 2 * np.pi * (1 + 1e-9)
        turn = dataset.isel(engine=0, time=shown)
        order = ("time", "link", "station", "component")
        rigid = reading.values_of(turn["rigid_position"], *order)
        elastic = reading.values_of(turn["displacement"], *order)
        if enlargement is None:
            enlargement = round_enlargement(elastic, extent_of(rigid), ENLARGED_TO)
        links = reading.names_of(turn, "link")
        path, traced = _true_path(turn, rigid + elastic, links)
        run = f"{reading.mechanism_name(dataset)} at {reading.speed_text(dataset)}"
        return cls(
            time=turn["time"].values.astype(float),
            angle=angle[shown],
            rigid=rigid,
            deflected=rigid + enlargement * elastic,
            parts=parts_of(dataset, rigid, _at_rest(rigid)),
            path=path,
            trace_name=f"true path of the {traced}",
            run_name=f"{run}, {reading.engine_label(dataset)}",
            enlargement=enlargement,
        )

    @property
    def frames(self) -> NDArray[np.int64]:
        """Samples drawn, equally spaced up to the last one; a full turn's first is its last."""
        last = self.angle.size - 1
        full_turn = abs(self.angle[-1] - self.angle[0]) > 2 * np.pi * (1 - 1e-6)
        step = max(1, -(-last // (MOST_FRAMES if full_turn else MOST_FRAMES - 1)))
        return np.arange(last, 0 if full_turn else -1, -step)[::-1].astype(np.int64)

    @property
    def title(self) -> str:
        """Name of the running mechanism, and how much slower than real it is shown."""
        seconds = float(np.ptp(self.time))
        slower = self.frames.size / FRAMES_A_SECOND / seconds if seconds > 0 else 1.0
        digits = f"{slower:.2g}" if slower < 100 else f"{float(f'{slower:.2g}'):.0f}"
        pace = f", {digits} times slower than real" if slower > 1.05 else ""
        return self.run_name + pace


def _true_path(turn: xr.Dataset, places: FloatArray, links: list[str]) -> tuple[FloatArray, str]:
    """Places of the coupler point, of the coupler's middle or of an arm's tip, and its name.

    The coupler point is carried by the straight line between the coupler's pins.

    Parameters
    ----------
    turn : Dataset
    places : ndarray, shape (n, link, station, 2)
        Places of the deflected links in m.
    links : list of str

    Returns
    -------
    ndarray, shape (n, 2)
    str
    """
    link = links.index("coupler") if "coupler" in links else len(links) - 1
    if "coupler_point_distance" in turn.attrs:
        start, end = places[:, link, 0], places[:, link, -1]
        along = np.arctan2(*(end - start).T[::-1]) + turn.attrs["coupler_point_angle"]
        away = np.stack([np.cos(along), np.sin(along)], axis=-1)
        return start + turn.attrs["coupler_point_distance"] * away, "coupler point"
    probe = str(turn["probe"].values[link])
    station = places.shape[2] // 2 if probe == "middle" else -1
    return places[:, link, station], f"{links[link]}'s {probe}"


def _at_rest(rigid: FloatArray) -> NDArray[np.bool_]:
    """Ends of links that stay in place; a single sample shows none."""
    ends = rigid[:, :, [0, -1]]
    rests = np.ptp(ends, axis=0).max(axis=-1) <= SAME_PLACE * extent_of(ends)
    return np.asarray(rests & (len(ends) > 1))


class Scene:
    """The picture: a ground drawn once, and what moves drawn on it for each frame.

    Parameters
    ----------
    motion : EnlargedMotion
    """

    def __init__(self, motion: EnlargedMotion) -> None:
        self._motion = motion
        blue, orange = series_style(0).color, series_style(1).color
        times = f"{motion.enlargement:.4g}"
        if motion.enlargement >= 1000:
            times = f"{motion.enlargement:,.0f}".replace(",", "\N{THIN SPACE}")
        enlarged = f"displacement enlarged {times} times"
        sketch = LinkageSketch(
            motion.rigid[0], motion.parts, joint_size=JOINT_SIZE, travel=motion.rigid
        )
        self._rigid = _lines(sketch, RIGID | {"zorder": 1})
        self._trace = Line2D([], [], label=motion.trace_name, color=orange, lw=1.0, zorder=2)
        self._deflected = _lines(sketch, {"color": blue, "lw": 2.2, "zorder": 2.1})
        self._point = Line2D([], [], color="black", marker="o", ms=3.5, ls="", zorder=5)
        handles = [
            line_handle("rigid linkage", **RIGID),
            line_handle(enlarged, color=blue, lw=2.2),
            self._trace,
            *part_handles(sketch),
        ]
        self._open(sketch, handles)

    def _open(self, sketch: LinkageSketch, handles: list[Artist]) -> None:
        """Draw what does not move, with room for the whole motion, the legend and the title."""
        motion = self._motion
        shown = [motion.rigid, motion.deflected, motion.path]
        for sample in motion.frames:
            here = LinkageSketch(motion.deflected[sample], motion.parts).on_links()
            shown += [symbol.places for symbol in here]
        sketch = replace(sketch, around=np.concatenate([one.reshape(-1, 2) for one in shown]))
        limits = sketch.limits(np.empty((0, 2)))
        height = height_of(limits, style.figure_width(), 2.0, 5.2) + TITLE_HEIGHT
        with sheet(grid(1, 1, height)) as drawn:
            drawn.header(handles, motion.title)
        figure, (self._axes,) = drawn.figure, drawn.panels
        # Codecs of moving pictures want an even number of pixels.
        figure.set_dpi(DOTS_AN_INCH)
        pixels = 2 * np.round(figure.get_size_inches() * DOTS_AN_INCH / 2)
        figure.set_size_inches(*(pixels / DOTS_AN_INCH))
        sketch.frame(self._axes, limits)
        sketch.draw_ground(self._axes)
        self._on_links = add_symbols(self._axes, sketch.on_links())
        self._clock = self._axes.set_title("time")
        lines = [*self._rigid, self._trace, *self._deflected, self._point]
        for line in lines:
            self._axes.add_line(line)
        moving = [*lines, *self._on_links]
        self._moving = [*sorted(moving, key=lambda artist: artist.get_zorder()), self._clock]
        for artist in self._moving:
            # Left out of the drawing of the ground.
            artist.set_animated(True)
        # Any: matplotlib leaves the methods of this canvas without types.
        self._canvas = cast(Any, FigureCanvasAgg(figure))
        self._canvas.draw()
        self._ground = self._canvas.copy_from_bbox(figure.bbox)

    def picture(self, sample: int) -> NDArray[np.uint8]:
        """Pixels with everything moved to a sample; shape (height, width, 3)."""
        motion = self._motion
        rigid, deflected = motion.rigid[sample], motion.deflected[sample]
        for lines, links in ((self._rigid, rigid), (self._deflected, deflected)):
            for line, link in zip(lines, links, strict=True):
                line.set_data(*link.T)
        self._trace.set_data(*motion.path[: sample + 1].T)
        self._point.set_data(*motion.path[sample : sample + 1].T)
        move_symbols(self._on_links, LinkageSketch(deflected, motion.parts).on_links())
        turned = round(float(np.degrees(motion.angle[sample]))) % 360
        angle = str(turned).rjust(3, FIGURE_SPACE)
        self._clock.set_text(f"time {motion.time[sample]:.4f} s    crank angle {angle}°")
        self._canvas.restore_region(self._ground)
        for artist in self._moving:
            self._axes.draw_artist(artist)
        return np.array(self._canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()


def _lines(sketch: LinkageSketch, look: Look) -> list[Line2D]:
    """One line a link."""
    return [Line2D([], [], **one) for one in sketch.link_looks(look)]


def write_animation(
    dataset: xr.Dataset,
    path: str | Path,
    *,
    engine: str | None = None,
    enlargement: float | None = None,
    progress: StepProgress | None = None,
) -> None:
    """Write a moving picture of the last revolution of a run, as a GIF or an MP4.

    The undeformed linkage is grey, the deflected one blue, with its elastic displacements
    enlarged as the legend says. The path of the coupler point (else of the coupler's middle, or
    of an arm's tip) is drawn as far as it has got, with displacements as they are. Frames are
    stored samples, at equal intervals and at most 120: a vibration with less than two frames a
    period shows a wrong period, though right amplitudes.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result; m, s and rad.
    path : str or Path
        File to write, ending in ``.gif`` or ``.mp4``; an existing file is overwritten.
    engine : str, optional
        Name of the engine whose motion is drawn. Default the last one.
    enlargement : float, optional
        Factor on the elastic displacements, positive. Default a round number that makes the
        greatest of them about a tenth of the linkage's extent.
    progress : callable, optional
        Called as ``progress(frames_done, frames)`` after each frame.

    Raises
    ------
    InputError
        If the dataset has no such engine, the enlargement is not positive, the file is
        neither GIF nor MP4, or an MP4 is asked for without ffmpeg.
    """
    if enlargement is not None and not (np.isfinite(enlargement) and enlargement > 0):
        raise InputError(f"enlargement must be a positive number, not {enlargement:g}")
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in (".gif", ".mp4"):
        raise InputError(f"{target}: an animation is written as .gif or .mp4, not {kind!r}")
    if kind == ".mp4" and not mp4_available():
        raise InputError(
            f"{target}: MP4 needs the program ffmpeg, not found; install it or use .gif"
        )
    one = dataset.isel(engine=[-1]) if engine is None else reading.chosen(dataset, engine=engine)
    motion = EnlargedMotion.of(one, enlargement)
    write = _write_gif if kind == ".gif" else _write_mp4
    with publication_style():
        write(target, _pictures(motion, progress or silent))


def mp4_available() -> bool:
    """Whether MP4 files can be written, for which the program ffmpeg is needed."""
    return bool(FFMpegWriter.isAvailable())


def _write_gif(path: Path, pictures: Pictures) -> None:
    images = [Image.fromarray(picture) for picture in pictures]
    # One palette for all frames, from the one with the whole path: a palette a frame takes
    # most of the time, and colours flicker.
    coloured = images[-1].quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE)
    entries = np.reshape(coloured.getpalette() or [], (-1, 3))
    # Each entry is the mean of similar colours: paper must be white all the same. Pillow
    # looks up the nearest entry roughly, so none other may be left near white.
    entries[entries.min(axis=1) >= NEARLY_WHITE] = 255
    entries[np.argmax(entries.sum(axis=1))] = 255
    palette = Image.new("P", (1, 1))
    palette.putpalette(entries.ravel().tolist())
    frames = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    pause = round(1000 / FRAMES_A_SECOND)
    frames[0].save(path, "GIF", save_all=True, append_images=frames[1:], duration=pause, loop=0)


def _write_mp4(path: Path, pictures: Pictures) -> None:
    """Hand the pictures to matplotlib's writer, each as the only content of a figure."""
    first = next(pictures)
    height, width = first.shape[:2]
    screen = Figure(figsize=(width / DOTS_AN_INCH, height / DOTS_AN_INCH), dpi=DOTS_AN_INCH)
    shown = screen.figimage(first)
    writer = FFMpegWriter(fps=FRAMES_A_SECOND)
    with writer.saving(screen, str(path), DOTS_AN_INCH):
        writer.grab_frame()
        for picture in pictures:
            shown.set_data(picture)
            writer.grab_frame()


def _pictures(motion: EnlargedMotion, progress: StepProgress) -> Pictures:
    scene = Scene(motion)
    for done, sample in enumerate(motion.frames, start=1):
        yield scene.picture(int(sample))
        progress(done, len(motion.frames))
