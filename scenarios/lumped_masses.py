"""What do twelve lumped masses change in the joint forces of a four-bar?

Kumar & Chandrakar replace the distributed mass of their links by twelve lumped masses (Figure
1.5): the crank has one element, coupler and rocker have four, and each element's mass is halved
onto its ends. Mass and centre of mass stay, moments of inertia grow. Joint forces and driving
torque of the aluminium four-bar at 190 rpm by both, and by finer lumps: the difference falls with
the square of the number of elements.

    python scenarios/lumped_masses.py [--out results/lumped_masses]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import Kinematics, kinematics, plots

SPEED = 190.0
PAPER = (1, 4, 4)
FINER = (1, 2, 4)
"""Times as many elements as the paper has."""


@dataclass(frozen=True)
class LumpedAnswer:
    """Forces by distributed and by lumped masses.

    Parameters
    ----------
    result : Kinematics
        With the paper's lumped masses.
    force_excess, torque_excess : dict of int to float
        How much the greatest force of pin B and the greatest torque are larger by lumped masses,
        as a part of those by distributed ones, by how many times finer the elements are.
    """

    result: Kinematics
    force_excess: dict[int, float]
    torque_excess: dict[int, float]


def main(out: Path) -> LumpedAnswer:
    """Compare the joint forces, print by how much they differ, draw them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.

    Returns
    -------
    LumpedAnswer
    """
    mechanism = four_bar("aluminium")
    results = {
        times: kinematics(mechanism, SPEED, lumped=[times * n for n in PAPER], speed_unit="rpm")
        for times in FINER
    }
    answer = LumpedAnswer(
        results[1],
        {times: _excess(result, "joint_force") for times, result in results.items()},
        {times: _excess(result, "driving_torque") for times, result in results.items()},
    )
    print(answer.result.summary())
    for times, result in results.items():
        print(
            f"{result.dataset.sizes['lump']} lumped masses: greatest force of pin B "
            f"{100 * answer.force_excess[times]:+.2f} %, greatest torque "
            f"{100 * answer.torque_excess[times]:+.2f} %"
        )
    data = answer.result.dataset
    figures = {"joint_forces": plots.plot_joint_forces(data), "drive": plots.plot_drive(data)}
    save_pictures(figures, out)
    return answer


def _excess(result: Kinematics, name: str) -> float:
    """Greatest value by lumped masses over that by distributed ones, less one."""
    data = result.dataset
    sizes = []
    for variable in (f"lumped_{name}", name):
        values = data[variable]
        if "joint" in values.dims:
            values = values.sel(joint="B")
            sizes.append(float(np.hypot(*(values.sel(component=axis) for axis in "xy")).max()))
        else:
            sizes.append(float(abs(values).max()))
    return sizes[0] / sizes[1] - 1


if __name__ == "__main__":
    main(output_folder(__doc__, "results/lumped_masses"))
