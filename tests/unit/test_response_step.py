"""The time step that a response chooses by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

import flexmech
from flexmech.errors import ComputationError

MODEL = Path(__file__).parents[2] / "models" / "rotating_l_beam.toml"


def test_links_that_bow_deeply_get_a_step_in_which_they_balance() -> None:
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(MODEL), 8, "euler")
    drive = flexmech.ConstantSpeed(16.0)
    coarse = flexmech.ResponseRequest(drive, 0.5, step=drive.revolution_time / 90)
    with pytest.raises(ComputationError, match="no balance in a time step"):
        flexmech.response(engine, coarse)
    found = flexmech.response(engine, flexmech.ResponseRequest(drive, 0.1))
    assert float(found.dataset["energy_error"].max()) < 1e-6
