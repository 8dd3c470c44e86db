"""The pictures of ``flexmech frequencies``, and how pictures become files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.files import moved_into

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = [
    "DOTS_PER_INCH",
    "PICTURES",
    "file_lines",
    "save_drawings",
    "without_windows",
    "write_pictures",
]

PICTURES = (
    "frequencies.png",
    "speed_effect.png",
    "vibration_effect.png",
    "damping.png",
    "mode_shapes.png",
    "agreement.png",
)
DOTS_PER_INCH = 200


def write_pictures(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the pictures that the dataset has data for.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of moving frequencies. There are pictures of ``speed_effect``, of
        ``quasi_static_frequency``, of ``strain_energy_damping`` and of two engines'
        agreement only where it has them.
    folder : Path
        The files appear there all together, after the last one is drawn.

    Returns
    -------
    list of Path
    """
    without_windows()
    from flexmech import plots

    drawings = {"frequencies.png": plots.plot_frequencies}
    if "speed_effect" in dataset:
        drawings["speed_effect.png"] = plots.plot_speed_effect
    if "quasi_static_frequency" in dataset:
        drawings["vibration_effect.png"] = plots.plot_vibration_effect
    if "strain_energy_damping" in dataset:
        drawings["damping.png"] = plots.plot_modal_damping
    drawings["mode_shapes.png"] = plots.plot_mode_shapes
    if dataset.sizes["engine"] > 1:
        drawings["agreement.png"] = plots.plot_agreement
    return save_drawings(drawings, dataset, folder)


def without_windows() -> None:
    """Let matplotlib open no window, with or without a screen."""
    import matplotlib as mpl

    mpl.use("Agg")


def save_drawings(
    drawings: Mapping[str, Callable[[xr.Dataset], Figure]], dataset: xr.Dataset, folder: Path
) -> list[Path]:
    """Draw a dataset and write all the pictures, or none.

    Parameters
    ----------
    drawings : mapping
        What draws, by the name of the file.
    dataset : xarray.Dataset
    folder : Path
        Made if it does not exist.

    Returns
    -------
    list of Path
        In the order of the drawings.

    Raises
    ------
    InputError
        If writing fails.
    """
    with moved_into(folder) as temporary:
        for name, draw in drawings.items():
            draw(dataset).savefig(temporary / name, dpi=DOTS_PER_INCH)
    return [folder / name for name in drawings]


def file_lines(folder: Path, files: Iterable[Path], known: Iterable[str]) -> list[str]:
    """Name the files of a run, and those that lie beside them from an earlier one.

    Parameters
    ----------
    folder : Path
    files : iterable of Path
        Of this run.
    known : iterable of str
        Names that a run can write and need not.

    Returns
    -------
    list of str
        One line or two.
    """
    files = list(files)
    written = {file.name for file in files}
    stale = [name for name in known if name not in written and (folder / name).exists()]
    lines = ["files: " + ", ".join(str(file) for file in files)]
    if stale:
        lines.append(f"from an earlier run, not of this one: {', '.join(stale)}")
    return lines
