"""Lowest and highest frequencies are those of the turn, not of its grid of crank angles."""

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    ReferenceEngine,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.analyses.frequencies import extremes
from tests.support.random_mechanisms import random_case

GRID = np.radians(np.arange(0, 361, 5.0))
SEEDS = [17, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(20))]


def extremes_and_grid(engine, speed):
    result = moving_frequencies(engine, GRID, [speed])
    data = result.dataset.isel(engine=0, crank_speed=0)
    error = data["discretisation_error"].max("check_angle") + data["reduction_error"].max(
        "check_angle"
    )
    return result.extremes().isel(engine=0, crank_speed=0), error.values


def frequencies_near(engine, speed, angles, mode):
    """Around one angle, from 1 degree before to 1 degree behind, every 0.02 degrees."""
    near = float(angles) + np.radians(np.linspace(-1, 1, 101))
    return natural_frequencies(engine, near, speed)[:, mode]


@pytest.mark.parametrize("seed", SEEDS)
def test_extremes_of_random_mechanisms(seed):
    """Within the error that is printed; of seed 17 a parabola over steps of 5 degrees is blind."""
    case = random_case(seed)
    engine = ReferenceEngine(case.mechanism, 8, "euler")
    found, error = extremes_and_grid(engine, case.crank_speed)
    turn = natural_frequencies(engine, np.radians(np.arange(0, 360, 0.5)), case.crank_speed)
    for mode in range(4):
        low, high = (float(found[name][mode]) for name in ("lowest", "highest"))
        allowed = error[mode] + 2e-7
        assert turn[:, mode].min() > low * (1 - allowed)
        assert turn[:, mode].max() < high * (1 + allowed)
        around = frequencies_near(engine, case.crank_speed, found["lowest_angle"][mode], mode)
        assert low == pytest.approx(around.min(), rel=allowed)
        around = frequencies_near(engine, case.crank_speed, found["highest_angle"][mode], mode)
        assert high == pytest.approx(around.max(), rel=allowed)


def test_both_engines_find_the_same(aluminium):
    """57.7229 Hz between two angles, where 57.8079 Hz stands at the nearest of the grid."""
    lowest = []
    for kind in (ReferenceEngine, ExudynEngine):
        found, _ = extremes_and_grid(kind(aluminium, 8), 20.0)
        lowest.append(found["lowest"].values)
    np.testing.assert_allclose(lowest[1], lowest[0], rtol=1e-4)


def test_an_extreme_at_the_end_of_a_range_stays_there(aluminium):
    engine = ReferenceEngine(aluminium, 8)
    angles = np.radians([10.0, 12.0, 14.0])
    found = moving_frequencies(engine, angles, [0.0]).extremes().isel(engine=0, crank_speed=0)
    values = natural_frequencies(engine, angles)
    np.testing.assert_allclose(found["lowest"], values.min(axis=0), rtol=1e-6)
    np.testing.assert_allclose(found["highest"], values.max(axis=0), rtol=1e-6)


def test_angles_far_apart_are_positions_and_no_curve(aluminium):
    """The lowest of three positions 60 degrees apart is one of them, not what lies between."""
    engine = ReferenceEngine(aluminium, 4)
    angles = np.radians([30.0, 90.0, 150.0])
    found = moving_frequencies(engine, angles, [0.0]).extremes().isel(engine=0, crank_speed=0)
    values = natural_frequencies(engine, angles)
    np.testing.assert_allclose(found["lowest"], values.min(axis=0), rtol=1e-6)
    np.testing.assert_allclose(found["highest"], values.max(axis=0), rtol=1e-6)


def test_flat_curves_are_not_searched(models, monkeypatch):
    """An arm has the same frequencies at every angle: minima by round-off are none."""
    engine = ReferenceEngine(load_mechanism(models / "rotating_arm_slender_70.toml"), 8)

    def refuse(*_):
        raise AssertionError("searched")

    monkeypatch.setattr(extremes, "frequencies_at_trials", refuse)
    data = moving_frequencies(engine, GRID, [4.0]).dataset
    least = data["frequency"].min("crank_angle").values
    np.testing.assert_array_equal(data["lowest_frequency"].values, least)


def test_only_the_mesh_that_is_fine_enough_is_mapped(models):
    """Of the coarser ones the errors are asked for alone: progress runs once."""
    engine = ReferenceEngine(load_mechanism(models / "aluminium_fourbar.toml"), 2, "euler")
    steps = []
    result = moving_frequencies(
        engine,
        GRID,
        [0.0, 20.0],
        tolerance=1e-3,
        progress=lambda _, done, total: steps.append((done, total)),
    )
    assert result.dataset["elements"].item() > 2
    assert result.dataset["discretisation_error"].max() <= 1e-3
    dones = [done for done, _ in steps]
    assert dones == sorted(set(dones))
    assert steps[-1] == (2 * len(GRID), 2 * len(GRID))
