"""What the scenarios share: models, the folder of ``--out``, and how pictures are saved."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from flexmech import Mechanism, load_mechanism
from flexmech.arrays import FloatArray

__all__ = [
    "FOUR_BARS",
    "MODELS",
    "SPEEDS",
    "four_bar",
    "mean_over_turn",
    "output_folder",
    "save_pictures",
]

MODELS = Path(__file__).parents[1] / "models"
FOUR_BARS = {
    "steel": "Steel four-bar",
    "aluminium": "Aluminium four-bar",
    "moist_composite": "Dry composite four-bar",
}
"""What runs at these speeds in light machines: both of Kumar & Chandrakar, and one of carbon and
epoxy of a like size."""
SPEEDS = np.array([0.0, 10.0, 20.0])
"""Crank speeds of Kumar & Chandrakar in rad/s."""
DOTS_PER_INCH = 200
"""Of the pictures: thin lines stay sharp on a screen of twice the usual density."""


def four_bar(name: str) -> Mechanism:
    """Load one of ``FOUR_BARS``, which have room temperature and no water in them."""
    return load_mechanism(MODELS / f"{name}_fourbar.toml")


def output_folder(description: str | None, default: str) -> Path:
    """Read ``--out`` from the command line; the description's first line is the help."""
    parser = argparse.ArgumentParser(description=(description or "").strip().partition("\n")[0])
    parser.add_argument(
        "--out", type=Path, default=Path(default), help="folder for the pictures (%(default)s)"
    )
    folder: Path = parser.parse_args().out
    return folder


def save_pictures(figures: Mapping[str, Figure], folder: Path) -> None:
    """Write figures as PNG files by name without the ending, and tell which."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png", dpi=DOTS_PER_INCH)
    print("pictures: " + ", ".join(str(folder / f"{name}.png") for name in figures))


def mean_over_turn(values: FloatArray) -> FloatArray:
    """Root mean square over the first axis, whose last entry is the first one again."""
    return np.asarray(np.sqrt(np.mean(values[:-1] ** 2, axis=0)))
