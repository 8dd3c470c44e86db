"""Which transmission angles do the published crank-rockers have, and what does design give?

Elamy et al. 2023 compare four crank-rockers (Table 3, Figure 7). Cases 3 and 4 come from their
design equations, for 90 degrees plus or minus 20 and 30; the printed proportions are rounded to
two digits. The limits are set beside the printed ones, and a chart shows the crank length that
each pair of deviation and rocker angle gives.

    python scenarios/transmission_angle.py [--out results/transmission_angle]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import output_folder, save_pictures
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flexmech.linkages import FourBar, synthesize_crank_rocker
from flexmech.plots import plot_transmission_angle, publication_style
from flexmech.plots.style import new_figure

FloatArray = NDArray[np.float64]
TURN = np.radians(np.arange(361.0))
# Table 3: crank, coupler and rocker over the ground; limits printed in the text, in degrees.
BLANK = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
CASES = {
    "case 1": ((0.27, 0.83, 0.67), (58.26, 115.35)),
    "case 2": ((0.42, 1.00, 0.79), (35.65, 103.95)),
    "case 3": ((0.14, 0.90, 0.46), (70.0, 110.0)),
    "case 4": ((0.21, 0.91, 0.46), (60.0, 120.0)),
}
DESIGNS = {"case 3": (20.0, 100.0), "case 4": (30.0, 90.0)}


@dataclass(frozen=True)
class Outcome:
    """Limits of the transmission angle in degrees, by linkage."""

    limits: dict[str, tuple[float, float]]
    largest_gap: float


def published() -> dict[str, FourBar]:
    """Linkages of Table 3."""
    return {name: FourBar(1.0, *ratios) for name, (ratios, _) in CASES.items()}


def designed() -> dict[str, FourBar]:
    """Cases 3 and 4 by equations 11 to 17, not rounded."""
    return {
        f"{name} as designed": synthesize_crank_rocker(*np.radians(angles)).linkage()
        for name, angles in DESIGNS.items()
    }


def design_chart() -> Figure:
    """Crank over ground against deviation and rocker angle."""
    deviation, rocker_angle = np.linspace(5.0, 60.0, 56), np.linspace(40.0, 160.0, 121)
    grid = np.meshgrid(deviation, rocker_angle)
    possible = grid[1] > 90.0 - grid[0] + 0.5
    crank = np.full(grid[0].shape, np.nan)
    crank[possible] = synthesize_crank_rocker(*(np.radians(g[possible]) for g in grid)).crank
    with publication_style():
        figure = new_figure(3.6)
        axes = figure.subplots()
        lines = axes.contour(
            deviation, rocker_angle, crank, levels=np.arange(0.05, 0.55, 0.05), colors="#0072B2"
        )
        axes.clabel(lines, fmt="%.2f", fontsize=8)
        axes.plot(deviation, 90.0 - deviation, color="black", lw=1.2)
        axes.text(
            20.0,
            58.0,
            "no linkage: rocker angle below\nthe least transmission angle",
            ha="center",
            va="top",
            fontsize=8,
        )
        for name, (delta, theta) in DESIGNS.items():
            axes.plot(delta, theta, "o", color="#D55E00", markersize=4)
            axes.annotate(
                name, (delta, theta), (4, 4), textcoords="offset points", fontsize=8, bbox=BLANK
            )
        axes.set_xlabel("Greatest deviation of the transmission angle from 90 deg (deg)")
        axes.set_ylabel("Rocker angle at crank angle 0 (deg)")
        axes.set_title("Crank length over ground length")
    return figure


def main(out: Path | None = None) -> Outcome:
    """Print the limits and draw both pictures."""
    linkages = published() | designed()
    limits = {}
    for name, linkage in linkages.items():
        least, greatest = np.degrees(linkage.transmission_angle_limits())
        limits[name] = (float(least), float(greatest))
        printed = CASES.get(name)
        beside = f" (printed {printed[1][0]:g} to {printed[1][1]:g})" if printed else ""
        print(f"{name}: {least:.2f} to {greatest:.2f} deg{beside}")
    gap = max(
        abs(found - said)
        for name, (_, printed) in CASES.items()
        for found, said in zip(limits[name], printed, strict=True)
    )
    print(f"largest gap to the printed limits: {gap:.2f} deg")
    if out is not None:
        curves = {name: each.transmission_angle(TURN) for name, each in linkages.items()}
        pictures = {
            "transmission_angle.png": plot_transmission_angle(TURN, curves),
            "design_chart.png": design_chart(),
        }
        for path in save_pictures(pictures, out):
            print(path)
    return Outcome(limits, gap)


if __name__ == "__main__":
    main(output_folder(__doc__, "results/transmission_angle"))
