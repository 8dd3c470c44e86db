"""How much does crank speed move the natural frequencies of the steel four-bar?

The first mechanism of Kumar & Chandrakar at 0, 10 and 20 rad/s over a full turn, by both
engines; draws what their Figures 1.6 and 2.0-2.2 show, and tests their claim that speed
moves the first and the second natural frequency but not the third.

    python scenarios/steel_fourbar_frequencies.py [--out results/steel]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from pathlib import Path

from _common import output_folder
from _fourbar_frequencies import FULL_TURN, FrequencyAnswer, study_frequencies

from flexmech.arrays import FloatArray


def main(out: Path, *, crank_angles: FloatArray = FULL_TURN, elements: int = 16) -> FrequencyAnswer:
    """Answer the question of the steel four-bar; parameters as for study_frequencies."""
    return study_frequencies("steel", out, crank_angles=crank_angles, elements=elements)


if __name__ == "__main__":
    main(output_folder(__doc__, "results/steel"))
