"""Does flexmech give the published frequencies of the four-bar of Turcic, Midha & Bosnik?

Turcic, Midha & Bosnik (1984) tested the equations that this project follows on a four-bar with a
point mass at either moving pin. Chebbi et al. (2017) drew its first and second natural frequency
over the crank angle, the linkage locked; 51 crank angles of each were read off their vector
graphics. Both engines compute these two and the third, at rest. The mesh of the published ones is
not known. Four elements a link, and 41.8 g at the pins for the 42 g that are stated, take four
fifths of the greatest deviation away, which is computed here too.

    python scenarios/turcic_midha_bosnik.py [--out results/turcic_midha_bosnik]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from _common import MODELS, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import (
    ExudynEngine,
    MovingFrequencies,
    ReferenceEngine,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    plots,
)
from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine
from flexmech.verification import verification_case

# One angle in four is a published one.
FULL_TURN = np.radians(np.linspace(0.0, 360.0, 201))
MODES, PUBLISHED_MODES = 3, 2
# Of the published frequency, and between the engines on one mesh.
REPRODUCED, AGREES = 1e-3, 1e-5
# What may explain the rest: elements a link, and kg at the pins A and B that round to 42 g.
FEW_ELEMENTS, OTHER_MASS = 4, 0.0418

CASE = verification_case("Four-bar of Turcic, Midha & Bosnik at rest: 51 crank angles, reference")
PUBLISHED = CASE.expected_values().reshape(-1, PUBLISHED_MODES)
"""Published frequencies in Hz by crank angle and mode."""
PUBLISHED_ANGLES = np.array(
    [float(label.partition(" deg")[0]) for label in CASE.labels[::PUBLISHED_MODES]]
)
"""Their crank angles in deg."""


@dataclass(frozen=True)
class PublishedAnswer:
    """Computed frequencies beside the published ones.

    Parameters
    ----------
    frequencies : MovingFrequencies
        Three modes at rest by both engines, over the turn.
    deviation : dict of str to ndarray, shape (51, 2)
        Computed frequencies over the published ones, less 1, by engine.
    unexplained : ndarray, shape (51, 2)
        The same with four elements a link and 41.8 g at the pins.
    """

    frequencies: MovingFrequencies
    deviation: dict[str, FloatArray]
    unexplained: FloatArray

    @property
    def greatest(self) -> float:
        """Greatest deviation of either engine from any of the 102 published frequencies."""
        return float(max(np.abs(one).max() for one in self.deviation.values()))

    @property
    def apart(self) -> float:
        """Greatest difference of the engines over the frequency, of all three modes."""
        frequency = self.frequencies.dataset["frequency"]
        return float(
            abs(frequency.sel(engine="exudyn") / frequency.sel(engine="reference") - 1).max()
        )

    @property
    def verdicts(self) -> tuple[str, str]:
        """On the published frequencies, and on the engines."""
        return (
            "reproduced" if self.greatest <= REPRODUCED else "not reproduced",
            "they agree" if self.apart <= AGREES else "they do not agree",
        )


def main(out: Path, *, crank_angles: FloatArray = FULL_TURN, elements: int = 16) -> PublishedAnswer:
    """Compute the frequencies by both engines, hold them against the published, draw them.

    Parameters
    ----------
    out : Path
        Folder for the picture.
    crank_angles : ndarray, shape (A,)
        Of the curves, rad.
    elements : int
        On each link.

    Returns
    -------
    PublishedAnswer
    """
    mechanism = load_mechanism(MODELS / "turcic_midha_bosnik_fourbar.toml")
    engines = [ReferenceEngine(mechanism, elements), ExudynEngine(mechanism, elements)]
    other = replace(mechanism, joint_masses=dict.fromkeys("AB", OTHER_MASS))
    answer = PublishedAnswer(
        frequencies=moving_frequencies(engines, crank_angles, [0.0], modes=MODES),
        deviation={engine.name: deviation_of(engine) for engine in engines},
        unexplained=deviation_of(ReferenceEngine(other, FEW_ELEMENTS)),
    )
    print(answer.frequencies.summary())
    for line in told(answer):
        print(line)
    save_pictures({"published": _draw(answer)}, out)
    return answer


def deviation_of(engine: Engine) -> FloatArray:
    """Frequencies of an engine over the published ones, less 1; (51, 2)."""
    angles = np.radians(PUBLISHED_ANGLES)
    return natural_frequencies(engine, angles, modes=PUBLISHED_MODES) / PUBLISHED - 1


def told(answer: PublishedAnswer) -> list[str]:
    """What the comparison tells, with verdicts that follow from the numbers."""
    lines = []
    for name, deviation in answer.deviation.items():
        for mode in range(PUBLISHED_MODES):
            of_mode = deviation[:, mode]
            worst = int(np.abs(of_mode).argmax())
            lines.append(
                f"{name}, mode {mode + 1}: deviates from the published by {of_mode[worst]:+.1e} at "
                f"most, at {PUBLISHED_ANGLES[worst]:g} deg; {of_mode.mean():+.1e} on the mean"
            )
    reproduced, agree = answer.verdicts
    lines += [
        f"{PUBLISHED.size} published frequencies: deviation at most {answer.greatest:.1e}: "
        f"{reproduced} within {REPRODUCED:g}",
        f"engines on one mesh, three modes: apart by {answer.apart:.1e}: {agree} within {AGREES:g}",
        f"with {FEW_ELEMENTS} elements a link and {1e3 * OTHER_MASS:g} g at the pins in place "
        f"of 42 g: deviation at most {np.abs(answer.unexplained).max():.1e}",
    ]
    return lines


# The engines lie on each other: one is a broad line, the other dashes on it.
BROAD: dict[str, Any] = {"linewidth": 2.2, "linestyle": "-"}
DASHED: dict[str, Any] = {"linewidth": 0.8, "linestyle": (0.0, (3.0, 3.0)), "color": "black"}
POINT: dict[str, Any] = {
    "linestyle": "",
    "marker": "o",
    "markersize": 4.0,
    "markerfacecolor": "white",
    "markeredgecolor": plots.MID_GREY,
    "clip_on": False,
}
LIMIT: dict[str, Any] = {"linewidth": 0.8, "linestyle": (0.0, (1.0, 1.5)), "color": plots.MID_GREY}


def _colour(mode: int) -> str:
    return plots.series_style(mode).color


def _draw(answer: PublishedAnswer) -> Figure:
    """Third mode, the first two with the published points, and the deviation from these."""
    frequency = answer.frequencies.dataset["frequency"].isel(crank_speed=0)
    degrees = np.degrees(frequency["crank_angle"].values)
    ratios = {"height_ratios": [2, 3, 2]}
    with plots.sheet(plots.grid(3, 1, 6.0, sharex=True, gridspec_kw=ratios)) as drawn:
        third, lower, deviation = drawn.panels
        for mode in range(MODES):
            axes = lower if mode < PUBLISHED_MODES else third
            curves = frequency.isel(mode=mode)
            axes.plot(degrees, curves.sel(engine="reference"), color=_colour(mode), **BROAD)
            axes.plot(degrees, curves.sel(engine="exudyn"), **DASHED)
        lower.plot(PUBLISHED_ANGLES, PUBLISHED, **POINT)
        deviation.axhline(0.0, color=plots.LIGHT_GREY, lw=0.6, zorder=0)
        for limit in (-REPRODUCED, REPRODUCED):
            deviation.axhline(100 * limit, **LIMIT, zorder=1)
        for mode in range(PUBLISHED_MODES):
            ours = {name: 100 * one[:, mode] for name, one in answer.deviation.items()}
            deviation.plot(PUBLISHED_ANGLES, ours["reference"], color=_colour(mode), **BROAD)
            deviation.plot(PUBLISHED_ANGLES, ours["exudyn"], **DASHED)
        deviation.set_ylim(-120 * REPRODUCED, 120 * REPRODUCED)
        for axes in (third, lower):
            axes.set_ylabel("Frequency (Hz)")
        deviation.set_ylabel("Deviation from the\npublished (%)")
        for axes in drawn.panels:
            plots.plain_numbers(axes)
        plots.crank_angle_axis(deviation, degrees)
        drawn.label_x("Crank angle (deg)")
        drawn.header(
            [
                *(
                    plots.line_handle(f"mode {mode + 1}", color=_colour(mode), **BROAD)
                    for mode in range(MODES)
                ),
                plots.line_handle("reference engine", color=plots.MID_GREY, **BROAD),
                plots.line_handle("Exudyn", **DASHED),
                plots.line_handle("published (Chebbi et al. 2017)", **POINT),
                plots.line_handle(f"limit of {100 * REPRODUCED:g} %", **LIMIT),
            ],
            "Four-bar of Turcic, Midha & Bosnik at rest",
        )
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/turcic_midha_bosnik"))
