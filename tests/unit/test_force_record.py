"""Joint forces and torque of a run, as far as a band lets them through."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.time_domain.recorded_runs.recording import ForceRecord

BAND, STEP = 400.0, 1e-4


def recorded(sample_time, *, blocks):
    """A slow force on which one rings that is too fast for the band."""
    record = ForceRecord(sample_time, STEP, BAND)
    time = STEP * np.arange(record.steps + 1)
    slow, fast = np.cos(40.0 * time), 3.0 * np.sin(2 * np.pi * 2.5 * BAND * time)
    force = np.stack([slow + fast, 0.5 * slow], axis=-1)[:, None]
    for some in np.array_split(np.arange(len(time)), blocks):
        record.add(force[some], 2.0 * (slow + fast)[some])
    record.finish()
    return record


@pytest.mark.parametrize("blocks", [1, 7])
def test_what_comes_after_the_last_sample_counts_in_the_filter_alone(blocks: int) -> None:
    """A mirror image in its place would leave a part of what rings at the end."""
    whole = np.arange(0.0, 0.3, 4 * STEP)
    first = whole[: len(whole) // 2]
    longer, shorter = recorded(whole, blocks=blocks), recorded(first, blocks=blocks)
    kept = longer.joint_force[: len(first)]
    np.testing.assert_allclose(shorter.joint_force, kept, atol=1e-12)
    assert shorter.joint_force.shape == (len(first), 1, 2)
    np.testing.assert_allclose(shorter.driving_torque[-1], 2 * np.cos(40 * first[-1]), atol=0.01)
    until = slice(None, len(first))
    assert shorter.peak_driving_torque == pytest.approx(
        np.abs(longer.driving_torque[until]).max(), rel=1e-3
    )


def test_the_peak_of_a_force_is_its_size() -> None:
    """Of both components together, at any step; of the torque whatever its sign is."""
    record = ForceRecord(np.array([0.0, 4 * STEP]), STEP, None)
    force = np.zeros((5, 2, 2))
    force[1, 0], force[3, 1] = (3.0, -4.0), (-5.0, 12.0)
    record.add(force, np.array([0.0, 1.0, -7.0, 2.0, 0.0]))
    record.finish()
    np.testing.assert_allclose(record.peak_joint_force, [5.0, 13.0])
    assert record.peak_driving_torque == 7.0
