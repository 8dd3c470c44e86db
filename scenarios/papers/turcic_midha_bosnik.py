"""Does flexmech give the published frequencies of the four-bar of Turcic, Midha & Bosnik?

Turcic, Midha & Bosnik (1984) tested the equations that this project follows on a four-bar with a
point mass at either moving pin. Chebbi et al. (2017) drew its first and second natural frequency
over the crank angle, the linkage locked; 51 crank angles of each were read off their vector
graphics. Both engines compute these two and the third, at rest. The mesh of the published ones is
not known. Four elements a link, and 41.8 g at the pins for the 42 g that are stated, take four
fifths of the greatest deviation away, which is computed here too.

    python scenarios/papers/turcic_midha_bosnik.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import (
    ExudynEngine,
    ReferenceEngine,
    example_model,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    plots,
)
from flexmech.verification import verification_case

ELEMENTS = 16
# One angle in four is a published one.
TURN = np.radians(np.linspace(0.0, 360.0, 201))
# Deviations from the published frequency, and between the engines on one mesh.
REPRODUCED, AGREES = 1e-3, 1e-5
# What may explain the rest: elements a link, and kg at the pins A and B that round to 42 g.
FEW_ELEMENTS, OTHER_MASS = 4, 0.0418

CASE = verification_case("Four-bar of Turcic, Midha & Bosnik at rest: 51 crank angles, reference")
PUBLISHED = CASE.expected_values().reshape(-1, 2)  # Hz, by crank angle and mode
DEGREES = np.array([float(label.partition(" deg")[0]) for label in CASE.labels[::2]])


def deviation_of(engine):
    """Frequencies of an engine over the published ones, less 1; (51, 2)."""
    return natural_frequencies(engine, np.radians(DEGREES), modes=2) / PUBLISHED - 1


mechanism = load_mechanism(example_model("turcic_midha_bosnik_fourbar"))
engines = [ReferenceEngine(mechanism, ELEMENTS), ExudynEngine(mechanism, ELEMENTS)]
result = moving_frequencies(engines, TURN, [0.0], modes=3)
print(result.summary())
deviations = {engine.name: deviation_of(engine) for engine in engines}
for name, deviation in deviations.items():
    for mode, of_mode in enumerate(deviation.T, start=1):
        worst = np.abs(of_mode).argmax()
        print(
            f"{name}, mode {mode}: deviates from the published by {of_mode[worst]:+.1e} at most, "
            f"at {DEGREES[worst]:g} deg; {of_mode.mean():+.1e} on the mean"
        )
greatest = max(np.abs(deviation).max() for deviation in deviations.values())
frequency = result.dataset["frequency"].isel(crank_speed=0)
apart = float(abs(frequency.sel(engine="exudyn") / frequency.sel(engine="reference") - 1).max())
verdicts = (
    "reproduced" if greatest <= REPRODUCED else "not reproduced",
    "they agree" if apart <= AGREES else "they do not agree",
)
other = replace(mechanism, joint_masses=dict.fromkeys("AB", OTHER_MASS))
unexplained = np.abs(deviation_of(ReferenceEngine(other, FEW_ELEMENTS))).max()
print(
    f"{PUBLISHED.size} published frequencies: deviation at most {greatest:.1e}: {verdicts[0]} "
    f"within {REPRODUCED:g}\n"
    f"engines on one mesh, three modes: apart by {apart:.1e}: {verdicts[1]} within {AGREES:g}\n"
    f"with {FEW_ELEMENTS} elements a link and {1e3 * OTHER_MASS:g} g at the pins in place of 42 g: "
    f"deviation at most {unexplained:.1e}"
)

# The engines lie on each other: one is a broad line, the other dashes on it.
broad, dashed = {"lw": 2.2}, {"lw": 0.8, "ls": (0.0, (3.0, 3.0)), "color": "black"}
point = {"ls": "", "marker": "o", "markersize": 4.0, "mfc": "white", "mec": plots.MID_GREY}
limit = {"lw": 0.8, "ls": ":", "color": plots.MID_GREY}
ratios = {"height_ratios": [2, 3, 2]}
with plots.sheet(plots.grid(3, 1, 6.0, sharex=True, gridspec_kw=ratios)) as drawn:
    third, lower, below = drawn.panels
    colours = [plots.series_style(mode).color for mode in range(3)]
    for mode, colour in enumerate(colours):
        axes, of_mode = (third if mode == 2 else lower), frequency.isel(mode=mode)
        degrees = np.degrees(TURN)
        axes.plot(degrees, of_mode.sel(engine="reference"), color=colour, **broad)
        axes.plot(degrees, of_mode.sel(engine="exudyn"), **dashed)
        if mode < 2:
            below.plot(DEGREES, 100 * deviations["reference"][:, mode], color=colour, **broad)
            below.plot(DEGREES, 100 * deviations["exudyn"][:, mode], **dashed)
    lower.plot(DEGREES, PUBLISHED, **point)
    for edge in (-100 * REPRODUCED, 100 * REPRODUCED):
        below.axhline(edge, **limit)
    for axes in drawn.panels:
        axes.set_ylabel("Deviation from the\npublished (%)" if axes is below else "Frequency (Hz)")
        plots.plain_numbers(axes)
    plots.crank_angle_axis(below, degrees)
    drawn.label_x("Crank angle (deg)")
    handles = [plots.line_handle(f"mode {n + 1}", color=c, **broad) for n, c in enumerate(colours)]
    handles += [
        plots.line_handle("reference engine", color=plots.MID_GREY, **broad),
        plots.line_handle("Exudyn", **dashed),
        plots.line_handle("published (Chebbi et al. 2017)", **point),
        plots.line_handle(f"limit of {100 * REPRODUCED:g} %", **limit),
    ]
    drawn.header(handles, "Four-bar of Turcic, Midha & Bosnik at rest")
drawn.figure.savefig("published.png")
