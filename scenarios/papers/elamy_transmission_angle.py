"""Which transmission angles do the published crank-rockers have, and what does design give?

Elamy et al. 2023 compare four crank-rockers (Table 3, Figure 7). Cases 3 and 4 come from their
design equations, for 90 degrees plus or minus 20 and 30; the printed proportions are rounded to
two digits. The limits are set beside the printed ones, each linkage is asked what it was
designed for, and a chart shows the crank length that each pair of deviation and rocker angle
gives.

    python scenarios/papers/elamy_transmission_angle.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import xarray as xr
from elamy_linkages import CASES, published_case

from flexmech import plots, synthesize_crank_rocker
from flexmech.linkages import time_ratio, transmission_design

TURN = np.radians(np.arange(361.0))
# Limits of the transmission angle as printed in section 5.1, in degrees.
PRINTED = {1: (58.26, 115.35), 2: (35.65, 103.95), 3: (70.0, 110.0), 4: (60.0, 120.0)}
DESIGNS = {3: (20.0, 100.0), 4: (30.0, 90.0)}  # deviation and rocker angle in degrees
# "The recommended transmission angle is 90 +- 50 deg" (section 2.1).
RECOMMENDED = np.radians([40.0, 140.0])

linkages = {f"case {case}": published_case(case) for case in CASES}
printed = {f"case {case}": limits for case, limits in PRINTED.items()}
for case, angles in DESIGNS.items():  # by equations 11 to 17, not rounded
    linkages[f"case {case} as designed"] = synthesize_crank_rocker(*np.radians(angles)).linkage()
limits = {
    name: np.degrees(linkage.transmission_angle_limits()) for name, linkage in linkages.items()
}
largest_gap = max(np.abs(limits[name] - printed[name]).max() for name in printed)
print("transmission angle; greatest deviation from 90 deg; rocker at crank angle 0; imbalance")
print("L3^2 + L4^2 - L2^2 - 1, zero by equation 11; time ratio of the rocker's strokes")
for name, linkage in linkages.items():
    design, (least, greatest) = transmission_design(linkage), limits[name]
    beside = " (printed {:g} to {:g})".format(*printed[name]) if name in printed else ""
    print(
        f"  {name}: {least:.2f} to {greatest:.2f} deg{beside}; {np.degrees(design.deviation):.2f} "
        f"deg; {np.degrees(design.rocker_angle):.2f} deg; {design.imbalance:+z.4f}; "
        f"{time_ratio(linkage):.4f}"
    )
print(f"largest gap to the printed limits: {largest_gap:.2f} deg")

angles = [linkage.transmission_angle(TURN) for linkage in linkages.values()]
drawn_angles = xr.Dataset(
    {"transmission_angle": (("linkage", "crank_angle"), angles)},
    {"linkage": list(linkages), "crank_angle": TURN},
    {
        "wanted_least": RECOMMENDED[0],
        "wanted_greatest": RECOMMENDED[1],
        "wanted_label": "recommended range",
    },
)
plots.plot_transmission_angle(drawn_angles).savefig("transmission_angle.png")

# Crank over ground: no linkage has a rocker angle below its least transmission angle.
deviation, rocker_angle = np.meshgrid(np.linspace(5.0, 60.0, 111), np.linspace(25.0, 160.0, 271))
possible = rocker_angle > 90.0 - deviation + 1e-6
crank = np.full(deviation.shape, np.nan)
designs = synthesize_crank_rocker(
    np.radians(deviation[possible]), np.radians(rocker_angle[possible])
)
crank[possible] = designs.crank
with plots.sheet(plots.grid(1, 1, 3.6)) as drawn:
    (axes,) = drawn.panels
    levels = np.arange(0.05, 0.57, 0.05)
    lines = axes.contour(deviation, rocker_angle, crank, levels=levels, linewidths=1.0)
    axes.clabel(lines, fmt="%.2f", fontsize=8)
    axes.plot(deviation[0], 90.0 - deviation[0], color="black", lw=1.2)
    axes.text(7, 30, "no linkage: rocker angle below\nthe least transmission angle", fontsize=8)
    for case, place in DESIGNS.items():
        axes.plot(*place, "o", color=plots.series_style(1).color, markersize=4)
        axes.annotate(f"case {case} ", place, ha="right", va="top", fontsize=8)
    axes.set_ylim(25.0, 160.0)
    axes.set_xlabel("Greatest deviation of the transmission angle from 90 deg (deg)")
    axes.set_ylabel("Rocker angle at crank angle 0 (deg)")
    axes.set_title("Crank length over ground length")
drawn.figure.savefig("design_chart.png")
