"""Crank angles and places on links at which peaks are sought."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.extremes import with_steps
from flexmech.analyses.strength.joint_loads import cuts_of
from tests.support.mechanisms import case


def test_angles_that_differ_by_round_off_are_one() -> None:
    """A peak is sought between the neighbours of its own angle, not between two that are one."""
    angles = np.linspace(0.0, 2.0, 21)
    shaken = np.sort(angles * (1.0 + 1e-15 * (-1.0) ** np.arange(21)))
    found = with_steps(shaken, 0.1)
    assert len(found) == 21
    assert np.diff(found).min() > 0.09


def test_places_that_differ_by_round_off_are_one() -> None:
    """Searches by two stresses meet at a place: its row stood twice in the tables."""
    mechanism = case("aluminium four-bar").mechanism
    further = [0.11, 0.11 * (1.0 + 1e-15), 0.2]
    assert len(cuts_of(mechanism, "coupler", 4, further).place) == 7
