"""Has the running linkage sidebands that its frozen positions do not show?

The aluminium four-bar at 20 rad/s with a damping ratio of 1 %, a force on the middle of the coupler
and the displacement of the middle of the rocker, across both. The running linkage is a periodic
system: a force at f answers at f + n f_crank too. The harmonic transfer functions of its linear
equations stand beside the receptance of the frozen linkage.

    python scenarios/running_hammer_test.py [--out results/running_hammer_test]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import (
    LinkPoint,
    ReferenceEngine,
    RunningHammerRequest,
    RunningHammerTest,
    running_hammer_test,
)

SPEED, DAMPING_RATIO = 20.0, 0.01
HIT, SEEN = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)


def told(found: RunningHammerTest) -> list[str]:
    """Peaks of the orders, and how far the frozen linkage is from them."""
    data = found.dataset
    frozen = np.hypot(data["frozen_real"], data["frozen_imag"]).max("frequency")
    return [
        f"order {peak.order:+d}: {peak.peak_m_N:.3e} m/N at {peak.peak_frequency_Hz:.2f} Hz; the "
        f"frozen linkage says {float(frozen.sel(order=peak.order)) / peak.peak_m_N:.2f} times that"
        for peak in found.peaks().itertuples()
    ]


def main(out: Path, elements: int = 4, damping_ratio: float = DAMPING_RATIO) -> RunningHammerTest:
    """Solve, draw the picture and tell the numbers."""
    request = RunningHammerRequest(SPEED, HIT, SEEN, damping_ratio=damping_ratio)
    found = running_hammer_test(ReferenceEngine(four_bar("aluminium"), elements), request)
    print("\n".join(told(found)))
    save_pictures({"harmonic_frf": found.plot()}, out)
    return found


if __name__ == "__main__":
    main(output_folder(__doc__, "results/running_hammer_test"))
