"""Which transmission angles do the published crank-rockers have, and what does design give?

Elamy et al. 2023 compare four crank-rockers (Table 3, Figure 7). Cases 3 and 4 come from their
design equations, for 90 degrees plus or minus 20 and 30; the printed proportions are rounded to
two digits. The limits are set beside the printed ones, each linkage is asked what it was
designed for, and a chart shows the crank length that each pair of deviation and rocker angle
gives.

    python scenarios/transmission_angle.py [--out results/transmission_angle]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from _common import output_folder, save_pictures
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from papers._elamy_linkages import published_case

from flexmech import FourBar, plots, synthesize_crank_rocker
from flexmech.arrays import FloatArray
from flexmech.linkages import TransmissionDesign, time_ratio, transmission_design

TURN = np.radians(np.arange(361.0))
# Limits of the transmission angle as printed in section 5.1, in degrees.
PRINTED = {
    "case 1": (58.26, 115.35),
    "case 2": (35.65, 103.95),
    "case 3": (70.0, 110.0),
    "case 4": (60.0, 120.0),
}
# Deviation and rocker angle in degrees.
DESIGNS = {"case 3": (20.0, 100.0), "case 4": (30.0, 90.0)}
# "The recommended transmission angle is 90 +- 50 deg" (section 2.1).
RECOMMENDED = (np.radians(40.0), np.radians(140.0))
LEAST_ROCKER_ANGLE, LARGEST_DEVIATION = 25.0, 60.0


@dataclass(frozen=True)
class Outcome:
    """What was found of each linkage, by its name.

    Parameters
    ----------
    limits : dict of str to tuple of float
        Least and greatest transmission angle in degrees.
    designs : dict of str to TransmissionDesign
        What the linkage's proportions are the answer to.
    largest_gap : float
        Greatest difference to the printed limits, in degrees.
    """

    limits: dict[str, tuple[float, float]]
    designs: dict[str, TransmissionDesign]
    largest_gap: float


def main(out: Path) -> Outcome:
    """Print the limits, draw the transmission angles and the design chart.

    Parameters
    ----------
    out : Path
        Folder for the pictures.

    Returns
    -------
    Outcome
    """
    linkages = published() | designed()
    limits = {}
    for name, linkage in linkages.items():
        least, greatest = np.degrees(linkage.transmission_angle_limits())
        limits[name] = (float(least), float(greatest))
    gaps = [np.abs(np.subtract(limits[name], PRINTED[name])).max() for name in PRINTED]
    outcome = Outcome(
        limits=limits,
        designs={name: transmission_design(linkage) for name, linkage in linkages.items()},
        largest_gap=float(max(gaps)),
    )
    _report(linkages, outcome)
    figures = {"transmission_angle": _draw_angles(linkages), "design_chart": design_chart()}
    save_pictures(figures, out)
    return outcome


def published() -> dict[str, FourBar]:
    """Linkages of Table 3."""
    return {name: published_case(int(name.removeprefix("case "))) for name in PRINTED}


def designed() -> dict[str, FourBar]:
    """Cases 3 and 4 by equations 11 to 17, not rounded."""
    return {
        f"{name} as designed": synthesize_crank_rocker(*np.radians(angles)).linkage()
        for name, angles in DESIGNS.items()
    }


def _draw_angles(linkages: dict[str, FourBar]) -> Figure:
    angles = [linkage.transmission_angle(TURN) for linkage in linkages.values()]
    return plots.plot_transmission_angle(
        xr.Dataset(
            {"transmission_angle": (("linkage", "crank_angle"), angles)},
            coords={"linkage": list(linkages), "crank_angle": TURN},
            attrs={
                "wanted_least": RECOMMENDED[0],
                "wanted_greatest": RECOMMENDED[1],
                "wanted_label": "recommended range",
            },
        )
    )


def design_chart() -> Figure:
    """Crank over ground against deviation and rocker angle."""
    deviation, rocker_angle, crank = _crank_lengths()
    with plots.sheet(plots.grid(1, 1, 3.6)) as drawn:
        (axes,) = drawn.panels
        lines = axes.contour(
            deviation,
            rocker_angle,
            crank,
            levels=np.arange(0.05, 0.57, 0.05),
            colors=plots.series_style(0).color,
            linewidths=1.0,
        )
        axes.clabel(lines, fmt="%.2f", fontsize=8)
        axes.plot(deviation, 90.0 - deviation, color="black", lw=1.2)
        axes.set_ylim(LEAST_ROCKER_ANGLE, rocker_angle[-1])
        _mark_designs(axes)
        axes.set_xlabel("Greatest deviation of the transmission angle from 90 deg (deg)")
        axes.set_ylabel("Rocker angle at crank angle 0 (deg)")
        axes.set_title("Crank length over ground length")
    return drawn.figure


def _crank_lengths() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Deviations and rocker angles in degrees, and L2 over both: not a number where none is."""
    deviation = np.linspace(5.0, LARGEST_DEVIATION, 111)
    rocker_angle = np.linspace(LEAST_ROCKER_ANGLE, 160.0, 271)
    across, up = np.meshgrid(deviation, rocker_angle)
    possible = up > 90.0 - across + 1e-6
    crank = np.full(across.shape, np.nan)
    crank[possible] = synthesize_crank_rocker(
        np.radians(across[possible]), np.radians(up[possible])
    ).crank
    return deviation, rocker_angle, crank


def _mark_designs(axes: Axes) -> None:
    """The two published designs, and where there are none."""
    axes.text(
        20.0,
        58.0,
        "no linkage: rocker angle below\nthe least transmission angle",
        ha="center",
        va="top",
        fontsize=8,
    )
    for name, (deviation, rocker_angle) in DESIGNS.items():
        axes.plot(deviation, rocker_angle, "o", color=plots.series_style(1).color, markersize=4)
        axes.annotate(
            name,
            (deviation, rocker_angle),
            (-4, -4),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=8,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
        )


def _report(linkages: dict[str, FourBar], outcome: Outcome) -> None:
    print("transmission angle; greatest deviation from 90 deg; rocker at crank angle 0; imbalance")
    print("L3^2 + L4^2 - L2^2 - 1, zero by equation 11; time ratio of the rocker's strokes")
    for name, linkage in linkages.items():
        (least, greatest), design = outcome.limits[name], outcome.designs[name]
        printed = PRINTED.get(name)
        beside = f" (printed {printed[0]:g} to {printed[1]:g})" if printed else ""
        deviation, rocker_angle = np.degrees([design.deviation, design.rocker_angle])
        print(
            f"  {name}: {least:.2f} to {greatest:.2f} deg{beside}; {deviation:.2f} deg; "
            f"{rocker_angle:.2f} deg; {round(design.imbalance, 12) + 0.0:+.4f}; "
            f"{time_ratio(linkage):.4f}"
        )
    print(f"largest gap to the printed limits: {outcome.largest_gap:.2f} deg")


if __name__ == "__main__":
    main(output_folder(__doc__, "results/transmission_angle"))
