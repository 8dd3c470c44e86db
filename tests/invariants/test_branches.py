"""Branches of frequency maps: the same by any step, smooth, home after a turn; and their lines."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    Mechanism,
    MovingFrequencies,
    ReferenceEngine,
    moving_frequencies,
    natural_frequencies,
)
from tests.support.random_mechanisms import random_case


def degrees(step: float) -> Any:
    return np.radians(np.arange(0.0, 360.0 + step / 2, step))


@pytest.mark.parametrize(
    ("seed", "runs"),
    [
        (0, True),
        *(pytest.param(seed, seed % 2 == 0, marks=pytest.mark.thorough) for seed in range(6, 12)),
    ],
)
def test_coarse_maps_number_their_branches_as_the_map_of_one_degree(
    seed: int, *, runs: bool
) -> None:
    case = random_case(seed)
    engine, speed = ReferenceEngine(case.mechanism, 4), runs * case.crank_speed
    numbers = {}
    for step in (1, 5, 30):
        data = moving_frequencies(engine, degrees(step), [speed], modes=4).dataset
        numbers[step] = data["branch_of_mode"].values[0, 0]
        assert not data["branch_unclear"].any()
    for step in (5, 30):
        np.testing.assert_array_equal(numbers[step], numbers[1][::step])


def test_branches_of_the_aluminium_four_bar_are_smooth_and_come_home(
    aluminium: Mechanism,
) -> None:
    engine, angles = ReferenceEngine(aluminium, 4), degrees(5.0)
    data = moving_frequencies(engine, angles, [0.0, 20.0]).dataset.isel(engine=0)
    plain = natural_frequencies(engine, angles, 20.0)
    assert data["frequency"].values[1] == pytest.approx(plain, rel=1e-4)
    assert data["branch_whole"].sel(branch=[1, 2, 3]).all()
    for speed in (0, 1):
        frequency = data["frequency"].values[speed]
        number = data["branch_of_mode"].values[speed]
        assert (number[0] == number[-1]).all()
        assert all(len(set(row)) == 4 for row in number.tolist())
        for branch in (1, 2, 3):
            along = frequency[number == branch]
            assert len(along) == len(angles)
            assert np.abs(np.diff(along, 2)).max() < 0.03 * along.mean()


def test_branches_of_unsymmetric_links_do_not_swap(aluminium: Mechanism) -> None:
    sections = {
        name: replace(section, neutral_axis=0.2 * section.in_plane_thickness, layers=None)
        for name, section in aluminium.sections.items()
    }
    engine = ReferenceEngine(replace(aluminium, sections=sections), 4)
    found = moving_frequencies(engine, degrees(10.0), [0.0], modes=2).dataset
    assert found["mac"].max() < 1 + 1e-9
    assert (found["branch_of_mode"][0, 0, :, 0] == 1).all()


@pytest.fixture(scope="module")
def smooth(aluminium: Mechanism) -> MovingFrequencies:
    return moving_frequencies(
        ReferenceEngine(aluminium, 2),
        degrees(5.0),
        [0.0, 20.0],
        shapes_at=np.radians([45.0, 77.5]),
        smooth=True,
    )


def test_points_between_the_angles_of_a_map_are_solutions_of_their_branch(
    smooth: MovingFrequencies, aluminium: Mechanism
) -> None:
    data, engine = smooth.dataset, ReferenceEngine(aluminium, 2)
    some = data.isel(between_angle=slice(None, None, 7))
    wanted = natural_frequencies(engine, some["between_angle"].values, 20.0)
    np.testing.assert_allclose(some["frequency_between"].sel(crank_speed=20.0), wanted, rtol=2e-5)
    # The branch is that of the angles on both sides, where these have the same.
    after = np.searchsorted(degrees(5.0), data["between_angle"].values)
    branch, between = data["branch_of_mode"].values[0], data["branch_between"].values
    known = between > 0
    np.testing.assert_array_equal(between[known], branch[:, after][known])
    assert known.mean() > 0.9


def test_shapes_asked_for_have_the_frequencies_of_their_angle(
    smooth: MovingFrequencies, aluminium: Mechanism
) -> None:
    data, engine = smooth.dataset, ReferenceEngine(aluminium, 2)
    wanted = natural_frequencies(engine, np.radians([45.0, 77.5]), 20.0)
    np.testing.assert_allclose(data["asked_frequency"].sel(crank_speed=20.0), wanted, rtol=2e-5)
    stored = moving_frequencies(engine, degrees(5.0)[9:10], [20.0]).dataset["mode_shape"]
    one, other = (
        array.sel(part="real").values + 1j * array.sel(part="imaginary").values
        for array in (
            data["asked_shape"].sel(crank_speed=20.0).isel(shape_angle=0),
            stored.isel(engine=0, crank_speed=0, check_angle=0),
        )
    )
    for asked, kept in zip(one, other, strict=True):
        overlap = abs(np.vdot(asked, kept)) / np.linalg.norm(asked) / np.linalg.norm(kept)
        assert overlap == pytest.approx(1.0, abs=1e-4)
