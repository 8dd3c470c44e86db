"""Moving pictures of a running linkage, its deflections enlarged."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.animation import FFMpegWriter
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from flexmech.errors import InputError
from flexmech.plots.animation_scene import DOTS_AN_INCH, FRAMES_A_SECOND, EnlargedMotion, Scene
from flexmech.plots.choose import chosen
from flexmech.plots.style import publication_style
from flexmech.types import StepProgress, silent

Pictures = Iterator[NDArray[np.uint8]]

# Of a GIF's palette: a few hues with their blends into white.
COLOURS = 128
NEARLY_WHITE = 240


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
        Of a ``Response`` result; m, s and rad.
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
    write = _writer(target)
    one = dataset.isel(engine=[-1]) if engine is None else chosen(dataset, engine=engine)
    motion = EnlargedMotion.of(one, enlargement)
    with publication_style():
        write(target, _pictures(motion, progress or silent))


def mp4_available() -> bool:
    """Whether MP4 files can be written, for which the program ffmpeg is needed."""
    return bool(FFMpegWriter.isAvailable())


def _writer(path: Path) -> Callable[[Path, Pictures], None]:
    suffix = path.suffix.lower()
    if suffix == ".gif":
        return _write_gif
    if suffix != ".mp4":
        raise InputError(f"{path}: an animation is written as .gif or .mp4, not {suffix!r}")
    if not mp4_available():
        raise InputError(f"{path}: MP4 needs the program ffmpeg, not found; install it or use .gif")
    return _write_mp4


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
