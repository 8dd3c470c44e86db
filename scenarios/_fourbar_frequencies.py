"""What crank speed does to the frequencies of the four-bars of Kumar & Chandrakar.

They claim that "the crank angular velocity is effective on the first and second dynamic natural
frequencies but not on the third one" (section 3).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import SPEEDS, four_bar, mean_over_turn, save_pictures
from matplotlib.figure import Figure

from flexmech import (
    ExudynEngine,
    MovingFrequencies,
    ReferenceEngine,
    moving_frequencies,
    natural_frequencies,
    plots,
)
from flexmech.arrays import FloatArray

__all__ = ["FULL_TURN", "FrequencyAnswer", "study_frequencies"]

FULL_TURN = np.radians(np.arange(0, 361, 5))
MODES = 3
# Crank angles of the change with speed, as many for each of the map: it has narrow peaks.
FINER = 5
# "Not effective" would leave mode 3 with far less than modes 1 and 2: a tenth is taken here
# for the claim, half for a part of it.
UNAFFECTED, LESS_AFFECTED = 0.1, 0.5


@dataclass(frozen=True)
class FrequencyAnswer:
    """How speed moves the frequencies of a four-bar; S speeds from rest on, modes 1 to 3.

    Parameters
    ----------
    frequencies : MovingFrequencies
        Both engines, equilibrium with rotation terms.
    crank_angles : ndarray, shape (A,)
        rad; finer than those of the map.
    whole : ndarray, shape (S, A, 3)
        Frequencies at these in Hz (reference engine).
    classical : ndarray, shape (S, A, 3)
        The same by the axial forces' geometric stiffness alone, without rotation terms.
    """

    frequencies: MovingFrequencies
    crank_angles: FloatArray
    whole: FloatArray
    classical: FloatArray

    @property
    def third_to_others(self) -> float:
        """Change of mode 3 over the lesser of those of modes 1 and 2, both relative.

        Root mean square over the turn at the highest speed.
        """
        effect = mean_over_turn(self.whole[-1] / self.whole[0] - 1)
        return float(effect[2] / effect[:2].min())

    @property
    def verdict(self) -> str:
        """On the paper's claim."""
        if self.third_to_others < UNAFFECTED:
            return "borne out"
        return "borne out in part" if self.third_to_others < LESS_AFFECTED else "not borne out"


def study_frequencies(
    model: str, out: Path, *, crank_angles: FloatArray = FULL_TURN, elements: int = 16
) -> FrequencyAnswer:
    """Compute, print and draw the moving frequencies of ``"steel"`` or ``"aluminium"``.

    Parameters
    ----------
    model : str
    out : Path
        Folder for the pictures.
    crank_angles : ndarray, shape (A,)
        Of the map by both engines: rad, from 0 to a full turn.
    elements : int
        Elements a link.

    Returns
    -------
    FrequencyAnswer
    """
    mechanism = four_bar(model)
    engine = ReferenceEngine(mechanism, elements)
    result = moving_frequencies(
        [engine, ExudynEngine(mechanism, elements)],
        crank_angles,
        SPEEDS,
        modes=MODES,
        speed_effect="fastest",
    )
    fine = np.linspace(0, 2 * np.pi, FINER * (len(crank_angles) - 1) + 1)
    answer = FrequencyAnswer(
        frequencies=result,
        crank_angles=fine,
        whole=natural_frequencies(engine, fine, SPEEDS[:, None], modes=MODES),
        classical=natural_frequencies(
            engine, fine, SPEEDS[:, None], modes=MODES, prestress="axial", rotation_terms=False
        ),
    )
    _report(answer)
    save_pictures({**result.figures(), "change_with_speed": _draw_change(answer)}, out)
    return answer


def _draw_change(answer: FrequencyAnswer) -> Figure:
    """Relative change of each frequency against crank angle, whole and classical side by side."""
    angles = np.round(np.degrees(answer.crank_angles), 9).astype(float)
    halves = {
        "Equilibrium with rotation terms": answer.whole,
        "Axial forces alone (Turcic & Midha)": answer.classical,
    }
    with plots.sheet(plots.grid(1, 2, 2.6, sharey=True)) as drawn:
        for axes, (heading, frequency) in zip(drawn.panels, halves.items(), strict=True):
            axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
            for mode in range(MODES):
                change = 100 * (frequency[-1] / frequency[0] - 1)[:, mode]
                axes.plot(angles, change, **plots.series_line(mode))
            axes.set_title(heading)
            plots.crank_angle_axis(axes, angles, narrow=True)
        drawn.label_x("Crank angle (deg)")
        drawn.panels[0].set_ylabel("Change of frequency (%)")
        plots.plain_numbers(drawn.panels[0])
        drawn.header(
            [plots.series_handle(n, f"mode {n + 1}") for n in range(MODES)],
            f"Change of the natural frequencies from rest to {plots.speed_label(SPEEDS[-1])}",
        )
    return drawn.figure


def _report(answer: FrequencyAnswer) -> None:
    print(answer.frequencies.summary())
    rest, swing = answer.whole[0], np.ptp(answer.whole[0], axis=0)
    print("\nchange from rest at the same crank angle (rms: root mean square over the turn)")
    print("rad/s  mode     least %   greatest %  rms %   rms Hz  of swing   rms % axial alone")
    for number, speed in enumerate(SPEEDS[1:], start=1):
        percent = 100 * (answer.whole[number] / rest - 1)
        classical = 100 * (answer.classical[number] / answer.classical[0] - 1)
        effect, alone = mean_over_turn(percent), mean_over_turn(classical)
        hertz = mean_over_turn(answer.whole[number] - rest)
        for mode in range(MODES):
            print(
                f"{speed:5g}  {mode + 1:4d}  {percent[:, mode].min():+10.3f}"
                f"  {percent[:, mode].max():+11.3f}  {effect[mode]:5.3f}  {hertz[mode]:7.3f}"
                f"  {hertz[mode] / swing[mode]:8.4f}  {alone[mode]:18.3f}"
            )
    print("(swing: highest less lowest frequency over the turn at rest)")
    print(
        '\nclaim: the crank speed "is effective on the first and second dynamic natural '
        f'frequencies but not on the third one": {answer.verdict}.\nAt {SPEEDS[-1]:g} rad/s '
        f"the third changes {answer.third_to_others:.2f} times as much as the less changed of "
        "the other two (rms %)."
    )
