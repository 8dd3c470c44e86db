"""The four pictures of ``flexmech frequencies``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.files import moved_into

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["DOTS_PER_INCH", "PICTURES", "write_pictures"]

PICTURES = ("frequencies.png", "speed_effect.png", "mode_shapes.png", "agreement.png")
DOTS_PER_INCH = 200


def write_pictures(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the pictures that the dataset has data for.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of moving frequencies. Without ``speed_effect`` there is no picture of it, with one
        engine none of the agreement.
    folder : Path
        The files appear there all together, after the last one is drawn.

    Returns
    -------
    list of Path
    """
    import matplotlib as mpl

    # No window is opened, with or without a screen.
    mpl.use("Agg")
    from flexmech import plots

    drawings = {"frequencies.png": plots.plot_frequencies}
    if "speed_effect" in dataset:
        drawings["speed_effect.png"] = plots.plot_speed_effect
    drawings["mode_shapes.png"] = plots.plot_mode_shapes
    if dataset.sizes["engine"] > 1:
        drawings["agreement.png"] = plots.plot_agreement
    with moved_into(folder) as temporary:
        for name, draw in drawings.items():
            draw(dataset).savefig(temporary / name, dpi=DOTS_PER_INCH)
    return [folder / name for name in drawings]
