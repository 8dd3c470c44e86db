"""Critical speeds against the peaks of the periodic motion, which knows nothing of them.

The motion is of the linear equations that vary with time: no frequency is computed for it.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, Mechanism, ReferenceEngine, campbell

# A peak over the quasi-static one that is more than a ripple.
LEAST_PEAK = 1.5
STEP = 0.25


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "speeds"),
    [("aluminium", np.arange(20.0, 40.1, STEP)), ("steel", np.arange(35.0, 60.1, STEP))],
)
def test_peaks_lie_in_bands(
    mechanisms: dict[str, Mechanism], name: str, speeds: np.ndarray
) -> None:
    engine = ReferenceEngine(mechanisms[name])
    result = campbell(engine, speeds, orders=np.arange(1, 21), modes=3, response=True)
    table = result.critical_speeds().query("nearest_relative_gap == 0")
    ratio = result.dataset["peak_ratio"].values
    speed = result.dataset["response_speed"].values
    peaks = (ratio[1:-1] > ratio[:-2]) & (ratio[1:-1] > ratio[2:]) & (ratio[1:-1] > LEAST_PEAK)
    assert peaks.sum() >= 3
    for place in np.flatnonzero(peaks.any(axis=1)) + 1:
        low, high = speed[place - 1], speed[place + 1]
        assert np.any((table["from_rad_s"] <= high) & (table["to_rad_s"] >= low)), speed[place]


def test_engines_agree(aluminium: Mechanism) -> None:
    engines = [ReferenceEngine(aluminium, 4), ExudynEngine(aluminium, 4)]
    angles = np.radians(np.arange(0.0, 360.0, 45.0))
    result = campbell(engines, [25.0, 30.0], crank_angles=angles, orders=[10], modes=1)
    table = result.critical_speeds().set_index("engine")
    reference, exudyn = (table.loc[name] for name in ("reference", "exudyn"))
    for end in ("from_rad_s", "to_rad_s"):
        np.testing.assert_allclose(exudyn[end], reference[end], rtol=1e-3)
    assert "differ by at most" in result.summary().details[-1]
