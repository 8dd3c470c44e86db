"""At which crank speeds does a four-bar ring?

The steel and the aluminium four-bar of Kumar & Chandrakar against crank speed. Loads repeat with
every turn, so the linkage rings where a natural frequency divided by a whole number is the turning
frequency; these critical speeds are ranges, over which the frequency moves. The peak deflection of
the periodic motion tells which of them count. The paper's links have no damping; Kelvin-Voigt
damping of 1 % in the first mode is assumed. At a few speeds the periodic motion by Exudyn stands
beside.

    python scenarios/critical_speeds.py [--out results/critical_speeds]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import (
    CampbellDiagram,
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    campbell,
    natural_frequencies,
    response,
)
from flexmech.analyses import deflections
from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine
from flexmech.solvers import nonlinear_orbit

SPEEDS = np.linspace(8.0, 30.0, 45)
COMPARED = (10.0, 15.0, 20.0, 25.0)
DAMPING_RATIO = 0.01


@dataclass(frozen=True)
class CriticalSpeedAnswer:
    """One four-bar over crank speed.

    Parameters
    ----------
    diagram : CampbellDiagram
    ringing : float
        Crank speed in rad/s where the coupler most exceeds the parabola of a stiff linkage.
    gap : float
        Greatest relative difference of both engines' peaks, coupler and rocker.
    """

    diagram: CampbellDiagram
    ringing: float
    gap: float


def main(
    out: Path,
    *,
    names: tuple[str, ...] = ("steel", "aluminium"),
    speeds: FloatArray = SPEEDS,
    compared: tuple[float, ...] = COMPARED,
    elements: int = 8,
) -> dict[str, CriticalSpeedAnswer]:
    """Draw the critical speeds of both four-bars, and tell where they ring.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    names : tuple of str
        Which four-bars.
    speeds : ndarray, shape (S,)
        Crank speeds in rad/s.
    compared : tuple of float
        Speeds at which Exudyn finds the motion too.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to CriticalSpeedAnswer
        By ``"steel"`` and ``"aluminium"``.
    """
    answers = {}
    for name in names:
        mechanism = with_damping(four_bar(name))
        engine = ReferenceEngine(mechanism, elements)
        diagram = campbell(engine, speeds, modes=2, orders=np.arange(1, 25))
        peaks = np.stack([_peaks(engine, speed) for speed in speeds])
        ringing = float(speeds[np.argmax(peaks[:, 1] / speeds**2)])
        pairs = [
            (_peaks(engine, speed)[1:], _peaks_by_exudyn(mechanism, elements, speed)[1:])
            for speed in compared
        ]
        gap = max(float(np.abs(here / there - 1).max()) for here, there in pairs)
        answers[name] = CriticalSpeedAnswer(diagram, ringing, gap)
        print(diagram.summary())
        print(
            f"{name} four-bar: rings most at {ringing:.4g} rad/s; peaks by Exudyn differ from "
            f"those of the reference by at most {100 * gap:.2f} %"
        )
    pictures = {f"{name}_critical_speeds": each.diagram.plot() for name, each in answers.items()}
    save_pictures(pictures, out)
    return answers


def with_damping(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the assumed damping ratio at its lowest natural frequency."""
    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    lowest = natural_frequencies(ReferenceEngine(mechanism), turn, modes=1).min()
    time = 2 * DAMPING_RATIO / (2 * np.pi * lowest)
    sections = {name: s.with_damping_time(time) for name, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def _peaks(engine: Engine, speed: float) -> FloatArray:
    """Greatest deflections over a turn of the periodic motion in m: crank, coupler, rocker."""
    found = response(engine, speed, 1.0, start="periodic")
    return np.abs(found.peaks()["deflection"].isel(engine=0).values)


def _peaks_by_exudyn(mechanism: Mechanism, elements: int, speed: float) -> FloatArray:
    engine = ExudynEngine(mechanism, elements)
    displacement, _ = nonlinear_orbit(engine, speed).at(np.radians(np.arange(0.0, 360.0, 0.5)))
    return np.asarray(np.abs(deflections(engine, displacement)).max(axis=0))


if __name__ == "__main__":
    main(output_folder(__doc__, "results/critical_speeds"))
