"""Does a hammer see the running linkage's sidebands where the periodic model predicts them?

The aluminium four-bar at 20 rad/s with a damping ratio of 1 %, hit in the middle of the coupler
and read in the middle of the rocker, across both. The running linkage is a periodic system: a
force at f answers at f + n f_crank too. Exudyn runs the nonlinear motion with an impact at each of
13 jittered crank angles, and without one. Least squares tell the orders apart; each impact is
repeated with half the force. The harmonic transfer functions of the time-varying linear model and
the receptance of the frozen linkage stand beside.

    python scenarios/running_hammer_test.py [--out results/running_hammer_test]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import (
    ExudynEngine,
    LinkPoint,
    RunningHammerRequest,
    RunningHammerTest,
    running_hammer_test,
)

SPEED, DAMPING_RATIO = 20.0, 0.01
HIT, SEEN = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
AGREES = 0.05


def told(found: RunningHammerTest) -> list[str]:
    """Peaks of the sidebands, and how far the frozen linkage is from them."""
    data = found.dataset
    frozen = np.hypot(data["frozen_real"], data["frozen_imag"]).max("frequency")
    lines = []
    for peak in found.peaks().itertuples():
        apart = 100 * (peak.identified_m_N / peak.predicted_m_N - 1)
        away = float(frozen.sel(order=peak.order)) / peak.identified_m_N
        lines.append(
            f"order {peak.order:+d}: identified {peak.identified_m_N:.3e} m/N at "
            f"{peak.identified_frequency_Hz:.2f} Hz, {apart:+.1f} % from the prediction, "
            f"{peak.bins_apart} bins; the frozen linkage says {away:.2f} times that"
        )
    return lines


def judged(found: RunningHammerTest) -> str:
    """Whether the sidebands are where they are predicted; one that is not found is not."""
    sides = found.peaks().query("order != 0")
    apart = float(np.max(np.abs(sides["identified_m_N"] / sides["predicted_m_N"] - 1).to_numpy()))
    bins = int(sides["bins_apart"].max())
    verdict = "agree" if apart <= AGREES and bins <= 1 else "do not agree"
    return (
        f"the first {len(sides) // 2} sidebands on each side {verdict} within {100 * AGREES:g} % "
        f"and one bin: {100 * apart:.1f} % and {bins} bins apart at most"
    )


def main(out: Path, elements: int = 4, damping_ratio: float = DAMPING_RATIO) -> RunningHammerTest:
    """Hit, identify, predict, draw the picture and tell the numbers."""
    request = RunningHammerRequest(SPEED, HIT, SEEN, damping_ratio=damping_ratio)
    found = running_hammer_test(ExudynEngine(four_bar("aluminium"), elements), request)
    print("\n".join(told(found)))
    print(judged(found))
    save_pictures({"harmonic_frf": found.plot()}, out)
    return found


if __name__ == "__main__":
    main(output_folder(__doc__, "results/running_hammer_test"))
