"""Numbers of kinematics and its pictures: each test fails if its constant is another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import FourBar, KinematicsRequest, kinematics, load_mechanism
from flexmech.analyses.kinematics import extremes as searched
from flexmech.analyses.kinematics import words
from flexmech.analyses.kinematics.extremes import extremes, mean_over_turns
from flexmech.example_models import example_model
from flexmech.plots import motion, plot_motion
from tests.support.strategies import fourbar

WHOLE = np.array([0.0, 2 * np.pi])


def corner(angles):
    """A table of loads has a corner between the degrees; here it is the greatest value."""
    return 1.0 - np.abs(angles[:, None] - np.radians(100.37))


def test_corners_are_found_to_1e_9(monkeypatch):
    found = extremes(corner, WHOLE)
    assert abs(found.greatest[0] - 1.0) < 1e-9
    assert found.error[0] < 1e-8
    monkeypatch.setattr(searched, "_ZOOMS", 5)
    assert abs(extremes(corner, WHOLE).greatest[0] - 1.0) > 1e-9
    monkeypatch.undo()
    monkeypatch.setattr(searched, "_INSIDE", 9)
    assert abs(extremes(corner, WHOLE).greatest[0] - 1.0) > 1e-9


def test_a_degree_finds_peaks_that_four_degrees_miss(monkeypatch):
    """As sharp as the force of a linkage that passes a dead point within a few degrees."""

    def sharp(angles):
        narrow = np.exp(-(((angles - np.radians(101.0)) / np.radians(0.7)) ** 2))
        return (0.5 * np.cos(angles) ** 2 + narrow)[:, None]

    assert extremes(sharp, WHOLE).greatest[0] > 1.0
    monkeypatch.setattr(searched, "_STEP", np.radians(4.0))
    assert extremes(sharp, WHOLE).greatest[0] < 0.6


def test_a_maximum_at_the_end_of_a_turn_is_found_beyond_it():
    """Its angle is told within the turn."""

    def late(angles):
        return np.cos(angles - np.radians(359.7))[:, None]

    found = extremes(late, WHOLE)
    assert found.greatest[0] == pytest.approx(1.0, abs=1e-12)
    assert np.degrees(found.greatest_angle[0]) == pytest.approx(359.7, abs=1e-4)
    assert extremes(late, np.radians([0.0, 180.0])).greatest[0] == pytest.approx(late(WHOLE)[0, 0])


def test_what_is_constant_keeps_its_first_angle():
    rng = np.random.default_rng(1)
    found = extremes(lambda angles: 20.0 + 1e-14 * rng.random((angles.size, 1)), WHOLE)
    assert found.greatest_angle[0] == 0.0


def test_means_of_tables_are_known_to_1e_7(monkeypatch):
    """Triangles over part of a turn, with corners between all steps."""
    exact = 0.777 / (2 * np.pi)

    def farthest():
        """Greatest relative error of the mean of triangles here and there, and the one told."""
        apart, told = 0.0, 0.0
        for centre in 1.2 + 0.013 * np.arange(20):

            def triangle(angles, centre=centre):
                return np.maximum(0.0, 1.0 - np.abs(angles - centre) / 0.777)

            mean, error = mean_over_turns(triangle, WHOLE)
            apart, told = max(apart, abs(mean / exact - 1)), max(told, error / exact)
        return apart, told

    apart, told = farthest()
    assert apart < told < 3e-7
    monkeypatch.setattr(searched, "_HALVINGS", 2)
    assert farthest()[0] > 3e-7
    monkeypatch.undo()
    monkeypatch.setattr(searched, "_FEWEST_STEPS", 40)
    assert farthest()[0] > 3e-7
    assert mean_over_turns(np.cos, np.array([0.0, 5.0])) is None


def test_details_have_a_digit_more_than_answers_and_angles_a_tenth_of_a_degree(monkeypatch):
    lines = kinematics(fourbar(), 20.0).summary().lines
    (torque,) = (line for line in lines if line.startswith("driving torque: "))
    assert torque == "driving torque: -0.32984 N m (at 9.891 deg) to 0.20986 N m (at 326.2 deg)"
    monkeypatch.setattr(words, "_DETAILED", 4)
    monkeypatch.setattr(words, "_ANGLE_DIGITS", 2)
    lines = kinematics(fourbar(), 20.0).summary().lines
    assert torque not in lines


def test_no_error_below_the_digits_is_told(monkeypatch):
    trust = kinematics(fourbar(), 20.0).summary().trust
    assert trust == "numbers are known to 0.0001 %; links are rigid here"
    monkeypatch.setattr(words, "_TOLD", 0.0)
    assert "e-" in kinematics(fourbar(), 20.0).summary().trust


def test_a_turn_is_looked_at_every_degree(monkeypatch):
    """A drawn linkage with a gap of 40 degrees turns fully in steps of 90."""
    from flexmech.analyses.check import in_short
    from flexmech.analyses.kinematics import compute
    from tests.unit.test_planar_motion import drawn_as_planar

    swinging = drawn_as_planar(
        FourBar(ground=0.2, crank=0.19, coupler=0.18, rocker=0.18), np.pi / 3
    )
    assert not in_short.turns_fully(swinging)
    mechanism = replace(load_mechanism(example_model("aluminium_fourbar")), linkage=swinging)
    part = KinematicsRequest(np.radians([60.0, 70.0]), 20.0)
    assert kinematics(mechanism, part).summary().warnings
    for room in (in_short, compute):
        monkeypatch.setattr(room, "_TURN", np.radians([60.0, 70.0]))
    assert in_short.turns_fully(swinging)
    assert not kinematics(mechanism, part).summary().warnings


def test_pictures_show_four_points_at_most(monkeypatch):
    data = kinematics(load_mechanism(example_model("stephenson_six_bar")), 20.0).dataset
    points = motion.drawn_points(data)
    assert "A" not in points
    monkeypatch.setattr(motion, "MOST_POINTS", 1)
    assert len(plot_motion(data).axes) == 3
