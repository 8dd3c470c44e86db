"""The pictures and the animation of ``flexmech response``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.cli.pictures import save_drawings, without_windows
from flexmech.cli.progress import Progress
from flexmech.files import moved_into

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["ANIMATIONS", "PICTURES", "write_animations", "write_pictures"]

PICTURES = ("response.png", "forces.png", "spectrum.png", "spectrogram.png")
ANIMATIONS = ("animation.gif", "animation.mp4")


def write_pictures(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the pictures that the dataset has data for.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response. Without ``spectrogram`` there is no picture of it.
    folder : Path
        The files appear there all together, after the last one is drawn.

    Returns
    -------
    list of Path
    """
    without_windows()
    from flexmech import plots

    drawings = {
        "response.png": plots.plot_response,
        "forces.png": plots.plot_forces,
        "spectrum.png": plots.plot_spectrum,
    }
    if "spectrogram" in dataset:
        drawings["spectrogram.png"] = plots.plot_spectrogram
    return save_drawings(drawings, dataset, folder)


def write_animations(
    dataset: xr.Dataset, folder: Path, progress: Progress | None = None
) -> list[Path]:
    """Write the animation as a GIF, and as an MP4 where ffmpeg exists.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a response.
    folder : Path
        The files appear there together, after the last one is written.
    progress : callable, optional
        Called with the name of the file, the frames done and the frames to do.

    Returns
    -------
    list of Path
    """
    without_windows()
    from flexmech import plots

    names = ANIMATIONS if plots.mp4_available() else ANIMATIONS[:1]
    with moved_into(folder) as temporary:
        for name in names:
            plots.write_animation(dataset, temporary / name, progress=_labelled(progress, name))
    return [folder / name for name in names]


def _labelled(progress: Progress | None, name: str) -> Callable[[int, int], None] | None:
    if progress is None:
        return None
    return lambda done, total: progress(name, done, total)
