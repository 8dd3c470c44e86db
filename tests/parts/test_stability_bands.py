"""Names of bands of growth by the frequencies that meet, and what damping closes them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexmech.analyses.stability.edges import BandName, band_name, closing_fits, multiplier_fits
from flexmech.analyses.stability.growth import Sample, runs_of_growth

USUAL = np.array([44.0, 49.0, 180.0])
ALIKE = [44.5, 49.0, 181.0]


@pytest.mark.parametrize(
    ("frequency", "part", "crank", "differences", "name"),
    [
        (ALIKE, [0.99, 0.05, 0.02], 89 / 7, False, ("principal", (1, 1), 7)),
        (ALIKE, [0.7, 0.7, 0.02], 93.5 / 6, False, ("sum", (1, 2), 6)),
        (ALIKE, [0.02, 0.7, 0.7], 132 / 11, True, ("difference", (2, 3), 11)),
        # Branch 3 carries the frequency that is usual for branch 2.
        ([44.0, 180.0, 49.0], [0.1, 0.1, 0.99], 14.0, False, ("principal", (2, 2), 7)),
        (ALIKE, [0.99, 0.0, 0.0], 89 / 7.5, False, ("unnamed", (), 0)),
    ],
)
def test_a_band_is_named_by_the_modes_whose_frequencies_meet_a_multiple_of_the_cranks(
    frequency: list[float], part: list[float], crank: float, differences: bool, name: Any
) -> None:
    found = band_name(
        np.array(frequency), np.array(part), USUAL, crank, 0.02, differences=differences
    )
    assert (found.kind, found.branches, found.order) == name


def test_differences_have_names_only_where_they_can_grow() -> None:
    part = np.array([0.02, 0.7, 0.7])
    found = band_name(np.array(ALIKE), part, USUAL, 132 / 11, 0.02, differences=False)
    assert found.kind != "difference"


@pytest.mark.parametrize(
    ("angle", "kind", "order", "fits"),
    [
        (1.0, "principal", 5, True),
        (1.0, "principal", 4, False),
        (0.0, "principal", 4, True),
        (0.5157, "principal", 5, False),
        (0.5157, "sum", 5, True),
        (0.3, "difference", 2, True),
    ],
)
def test_a_real_multiplier_is_that_of_one_mode_and_of_its_order(
    angle: float, kind: Any, order: int, fits: bool
) -> None:
    """Angles in half turns; the crank turns 20 times a second."""
    growing: Any = SimpleNamespace(
        exponent=np.array([1.0 + 20j * np.pi * angle, -1.0 + 300j]),
        angle=np.array([np.pi * angle, 1.0]),
        period=1 / 20,
        crank_speed=40 * np.pi,
    )
    branches = (1, 1) if kind == "principal" else (1, 2)
    assert multiplier_fits(BandName(kind, branches, order, 0.0, (50.0, 50.0)), growing) is fits


def test_a_name_fits_the_damping_that_closes_its_band() -> None:
    """By the growth of two modes that meet: ``(s + d_a) (s + d_b) = g^2``."""
    lowest, growth, start = 2 * np.pi * 43.0, 15.3, 1e-3
    name = BandName("sum", (1, 2), 5, 0.0, (43.0, 47.0))
    decay = (2 * np.pi * np.array([43.0, 47.0])) ** 2 / lowest
    closing = growth / np.sqrt(np.prod(decay))
    slower = np.roots([1.0, start * decay.sum(), start**2 * np.prod(decay) - growth**2]).max()
    for factor, fits in ((1.0, True), (1.9, True), (2.1, False), (1 / 2.1, False)):
        assert closing_fits(name, slower, start, factor * closing, lowest) is fits


def test_runs_of_growth_lie_between_speeds_at_which_nothing_grows() -> None:
    """Bands are open at the ends of the map and where the equilibrium ends."""

    def samples(growth: dict[float, float]) -> list[Sample]:
        return [Sample(speed, rate, rate) for speed, rate in growth.items()]

    runs = runs_of_growth(samples({1: -1, 2: 1, 3: 2, 4: -1, 5: 3, 6: -1}), [])
    assert [run.brackets for run in runs] == [((2, 1), (3, 4)), ((5, 4), (5, 6))]
    assert [run.fastest for run in runs] == [3, 5]
    runs = runs_of_growth(samples({1: 1, 2: 1, 4: 1, 5: -1}), [3.0])
    assert [run.brackets for run in runs] == [((1, 1), (2, 2)), ((4, 4), (4, 5))]
