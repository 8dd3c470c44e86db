"""How do the frequencies of a Watt and a Stephenson six-bar move with crank angle and crank speed?

Both example models drive a second dyad: from the rocker (Watt) and from the coupler (Stephenson).
Natural frequencies over the turn at rest and at 20 rad/s by both engines on one mesh, at the
equilibrium under the inertia forces with rotation terms: how much each mode swings over the turn,
what speed changes of it, its shapes, and whether the engines agree.

    python scenarios/six_bars.py [--out results/six_bars]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import MODELS, output_folder, save_pictures

from flexmech import (
    ExudynEngine,
    MovingFrequencies,
    ReferenceEngine,
    load_mechanism,
    moving_frequencies,
)
from flexmech.arrays import FloatArray

FULL_TURN = np.radians(np.arange(0, 361, 10))
SPEEDS = np.array([0.0, 20.0])
MODES = 4
# Of the frequency, on one mesh: at rest and at speed.
AGREES = (1e-5, 1e-4)


@dataclass(frozen=True)
class SixBarAnswer:
    """Natural frequencies of one six-bar.

    Parameters
    ----------
    result : MovingFrequencies
        Both engines at rest and at 20 rad/s.
    """

    result: MovingFrequencies

    @property
    def apart(self) -> FloatArray:
        """Greatest difference of the engines over the frequency, at rest and at speed; (2,)."""
        frequency = self.result.dataset["frequency"]
        other = frequency.sel(engine="exudyn") / frequency.sel(engine="reference") - 1
        return np.asarray(abs(other).max(("crank_angle", "mode")))

    @property
    def swing(self) -> FloatArray:
        """Highest frequency over the turn at rest over the lowest, less 1; (modes,)."""
        rest = self.result.dataset["frequency"].sel(engine="reference", crank_speed=0.0)
        return np.asarray(rest.max("crank_angle") / rest.min("crank_angle") - 1)

    @property
    def change(self) -> FloatArray:
        """Change of each frequency from rest to 20 rad/s over that at rest; (angles, modes)."""
        frequency = self.result.dataset["frequency"].sel(engine="reference")
        found = frequency.isel(crank_speed=-1) / frequency.isel(crank_speed=0) - 1
        return np.asarray(found.transpose("crank_angle", "mode"))

    @property
    def agrees(self) -> bool:
        """Whether the engines agree, at rest and at speed."""
        return bool(np.all(self.apart <= AGREES))


def main(
    out: Path, *, crank_angles: FloatArray = FULL_TURN, elements: int = 8
) -> dict[str, SixBarAnswer]:
    """Compute, print and draw the frequencies of both six-bars.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    crank_angles : ndarray, shape (A,)
        rad.
    elements : int
        On each beam.

    Returns
    -------
    dict of str to SixBarAnswer
        By ``"watt"`` and ``"stephenson"``.
    """
    answers, figures = {}, {}
    for name in ("watt", "stephenson"):
        mechanism = load_mechanism(MODELS / f"{name}_six_bar.toml")
        engines = [ReferenceEngine(mechanism, elements), ExudynEngine(mechanism, elements)]
        result = moving_frequencies(
            engines, crank_angles, SPEEDS, modes=MODES, speed_effect="fastest"
        )
        answer = answers[name] = SixBarAnswer(result)
        print(result.summary())
        for line in told(name, answer):
            print(line)
        drawn = result.figures()
        for kind in ("frequencies", "mode_shapes", "speed_effect"):
            figures[f"{name}_{kind}"] = drawn[kind]
    save_pictures(figures, out)
    return answers


def told(name: str, answer: SixBarAnswer) -> list[str]:
    """What the frequencies tell of a six-bar."""
    angles = np.degrees(answer.result.dataset["crank_angle"].values)
    lines = []
    for mode in range(answer.change.shape[1]):
        change = answer.change[:, mode]
        worst = int(np.abs(change).argmax())
        lines.append(
            f"{name} six-bar, mode {mode + 1}: swings by {100 * answer.swing[mode]:.2f} % over the "
            f"turn at rest; speed changes it by at most {100 * change[worst]:+.2f} %, at "
            f"{angles[worst]:.0f} deg"
        )
    lines.append(
        f"{name} six-bar, engines on one mesh: apart by {answer.apart[0]:.1e} at rest and "
        f"{answer.apart[1]:.1e} at {SPEEDS[-1]:g} rad/s: "
        + ("they agree" if answer.agrees else "they do not agree")
        + f" within {AGREES[0]:g} and {AGREES[1]:g}"
    )
    return lines


if __name__ == "__main__":
    main(output_folder(__doc__, "results/six_bars"))
