"""Messages of errors: the crank speed in them in the unit that the user typed."""

from __future__ import annotations

import pickle

import pytest

from flexmech.errors import ComputationError, FlexmechError, InputError


@pytest.mark.parametrize("kind", [FlexmechError, InputError, ComputationError])
def test_a_crank_speed_is_told_in_any_unit(kind):
    error = kind("no equilibrium at {crank_speed}; lower it", crank_speed=20.0)
    assert str(error) == error.told("rad/s") == "no equilibrium at 20 rad/s; lower it"
    assert error.told("rpm") == "no equilibrium at 190.986 rpm; lower it"
    assert kind("at {crank_speed}", crank_speed=31.41592653589793).told("rpm") == "at 300 rpm"


def test_only_the_literal_placeholder_of_a_known_speed_is_replaced():
    assert str(InputError("{crank_speed} {0} {}")) == "{crank_speed} {0} {}"
    named = InputError("model{1}.toml: {crank_speed}, {crank_speed:g}", crank_speed=-2.0)
    assert named.told("rpm") == "model{1}.toml: -19.0986 rpm, {crank_speed:g}"


def test_an_error_keeps_its_speed_in_a_place_and_in_another_process():
    error = ComputationError("fails at {crank_speed}", crank_speed=20.0)
    placed = error.within("model.toml")
    assert isinstance(placed, ComputationError)
    assert placed.told("deg/s") == "model.toml: fails at 1145.92 deg/s"
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.told("rpm")) == (ComputationError, "fails at 190.986 rpm")


def test_an_unknown_unit_is_no_speed():
    with pytest.raises(ValueError, match="'wheels' is unknown"):
        InputError("at {crank_speed}", crank_speed=1.0).told("wheels")
