"""Pictures of the thresholds of the composite crank-rockers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from _composite_thresholds import (
    DAMPING_RATIO,
    FROZEN_SPEEDS,
    LAMINATES,
    LAYERS,
    RATIOS,
    SPEEDS,
    TURN,
    CaseMap,
    Scales,
)
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from papers._elamy_linkages import position_angles, published_case

from flexmech import plots

__all__ = ["draw_bands", "draw_frozen", "draw_thresholds"]

# Of closing damping ratios in percent.
LOW, HIGH = 0.1, 5.0
BAND, FIRST, GROWS = "#56B4E9", "#D55E00", "0.80"
OVER_LOWEST = "over the lowest natural frequency (-)"


def draw_bands(maps: Sequence[CaseMap]) -> Figure:
    """Bands over the speed: as wide as they are, as high as the damping ratio that closes them."""
    with plots.sheet(plots.grid(len(maps), 1, 1.35 * len(maps), sharex=True)) as drawn:
        for axes, found in zip(drawn.panels, maps, strict=True):
            firsts = {found.threshold(ratio) for ratio in RATIOS}
            for band in found.bands.to_dict("records"):
                colour = FIRST if band["lower"] in firsts else BAND
                axes.bar(
                    band["lower"],
                    100 * band["closing"] - LOW,
                    band["upper"] - band["lower"],
                    bottom=LOW,
                    align="edge",
                    color=colour,
                    edgecolor=colour,
                    linewidth=0.8,
                )
            for ratio in RATIOS:
                axes.axhline(100 * ratio, color=plots.MID_GREY, lw=0.6, ls=":", zorder=0)
            axes.set_yscale("log")
            axes.set_ylim(LOW, HIGH)
            axes.set_yticks([0.1, 0.2, 0.5, 1, 2, 5], ["0.1", "0.2", "0.5", "1", "2", "5"])
            axes.minorticks_off()
            axes.set_xlim(SPEEDS[0], SPEEDS[-1])
            axes.set_title(f"Case {found.case}", loc="left", fontsize=8)
        drawn.label_y("Damping ratio that closes a band (%)")
        drawn.label_x(f"Crank speed {OVER_LOWEST}", slice(-1, None))
        words = ", ".join(f"{100 * ratio:g}" for ratio in RATIOS)
        drawn.header(
            [
                Patch(color=FIRST, label=f"First band at a damping ratio of {words} %"),
                Patch(color=BAND, label="Other bands"),
            ],
            f"Bands of growth, drawn as wide as they are at {100 * DAMPING_RATIO:g} % of damping",
        )
    return drawn.figure


def draw_thresholds(maps: Sequence[CaseMap], scale: Scales) -> Figure:
    """Crank speed at which the first band opens over stacking, case and damping ratio."""
    looks = {LAYERS[0]: {}, LAYERS[1]: {"markerfacecolor": "white", "linestyle": ":"}}
    with plots.sheet(plots.grid(1, len(RATIOS), 2.8, sharey=True)) as drawn:
        for axes, ratio in zip(drawn.panels, RATIOS, strict=True):
            for found in maps:
                speed = found.lowest * found.threshold(ratio) * scale.over()
                style = plots.series_style(found.case - 1)
                look = {"color": style.color, "marker": style.marker, "markersize": 4.0}
                for layers, special in looks.items():
                    axes.plot(LAMINATES, speed[layers], **(look | {"lw": 1.0} | special))
            axes.set_title(f"Damping ratio {100 * ratio:g} %", fontsize=8)
            axes.set_yscale("log")
            axes.set_yticks([50, 100, 200, 500], ["50", "100", "200", "500"])
            axes.minorticks_off()
        drawn.label_x("Stacking")
        drawn.panels[0].set_ylabel("Crank speed of the first band (rad/s)")
        handles = [
            plots.line_handle(
                f"Case {found.case}",
                color=plots.series_style(found.case - 1).color,
                marker=plots.series_style(found.case - 1).marker,
                markersize=4.0,
            )
            for found in maps
        ]
        handles += [
            plots.line_handle(
                {LAYERS[0]: "Plies across the width", LAYERS[1]: "Plies through the thickness"}[n],
                **({"color": "black", "marker": "o", "markersize": 4.0} | special),
            )
            for n, special in looks.items()
        ]
        drawn.header(handles, "Composite crank-rockers: where the first band of growth opens")
    return drawn.figure


def draw_frozen(maps: Sequence[CaseMap]) -> Figure:
    """Natural frequencies at rest, and where frozen eigenvalues grow, over the crank angle."""
    degrees = np.degrees(TURN)
    layout = plots.grid(2, len(maps), 4.6, sharex=True, sharey="row")
    with plots.sheet(layout) as drawn:
        above, below = drawn.panels[: len(maps)], drawn.panels[len(maps) :]
        for upper, lower, found in zip(above, below, maps, strict=True):
            for mode in range(found.frequency.shape[1]):
                upper.plot(degrees, found.frequency[:, mode], **plots.series_line(mode))
            upper.set_title(f"Case {found.case}", fontsize=8)
            if (found.frozen > 0).any():
                lower.contourf(degrees, FROZEN_SPEEDS, found.frozen, [0, np.inf], colors=[GROWS])
                lower.contour(
                    degrees,
                    FROZEN_SPEEDS,
                    found.frozen,
                    [0],
                    colors=[plots.MID_GREY],
                    linewidths=0.8,
                )
            for band in found.bands.to_dict("records"):
                lower.axhspan(band["lower"], band["upper"], color=FIRST, lw=0.5)
            for axes in (upper, lower):
                plots.crank_angle_axis(axes, degrees)
                axes.set_xticks([0, 180, 360])
                for angle in np.degrees(position_angles(published_case(found.case))[[1, 3]]):
                    axes.axvline(angle, color=plots.MID_GREY, lw=0.6, ls=":")
            lower.set_ylim(0, FROZEN_SPEEDS[-1])
        above[0].set_ylim(0, None)
        above[0].set_ylabel("Natural frequency at rest\nover its lowest value (-)")
        below[0].set_ylabel("Crank speed over the\nlowest natural frequency (-)")
        for axes in below:
            axes.set_xlabel("Crank angle (deg)")
        drawn.header(
            [
                plots.series_handle(0, "Mode 1"),
                plots.series_handle(1, "Mode 2"),
                Patch(color=GROWS, label="A frozen eigenvalue grows"),
                Patch(color=FIRST, label="Bands of growth (Floquet)"),
                plots.line_handle(
                    "Transmission angle 90 deg", color=plots.MID_GREY, lw=0.6, ls=":"
                ),
            ],
            f"Frozen positions and the running linkage, damping ratio {100 * DAMPING_RATIO:g} %",
        )
    return drawn.figure
