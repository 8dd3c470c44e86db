"""At which crank speeds does a four-bar ring?

The steady-state peak deflection of the steel and the aluminium four-bar of Kumar & Chandrakar
against crank speed, each speed's periodic motion found directly. Loads repeat with every turn,
so the linkage rings where a natural frequency divided by a whole number is the turning
frequency; these critical speeds are marked, each as the range over which the frequency moves.
The paper's links have no damping; Kelvin-Voigt damping of 1 % in the first mode is assumed.
At a few speeds the periodic motion of Exudyn's nonlinear equations stands beside.

    python scenarios/critical_speeds.py [--out results/critical_speeds]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import (
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    SpeedSweep,
    natural_frequencies,
    speed_sweep,
)
from flexmech.analyses import deflections
from flexmech.arrays import FloatArray
from flexmech.time_domain import nonlinear_orbit

SPEEDS = np.linspace(8.0, 30.0, 89)
NONLINEAR = (10.0, 15.0, 20.0, 25.0)
DAMPING_RATIO = 0.01


@dataclass(frozen=True)
class CriticalSpeedAnswer:
    """One four-bar over crank speed.

    Parameters
    ----------
    sweep : SpeedSweep
        Linear periodic motion; at some speeds also the nonlinear one, as ``settled_peak``.
    """

    sweep: SpeedSweep

    @property
    def gap(self) -> float:
        """Greatest relative difference of both at these speeds, coupler and rocker."""
        data = self.sweep.dataset
        pinned = data.isel(link=(data["probe"] == "middle").values)
        nonlinear = pinned["settled_peak"].rename(settled_speed="crank_speed")
        speeds = nonlinear["crank_speed"]
        linear = pinned["peak_deflection"].sel(crank_speed=speeds, method="nearest")
        return float(np.abs(linear.values / nonlinear.values - 1).max())

    @property
    def ringing(self) -> float:
        """Crank speed in rad/s where the coupler most exceeds the parabola of a stiff linkage."""
        coupler = self.sweep.dataset["peak_deflection"].sel(link="coupler")
        return float((coupler / coupler["crank_speed"] ** 2).idxmax())


def main(
    out: Path,
    *,
    names: tuple[str, ...] = ("steel", "aluminium"),
    speeds: FloatArray = SPEEDS,
    nonlinear: tuple[float, ...] = NONLINEAR,
    elements: int = 8,
) -> dict[str, CriticalSpeedAnswer]:
    """Sweep the crank speed of both four-bars, print where they ring, draw it.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    names : tuple of str
        Which four-bars.
    speeds : ndarray, shape (S,)
        Crank speeds in rad/s; ``nonlinear`` lie among them.
    nonlinear : tuple of float
        Speeds of Exudyn's nonlinear motions.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to CriticalSpeedAnswer
        By ``"steel"`` and ``"aluminium"``.
    """
    answers, figures = {}, {}
    for name in names:
        mechanism = with_damping(four_bar(name))
        sweep = speed_sweep(ReferenceEngine(mechanism, elements), speeds)
        peaks = np.stack([_nonlinear_peak(mechanism, elements, speed) for speed in nonlinear])
        data = sweep.dataset.assign_coords(settled_speed=list(nonlinear))
        data["settled_peak"] = (("settled_speed", "link"), peaks, {"units": "m"})
        answer = answers[name] = CriticalSpeedAnswer(SpeedSweep(data))
        figures[f"{name}_critical_speeds"] = answer.sweep.plot()
        print(answer.sweep.summary())
        print(
            f"{name} four-bar: rings most at {answer.ringing:.4g} rad/s; nonlinear peaks differ "
            f"from the linear ones by at most {100 * answer.gap:.2f} %"
        )
    save_pictures(figures, out)
    return answers


def with_damping(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the assumed damping ratio at its lowest natural frequency."""
    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    lowest = natural_frequencies(ReferenceEngine(mechanism), turn, modes=1).min()
    time = 2 * DAMPING_RATIO / (2 * np.pi * lowest)
    sections = {name: s.with_damping_time(time) for name, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def _nonlinear_peak(mechanism: Mechanism, elements: int, speed: float) -> FloatArray:
    """Greatest deflections over a turn of Exudyn's periodic motion, (n_links,)."""
    engine = ExudynEngine(mechanism, elements)
    displacement, _ = nonlinear_orbit(engine, speed).at(np.radians(np.arange(0.0, 360.0, 0.5)))
    return np.asarray(np.abs(deflections(engine, displacement)).max(axis=0))


if __name__ == "__main__":
    main(output_folder(__doc__, "results/critical_speeds"))
