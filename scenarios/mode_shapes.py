"""What do the first three modes look like, and does crank speed change their shapes?

The steel and the aluminium four-bar of Kumar & Chandrakar: the shapes at rest and crank
angle 0 as in their Figures 1.7-1.9, those at 10 and 20 rad/s as in their Figures 2.3-2.8 (the
paper does not print the crank angle of these; 0 is taken), and the modal assurance criterion
(MAC) between the shapes at rest and at speed over the full turn. The paper calls the shapes
"very consistent in each other", which is taken as a MAC above 0.9, the usual bound of shapes that
correspond.

    python scenarios/mode_shapes.py [--out results/mode_shapes]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from _common import SPEEDS, four_bar, output_folder, save_pictures
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flexmech import Mechanism, ReferenceEngine, moving_frequencies, plots
from flexmech.arrays import FloatArray
from flexmech.solvers import solve_modes

MODES = 3
CONSISTENT = 0.9
FULL_TURN = np.radians(np.arange(0, 361))


@dataclass(frozen=True)
class ShapeAnswer:
    """Likeness of the shapes at rest and at speed of one mechanism; S speeds above rest.

    Parameters
    ----------
    mac : ndarray, shape (S, A, 3)
        Mass-weighted modal assurance criterion between mode n at rest and mode n at speed.
    crank_angles : ndarray, shape (A,)
        rad.
    frequencies : ndarray, shape (S + 1, 3)
        At crank angle 0, rest first; Hz.
    """

    mac: FloatArray
    crank_angles: FloatArray
    frequencies: FloatArray

    @property
    def verdict(self) -> str:
        """On the paper's claim."""
        return "borne out" if self.mac.min() > CONSISTENT else "not borne out"


def main(
    out: Path, *, crank_angles: FloatArray = FULL_TURN, elements: int = 16
) -> dict[str, ShapeAnswer]:
    """Draw the shapes, print their likeness.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    crank_angles : ndarray, shape (A,)
        rad, the first 0.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to ShapeAnswer
        By ``"steel"`` and ``"aluminium"``.
    """
    answers, figures = {}, {}
    for name in ("steel", "aluminium"):
        engine = ReferenceEngine(four_bar(name), elements)
        result = moving_frequencies(engine, [0.0], SPEEDS, modes=MODES)
        figures[f"{name}_at_rest"] = plots.plot_mode_shapes(result.dataset.isel(crank_speed=[0]))
        figures[f"{name}_by_speed"] = plots.plot_mode_shapes(result.dataset)
        answers[name] = ShapeAnswer(
            mac=likeness(engine, crank_angles),
            crank_angles=crank_angles,
            frequencies=result.dataset["frequency"].values[0, :, 0],
        )
    figures["likeness"] = _draw_likeness(answers)
    _report(answers)
    save_pictures(figures, out)
    return answers


def likeness(engine: ReferenceEngine, crank_angles: FloatArray) -> FloatArray:
    """MAC between each mode at rest and at each speed; shape (S, A, 3)."""
    weight = _mass_of_stations(engine.mechanism)
    shapes = []
    for speed in SPEEDS:
        system = engine.linear_system(crank_angles, speed, modes=MODES, detail=1.0)
        shapes.append(system.displacements(solve_modes(system, MODES).vectors))
    at_rest = shapes[0]

    def product(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
        return np.asarray(np.einsum("amlsc,ls,amlsc->am", a.conj(), weight, b))

    energy = [product(shape, shape).real for shape in shapes]
    return np.stack(
        [
            np.abs(product(at_rest, shape)) ** 2 / (energy[0] * own)
            for shape, own in zip(shapes[1:], energy[1:], strict=True)
        ]
    )


def _mass_of_stations(mechanism: Mechanism) -> FloatArray:
    """Mass that each station stands for (trapezoidal rule), kg; shape (n_links, 21)."""
    topology = mechanism.linkage.topology
    rule = np.ones(21)
    rule[[0, -1]] = 0.5
    links = [mechanism.sections[link.name].mass_per_length * link.length for link in topology.links]
    return np.outer(links, rule / rule.sum())


def _draw_likeness(answers: dict[str, ShapeAnswer]) -> Figure:
    """What MAC lacks to 1 at the highest speed against crank angle, one panel a mechanism."""
    with plots.sheet(plots.grid(1, len(answers), 2.5, sharey=True)) as drawn:
        for axes, (name, answer) in zip(drawn.panels, answers.items(), strict=True):
            angles = np.round(np.degrees(answer.crank_angles), 9).astype(float)
            for mode in range(MODES):
                axes.plot(angles, 1 - answer.mac[-1, :, mode], **plots.series_line(mode))
            axes.set_title(f"{name.capitalize()} four-bar")
            plots.crank_angle_axis(axes, angles, narrow=True)
        drawn.label_x("Crank angle (deg)")
        drawn.panels[0].set_yscale("log")
        drawn.panels[0].set_ylabel("1 \N{MINUS SIGN} MAC (-)")
        drawn.header(
            [plots.series_handle(n, f"mode {n + 1}") for n in range(MODES)],
            f"Difference of the mode shapes at rest and at {plots.speed_label(SPEEDS[-1])}",
        )
    return drawn.figure


def _report(answers: dict[str, ShapeAnswer]) -> None:
    for name, answer in answers.items():
        print(f"{name} four-bar, MAC between the shapes at rest and at speed:")
        for number, speed in enumerate(SPEEDS[1:]):
            for mode in range(MODES):
                mac = answer.mac[number, :, mode]
                worst = int(mac.argmin())
                angle = np.degrees(answer.crank_angles[worst])
                print(
                    f"  {speed:g} rad/s, mode {mode + 1}: {mac[0]:.5f} at 0 deg "
                    f"({answer.frequencies[0, mode]:.3f} Hz at rest, "
                    f"{answer.frequencies[number + 1, mode]:.3f} Hz at speed); "
                    f"over the turn at least {mac[worst]:.5f}, at {angle:.0f} deg"
                )
        print(
            f'  claim: the shapes "are very consistent in each other" (MAC above {CONSISTENT:g}): '
            f"{answer.verdict}, the least is {answer.mac.min():.5f}"
        )


if __name__ == "__main__":
    main(output_folder(__doc__, "results/mode_shapes"))
