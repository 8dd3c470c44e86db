"""The search where designs cost a second or more, on outputs that are known in closed form.

They stand in the place of the stress and mass of a coupler of some thickness: stress falls with its
square and rises where a multiple of the crank speed meets a natural frequency.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from flexmech.studies import Goal, Limit, Output, Study
from flexmech.studies.campaign import KeptDesigns
from flexmech.studies.scatter import Scatter
from flexmech.studies.search import Search, by_model, most_by_model
from tests.support.study_data import Scripted, study, thickness

OUTPUTS = {"stress": Output("peak_stress"), "mass": Output("mass")}


def stress(thick: np.ndarray) -> np.ndarray:
    """In Pa; of a resonance at 4.3 mm, and rising slowly from 9 mm on."""
    resonance = 1 + 0.05 / np.hypot((thick / 4.3e-3) ** 2 - 1, 0.02)
    return 60e6 * (8e-3 / thick) ** 2 * resonance * (1 + (thick / 12e-3) ** 4)


def of_one(designs: np.ndarray) -> np.ndarray:
    thick = designs[:, 0]
    return np.stack([stress(thick), 0.4 + 8.0 * thick], axis=1)


def searched(whole: Study, function) -> tuple[np.ndarray, Search]:
    """The best designs, and the search for them."""
    computed = KeptDesigns.of(
        whole, Scripted(function), None, resume=False, most=most_by_model(whole), content={}
    )
    search = Search(whole, computed, Scatter.of(whole))
    return by_model(search), search


@pytest.mark.parametrize("bound", [80e6, 100e6, 150e6])
def test_the_lightest_design_within_a_stress_is_found_by_two_dozen_designs(bound):
    limits = (Limit("stress", greatest=bound),)
    whole = study(thickness(4e-3, 12e-3), outputs=OUTPUTS, limits=limits, goals=(Goal("mass"),))
    best, search = searched(whole, of_one)
    exact = scipy.optimize.brentq(lambda thick: stress(thick) - bound, 4.4e-3, 9e-3)
    assert best[0, 0] == pytest.approx(exact, abs=8e-3 * 5e-4)
    assert stress(best[0, 0]) <= bound
    assert search.count <= 26


def test_where_no_design_keeps_the_limit_the_nearest_is_given():
    limits = (Limit("stress", greatest=20e6),)
    whole = study(thickness(4e-3, 12e-3), outputs=OUTPUTS, limits=limits, goals=(Goal("mass"),))
    best, search = searched(whole, of_one)
    least = scipy.optimize.minimize_scalar(stress, bounds=(6e-3, 12e-3), method="bounded").x
    assert search.design is None
    assert stress(best[0, 0]) == pytest.approx(stress(least), rel=1e-4)


def test_the_front_of_stress_and_mass_is_that_of_the_curve_between_its_ends():
    whole = study(thickness(4e-3, 12e-3), outputs=OUTPUTS, goals=(Goal("stress"), Goal("mass")))
    best, search = searched(whole, of_one)
    thick = np.sort(best[:, 0])
    least = scipy.optimize.minimize_scalar(stress, bounds=(6e-3, 12e-3), method="bounded").x
    assert search.count <= 30
    assert thick[0] == pytest.approx(4e-3)
    assert stress(thick[-1]) == pytest.approx(stress(least), rel=1e-3)
    # No gap of the front is wider than a tenth of its span of masses, but for the resonance.
    wide = np.diff(thick[thick > 4.6e-3])
    assert wide.max() < 0.15 * (thick[-1] - thick[0])
    grid = np.linspace(4e-3, 12e-3, 2001)
    for one in thick:
        lighter = grid[grid < one - 8e-3 * 5e-3]
        assert not np.any(stress(lighter) < stress(one) * (1 - 0.01))


def test_of_two_thicknesses_the_lightest_are_equal_where_a_corner_fails():
    """The least sum within a product; a third thickness has one value."""

    def of_two(designs: np.ndarray) -> np.ndarray:
        first, second, _ = 1e3 * designs.T
        values = np.stack([1e9 / (first * second), first + second], axis=1)
        values[(first < 1.5) & (second < 1.5)] = np.nan
        return values

    pair = (
        thickness(1e-3, 5e-3),
        thickness(1e-3, 5e-3, link="rocker"),
        thickness(4e-3, distribution="values", link="crank"),
    )
    limits = (Limit("stress", greatest=1e9 / 9),)
    whole = study(*pair, outputs=OUTPUTS, limits=limits, goals=(Goal("mass"),))
    best, search = searched(whole, of_two)
    assert best[0, :2].sum() == pytest.approx(6e-3, rel=2e-3)
    assert best[0, :2].prod() >= 9e-6
    assert search.count <= most_by_model(whole)


def test_of_listed_values_each_is_computed_once():
    listed = thickness(4e-3, 6e-3, 8e-3, distribution="values")
    limits = (Limit("stress", greatest=130e6),)
    best, search = searched(
        study(listed, outputs=OUTPUTS, limits=limits, goals=(Goal("mass"),)), of_one
    )
    assert best[0, 0] == 6e-3
    assert search.count == 3
