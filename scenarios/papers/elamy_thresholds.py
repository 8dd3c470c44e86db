"""From which crank speed on do the composite crank-rockers shake themselves up?

Elamy et al. 2023 name instability thresholds in their abstract and print none. Here they are, by
Floquet multipliers about the quasi-static equilibrium, over the four linkages and the six
stackings: the crank speed at which the first band of growth opens, its width, and the damping ratio
that closes it. Without damping there is no lowest band, for the slower the crank, the higher the
order of a band and the narrower it is: a threshold belongs to a damping ratio. Links that only bend
have one map a linkage, over the speed in parts of its lowest natural frequency; a stacking
stretches it by sqrt(EI / (rho A)), its plies parallel to the plane of motion or stacked in it.
Other stackings, computed by themselves, test that. Last, eigenvalues of frozen positions in link
frames, with rotation terms and the stress of the running links, are held against the bands. Speeds
in rad/s are of the link size that is assumed, for the paper prints none.

    python scenarios/papers/elamy_thresholds.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
from elamy_linkages import (
    CASES,
    LAMINATES,
    LAYERS,
    crank_rocker,
    position_angles,
    published_case,
)
from matplotlib.patches import Patch
from paper_claims import Claim, claim_lines, verdict_on, within_a_tenth

from flexmech import ReferenceEngine, natural_frequencies, plots, stability
from flexmech.solvers import solve_modes

MAPPED = tuple(CASES)
CHECKED_CASE, CHECKED_LAMINATE = 1, "C4"
# Over the lowest natural frequency of the turn, a step apart that is as wide as the narrowest first
# band: narrower ones can be missed. Not far beyond the last one case 4 has no equilibrium.
SPEEDS = np.linspace(0.2, 0.67, 672)
FROZEN_SPEEDS = np.linspace(0.01, 0.67, 34)
TURN = np.radians(np.arange(0.0, 361.0, 5.0))
DAMPING_RATIO = 0.001  # at which bands are mapped
# Ratios of the thresholds. In percent the paper's damping factors, 0.231 to 0.461, lie among them.
RATIOS = (0.001, 0.002, 0.005)
PRINTED_FALL = 62.22  # by which frequencies fall from C1 to C6 in the paper, in percent
BAND_COLOURS = {"First bands at these damping ratios": "#D55E00", "Other bands": "#56B4E9"}
GROWS = "0.80"


def bands_of(mechanism, lowest, speeds):
    """Bands of growth; edges, their error and growth over the lowest natural frequency in rad/s."""
    engine = ReferenceEngine(mechanism, 4, "euler")
    found = stability(
        engine, lowest * speeds, prestress="equilibrium", modes=3, damping_ratio=DAMPING_RATIO
    )
    table = found.bands()
    bands = pd.DataFrame(
        {
            "lower": table["from_rad_s"] / lowest,
            "upper": table["to_rad_s"] / lowest,
            "error": table["error_rad_s"] / lowest,
            # No damping ratio below 1 closes what has none.
            "closing": table["closing_damping_ratio"].fillna(1.0),
            "open": found.dataset["band_upper_open"].values,
        }
    )
    return bands.sort_values("lower", ignore_index=True)


def first_band(bands, ratio):
    """First band that a damping ratio leaves open; not a number where there is none."""
    left = bands[bands["closing"] > ratio]
    return pd.Series(np.nan, index=bands.columns) if left.empty else left.iloc[0]


def span(values, form):
    """First and last of values in words."""
    return f"{values[0]:{form}} to {values[-1]:{form}}"


# All links of a linkage have one section: frequencies go with sqrt(EI / (rho A)).
scales = pd.DataFrame(
    {
        layers: {
            laminate: np.sqrt(section.bending_stiffness / section.mass_per_length)
            for laminate in LAMINATES
            for section in [crank_rocker(1, laminate, layers=layers).sections["coupler"]]
        }
        for layers in LAYERS
    }
)
over_c1 = scales / scales.loc["C1", "across width"]

# Results of C1: other stackings stretch the map.
lowest, frequency, bands, thresholds, frozen, frozen_angle = {}, {}, {}, {}, {}, {}
for case in MAPPED:
    engine = ReferenceEngine(crank_rocker(case, "C1"), 4, "euler")
    circular = 2 * np.pi * natural_frequencies(engine, TURN, modes=2)
    lowest[case], mean = circular[:, 0].min(), circular[:-1, 0].mean()
    frequency[case] = circular / lowest[case]
    bands[case] = bands_of(engine.mechanism, lowest[case], SPEEDS)
    firsts = {ratio: first_band(bands[case], ratio) for ratio in RATIOS}
    thresholds[case] = [float(band["lower"]) for band in firsts.values()]
    print(
        f"case {case}, C1: lowest natural frequency {lowest[case]:.1f} rad/s, at crank angle "
        f"{np.degrees(TURN[circular[:, 0].argmin()]):.0f} deg; bands up to {SPEEDS[-1]:g} of it "
        f"that a damping ratio of {100 * DAMPING_RATIO:g} % leaves open: {len(bands[case])}"
    )
    for ratio, band in firsts.items():
        width, closing = 100 * (band["upper"] / band["lower"] - 1), band["closing"]
        open_end = "at least " if band["open"] is True or band["open"] == 1 else ""
        words = (
            "no band in this range"
            if np.isnan(band["lower"])
            else f"from {lowest[case] * band['lower']:.1f} rad/s, {band['lower']:.4f} of the "
            f"lowest frequency, {open_end}{width:.2f} % wide; closed by {100 * closing:.2f} %, "
            f"a damping time of {2e6 * closing / mean:.1f} us"
        )
        print(f"  damping ratio {100 * ratio:g} %: {words}")

    sections = {
        name: section.with_damping_time(2 * DAMPING_RATIO / mean)
        for name, section in engine.mechanism.sections.items()
    }
    damped = engine.with_(mechanism=replace(engine.mechanism, sections=sections)).unreduced()
    speed, angle = (grid.ravel() for grid in np.meshgrid(FROZEN_SPEEDS, TURN, indexing="ij"))
    system = damped.linear_system(angle, lowest[case] * speed, prestress="equilibrium")
    values = solve_modes(system, 3).eigenvalues / lowest[case]
    frozen[case] = values.real.max(axis=1).reshape(len(FROZEN_SPEEDS), len(TURN))
    greatest = frozen[case].max(axis=1)
    growing = np.flatnonzero(greatest > 0)
    says, frozen_angle[case], onset = "none grows", np.nan, np.inf
    if growing.size:
        place = growing[0]
        around = slice(max(place - 1, 0), place + 1)
        onset = float(np.interp(0.0, greatest[around], FROZEN_SPEEDS[around]))
        frozen_angle[case] = np.degrees(TURN[frozen[case][place].argmax()])
        says = f"one grows from {onset:.3f} on, first at crank angle {frozen_angle[case]:.0f} deg"
    first = thresholds[case][0]
    verdict = "miss the first band" if onset > first else "show the first band"
    if onset < first:
        verdict = f"raise a false alarm {first / onset:.1f} times too early"
    print(
        f"  frozen positions up to {FROZEN_SPEEDS[-1]:g}, damping ratio {100 * DAMPING_RATIO:g} %: "
        f"{says}, {'some diverge' if values.imag.min() <= 0 else 'none diverges'}; Floquet "
        f"multipliers from {first:.3f} on, so that frozen positions {verdict}"
    )

checked = first_band(bands[CHECKED_CASE], DAMPING_RATIO)
edges = {}
for layers in LAYERS:
    mechanism = crank_rocker(CHECKED_CASE, CHECKED_LAMINATE, layers=layers)
    speeds = np.linspace(checked["lower"] - 0.02, checked["upper"] + 0.02, 5)
    scaled = lowest[CHECKED_CASE] * over_c1.loc[CHECKED_LAMINATE, layers]
    table = bands_of(mechanism, scaled, speeds)
    own = table.loc[(table["lower"] - checked["lower"]).abs().idxmin()]
    edges[layers] = max(abs(own[edge] / checked[edge] - 1) for edge in ("lower", "upper"))
    widths = [band["upper"] - band["lower"] for band in (own, checked)]
    mesh = checked["error"] / checked["lower"]
    print(
        f"scale, case {CHECKED_CASE}, {CHECKED_LAMINATE}, plies {layers}, computed by itself: "
        f"edges {edges[layers]:.0e} off, width {abs(widths[0] / widths[1] - 1):.0e}, closing "
        f"damping ratio {abs(own['closing'] / checked['closing'] - 1):.0e}; edges are known to "
        f"{mesh:.0e}: {'it scales' if edges[layers] < mesh else 'it does not scale'}"
    )


def opens_below(low, high, unit):
    """Whether a case opens first at every damping ratio, by more than the errors of the edges."""
    pairs = [[first_band(bands[case], ratio) for case in (low, high)] for ratio in RATIOS]
    return all(
        unit[low] * (one["lower"] + one["error"]) < unit[high] * (two["lower"] - two["error"])
        for one, two in pairs
    )


claims = []
if tuple(CASES) == MAPPED:

    def claim(place, statement, printed, computed, holds, fails_if, reason=""):
        """Hold a statement of the paper against the thresholds."""
        verdict = verdict_on(holds)
        claims.append(
            Claim(place, statement, printed, "", computed, "", verdict, reason, "", fails_if)
        )

    speeds = "; ".join(
        f"case {case} {span([lowest[case] * z for z in thresholds[case]], '.0f')}" for case in CASES
    )
    speeds = f"C1, damping ratios {100 * RATIOS[0]:g} to {100 * RATIOS[-1]:g} %: {speeds} rad/s"
    claim(
        "abstract",
        "proportions and stacking change instability thresholds",
        "no threshold",
        speeds,
        None,
        "nothing: no number is printed to compare with",
        "what the paper says of frequencies and of smooth running is put to the thresholds below",
    )
    for case, word in ((2, "lowest"), (3, "highest")):
        pairs = [
            (case, other)[:: 1 if word == "lowest" else -1] for other in CASES if other != case
        ]
        claim(
            "section 5.2.2",
            f"case {case} is {word} (of frequencies), of thresholds",
            f"case {case}",
            speeds,
            all(opens_below(*pair, lowest) for pair in pairs),
            f"another case is {word} at a damping ratio, or may be by the errors",
        )
    deviation = {
        case: np.abs(np.degrees(published_case(case).transmission_angle_limits()) - 90.0).max()
        for case in CASES
    }
    roughest = sorted(CASES, key=lambda case: -deviation[case])
    claim(
        "section 1",
        "the farther transmission angles are from 90 deg, the rougher the linkage runs at high "
        "speeds: the lower its threshold over its lowest frequency",
        "no number",
        ", ".join(
            f"case {case} (up to {deviation[case]:.0f} deg off) {span(thresholds[case], '.3f')}"
            for case in roughest
        ),
        all(opens_below(*pair, dict.fromkeys(CASES, 1.0)) for pair in pairwise(roughest)),
        "two cases are in the other order at a damping ratio, or may be by the errors",
    )
    claim(
        "section 5.2.1",
        "from C1 to C6 each is below the one before (of frequencies), of thresholds",
        "everywhere",
        "; ".join(
            f"plies {layers} " + ", ".join(f"{value:.3f}" for value in column)
            for layers, column in over_c1.items()
        ),
        bool((scales.diff().iloc[1:] < 0).all(axis=None)),
        "one is not below the one before, whichever way the plies lie",
        "over C1, in every case alike",
    )
    fall = 100 * (1 - over_c1.loc["C6"])
    claim(
        "section 5.2.1",
        "C6 is below C1 (of frequencies), of thresholds by",
        f"{PRINTED_FALL} %",
        ", ".join(f"plies {layers} {value:.2f} %" for layers, value in fall.items()),
        all(within_a_tenth(PRINTED_FALL, value) for value in fall),
        "ours is more than a tenth of the number off",
        "all of one material they bend alike, whichever way the plies lie",
    )
    claim(
        "abstract",
        "best at a transmission angle of 90 deg",
        "90 deg",
        "frozen eigenvalues begin to grow at crank angles of "
        + ", ".join(f"{frozen_angle[case]:.0f}" for case in CASES)
        + f" deg (cases {', '.join(map(str, CASES))})",
        None,
        "nothing: a threshold has no crank angle",
        "a running crank passes all positions, and frozen ones do not show growth",
    )
    print(*claim_lines(claims), sep="\n")

unit = "over the lowest natural frequency (-)"
with plots.sheet(plots.grid(1, len(RATIOS), 2.8, sharey=True)) as drawn:
    for number, (axes, ratio) in enumerate(zip(drawn.panels, RATIOS, strict=True)):
        for case in MAPPED:
            speed = lowest[case] * thresholds[case][number] * over_c1
            style = plots.series_style(case - 1)
            look = {"color": style.color, "marker": style.marker, "markersize": 4.0}
            axes.semilogy(list(LAMINATES), speed["across width"], **look, label=f"case {case}")
            axes.semilogy(list(LAMINATES), speed["through thickness"], ls=":", mfc="white", **look)
        axes.set_title(f"Damping ratio {100 * ratio:g} %", fontsize=8)
        axes.set_yticks([50, 100, 200, 500], ["50", "100", "200", "500"])
        axes.minorticks_off()
    drawn.label_x("Stacking")
    drawn.panels[0].set_ylabel("Crank speed of the first band (rad/s)")
    handles = drawn.panels[0].get_legend_handles_labels()[0]
    handles.append(plots.line_handle("Plies across the width", color="black", marker="o"))
    stacked = {"color": "black", "marker": "o", "mfc": "white", "ls": ":"}
    handles.append(plots.line_handle("Plies through the thickness", **stacked))
    drawn.header(handles, "Composite crank-rockers: where the first band of growth opens")
drawn.figure.savefig("thresholds.png")

with plots.sheet(plots.grid(len(MAPPED), 1, 1.35 * len(MAPPED), sharex=True)) as drawn:
    for axes, case in zip(drawn.panels, MAPPED, strict=True):
        for band in bands[case].to_dict("records"):
            colour = list(BAND_COLOURS.values())[band["lower"] not in thresholds[case]]
            width, height = band["upper"] - band["lower"], 100 * band["closing"] - 0.1
            axes.bar(band["lower"], height, width, 0.1, align="edge", color=colour, ec=colour)
        for ratio in RATIOS:
            axes.axhline(100 * ratio, color=plots.MID_GREY, lw=0.6, ls=":", zorder=0)
        axes.set(yscale="log", ylim=(0.1, 5.0), xlim=(SPEEDS[0], SPEEDS[-1]), title=f"Case {case}")
        axes.set_yticks([0.1, 0.2, 0.5, 1, 2, 5], ["0.1", "0.2", "0.5", "1", "2", "5"])
        axes.minorticks_off()
    drawn.label_y("Damping ratio that closes a band (%)")
    drawn.label_x(f"Crank speed {unit}", slice(-1, None))
    handles = [Patch(color=colour, label=words) for words, colour in BAND_COLOURS.items()]
    title = f"Bands of growth, as wide as they are at {100 * DAMPING_RATIO:g} % of damping"
    drawn.header(handles, title)
drawn.figure.savefig("bands.png")

with plots.sheet(plots.grid(2, len(MAPPED), 4.6, sharex=True, sharey="row")) as drawn:
    above, below = drawn.panels[: len(MAPPED)], drawn.panels[len(MAPPED) :]
    first_colour = next(iter(BAND_COLOURS.values()))
    for upper, lower, case in zip(above, below, MAPPED, strict=True):
        for mode in range(2):
            upper.plot(np.degrees(TURN), frequency[case][:, mode], **plots.series_line(mode))
        upper.set_title(f"Case {case}", fontsize=8)
        if (frozen[case] > 0).any():
            region = np.degrees(TURN), FROZEN_SPEEDS, frozen[case]
            lower.contourf(*region, [0, np.inf], colors=[GROWS])
        for band in bands[case].to_dict("records"):
            lower.axhspan(band["lower"], band["upper"], color=first_colour, lw=0.5)
        for axes in (upper, lower):
            plots.crank_angle_axis(axes, np.degrees(TURN))
            axes.set_xticks([0, 180, 360])
            for angle in np.degrees(position_angles(published_case(case))[[1, 3]]):
                axes.axvline(angle, color=plots.MID_GREY, lw=0.6, ls=":")
        lower.set_ylim(0, FROZEN_SPEEDS[-1])
    above[0].set_ylim(bottom=0)
    above[0].set_ylabel("Natural frequency at rest\nover its lowest value (-)")
    below[0].set_ylabel("Crank speed over the\nlowest natural frequency (-)")
    drawn.label_x("Crank angle (deg)", slice(len(MAPPED), None))
    handles = [plots.series_handle(mode, f"Mode {mode + 1}") for mode in range(2)]
    handles.append(Patch(color=GROWS, label="A frozen eigenvalue grows"))
    handles.append(Patch(color=first_colour, label="Bands of growth (Floquet)"))
    right = {"color": plots.MID_GREY, "lw": 0.6, "ls": ":"}
    handles.append(plots.line_handle("Transmission angle 90 deg", **right))
    title = f"Frozen positions and the running linkage, damping {100 * DAMPING_RATIO:g} %"
    drawn.header(handles, title)
drawn.figure.savefig("frozen.png")
