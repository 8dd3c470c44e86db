"""What do damping ratios of frozen positions tell about growth, and what do they hide?

With the crank held in thought, the eigenvalues of the running linkage depend on the axes in which
its displacements are written: those of the links or those of the ground. Both damping ratios are
drawn over the crank angle, beside those of the Floquet modes, which are the same in all axes: they
alone tell whether a vibration has grown after a turn. The aluminium four-bar with axial forces and
Kelvin-Voigt damping of 2e-5 s, at a crank speed below a band of growth and at one inside it.

    python scenarios/frames_and_stability.py [--out results/frames_and_stability]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures
from _ground_axes import frozen_eigenvalues
from matplotlib.figure import Figure

from flexmech import Mechanism, ReferenceEngine
from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import floquet_modes
from flexmech.solvers import SampledTurn, counts_of_modes, moving_modes

DAMPING_TIME = 2e-5
SPEEDS = np.array([60.0, 87.0])
MODES = 2
# Of a turn; the crank angles of the frozen eigenvalues are among them.
SAMPLES, DRAWN, STEPS = 256, 128, 512
COLOURS = {"link": "tab:blue", "inertial": "tab:orange"}
LABELS = {"link": "frozen, link frames", "inertial": "frozen, ground axes"}


@dataclass(frozen=True)
class DampingOverTurn:
    """Damping ratios at one crank speed.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    angle : ndarray, shape (N,)
        Of the crank in rad.
    frozen : dict of ndarray, shape (N, MODES)
        By frame.
    floquet : dict of ndarray, shape (MODES,)
        Of the Floquet modes that die out least, by frame.
    growth_rate : float
        Greatest of all Floquet modes, 1/s.
    """

    crank_speed: float
    angle: FloatArray
    frozen: dict[str, FloatArray]
    floquet: dict[str, FloatArray]
    growth_rate: float

    @property
    def frame_gap(self) -> float:
        """Greatest difference of the first mode's frozen damping ratios in the two frames."""
        return float(np.abs(self.frozen["link"] - self.frozen["inertial"])[:, 0].max())

    @property
    def floquet_gap(self) -> float:
        """Greatest difference of the Floquet modes' damping ratios in the two frames."""
        return float(np.abs(self.floquet["link"] - self.floquet["inertial"]).max())


def damped(mechanism: Mechanism) -> Mechanism:
    """The mechanism with Kelvin-Voigt damping in all links."""
    sections = {
        name: section.with_damping_time(DAMPING_TIME)
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def damping_over_turn(engine: ReferenceEngine, crank_speed: float) -> DampingOverTurn:
    """Damping ratios in both frames at a crank speed in rad/s."""
    angle = 2 * np.pi / SAMPLES * np.arange(SAMPLES)
    motion = engine.mechanism.linkage.motion(angle, crank_speed)
    stressed = engine.stressed_links(motion, "axial")
    turn = SampledTurn.of(engine, motion, stressed, "axial", 6)
    count = counts_of_modes(turn, 6, 1)[0]
    drawn = angle[:: SAMPLES // DRAWN]
    frozen, floquet, growth = {}, {}, 0.0
    for frame in ("link", "inertial"):
        values = frozen_eigenvalues(
            engine, drawn, crank_speed, prestress="axial", frame=frame, modes=MODES
        )
        frozen[frame] = -values.real / np.abs(values)
        found = floquet_modes(moving_modes(turn, count, frame=frame).system(), STEPS)
        # Of the family of frequencies of a mode the one of its largest harmonic.
        size = (np.abs(np.fft.fft(found.shapes()[:, :count], axis=0)) ** 2).sum(axis=1)
        harmonic = np.fft.fftfreq(STEPS, 1 / STEPS)[size.argmax(axis=0)]
        frequency = found.exponent.imag + harmonic * crank_speed
        ratio = -found.exponent.real / np.hypot(found.exponent.real, frequency)
        # The one that grows most first; of two conjugate modes one.
        rates = np.round(found.exponent.real, 6)
        floquet[frame] = ratio[np.sort(np.unique(-rates, return_index=True)[1])[:MODES]]
        growth = float(found.exponent.real.max())
    return DampingOverTurn(crank_speed, drawn, frozen, floquet, growth)


def draw(answers: list[DampingOverTurn]) -> Figure:
    """Frozen damping ratios over the turn in both frames, and the Floquet modes'."""
    figure = Figure(figsize=(7.0, 3.2 * len(answers)), layout="constrained")
    axes = figure.subplots(len(answers), 1, sharex=True, squeeze=False)[:, 0]
    for ax, answer in zip(axes, answers, strict=True):
        for frame, ratios in answer.frozen.items():
            lines = ax.plot(np.degrees(answer.angle), 100 * ratios, color=COLOURS[frame], lw=1.2)
            lines[0].set_label(LABELS[frame])
        for ratio in answer.floquet["link"]:
            floquet = ax.axhline(100 * ratio, color="black", lw=1.2, ls="--")
        floquet.set_label("Floquet modes, all axes")
        ax.axhline(0.0, color="0.6", lw=0.8)
        ax.set_title(
            f"{answer.crank_speed:g} rad/s: fastest growth {answer.growth_rate:+.2f} 1/s",
            loc="left",
        )
        ax.set_ylabel("damping ratio (%)")
    axes[-1].set_xlabel("crank angle (deg)")
    axes[-1].set_xlim(0, 360)
    axes[-1].set_xticks(np.arange(0, 361, 60))
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def main(out: Path, speeds: FloatArray = SPEEDS, elements: int = 8) -> list[DampingOverTurn]:
    """Compare both frames at the crank speeds, draw the picture and tell the numbers."""
    engine = ReferenceEngine(damped(four_bar("aluminium")), elements)
    answers = [damping_over_turn(engine, float(speed)) for speed in speeds]
    for answer in answers:
        low, high = (100 * f(answer.frozen["link"]) for f in (np.min, np.max))
        print(
            f"{answer.crank_speed:g} rad/s: frozen damping ratios {low:.2f} to {high:.2f} % in "
            f"link frames; the frames differ by up to {100 * answer.frame_gap:.3f} %, the Floquet "
            f"modes by {100 * answer.floquet_gap:.0e} %; fastest growth {answer.growth_rate:.2f} "
            "1/s"
        )
    save_pictures({"damping_over_turn": draw(answers)}, out)
    return answers


if __name__ == "__main__":
    main(output_folder(__doc__, "results/frames_and_stability"))
