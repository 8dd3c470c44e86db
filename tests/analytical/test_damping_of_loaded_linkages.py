"""Damping of linkages with weight, springs and loads, found back in records from straight links.

The records are runs of the reference engine from undeformed links with 1 % of noise. States of
single coordinates of the moving modes, which are no modes, left 0.7 % of such a record unexplained,
and damping 12 % off.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexmech import ConstantSpeed, ReferenceEngine, ResponseRequest, load_mechanism, response
from flexmech.analyses.comparison.fit import Fit, fitted
from flexmech.analyses.comparison.over_time import TimeProblem
from flexmech.analyses.comparison.parameters import fitted_names
from flexmech.analyses.comparison.quantities import gauges
from flexmech.errors import InputError
from flexmech.linkages import AttachmentPoint, Load
from flexmech.time_domain import forced_modes
from flexmech.time_domain.periodic_motion.forced_modes import FreeAndForced

DATA = Path(__file__).parents[1] / "data"
SPEED, DAMPING, NOISE = 12.0, 1.3e-5, 0.01
PUSHED, HEAVY = "pushed_slider_crank", "heavy_slider_crank"
DRAWS, HELD = 25, 22


@cache
def problem(name: str) -> TimeProblem:
    """The middle of the rod over four turns, without noise."""
    engine = ReferenceEngine(load_mechanism(DATA / f"{name}.toml"), 3)
    run = response(engine, ResponseRequest(ConstantSpeed(SPEED), revolutions=2.0)).dataset
    return TimeProblem(
        engine=engine,
        record=run["deflection"].sel(link="rod").values[0],
        names=fitted_names(("damping",), ("crank", "rod")),
        crank_speed=SPEED,
        gauge=next(g for g in gauges(engine) if g.name == "rod_mid_deflection"),
        time=run["time"].values,
        angle=run["crank_angle"].values,
    )


def fit(name: str, seed: int) -> Fit:
    known = problem(name)
    noise = np.random.default_rng(seed).standard_normal(len(known.time))
    # The linkages that are kept for one record serve all of them.
    return fitted(replace(known, record=known.record + NOISE * known.record.std() * noise))


@pytest.mark.thorough
@pytest.mark.parametrize("name", [PUSHED, HEAVY])
def test_nothing_but_the_noise_is_unexplained(name: str) -> None:
    found = fit(name, 0)
    assert found.unexplained == pytest.approx(NOISE**2, rel=0.1)
    assert found.lower[0] <= DAMPING <= found.upper[0]
    assert found.upper[0] - found.lower[0] < 0.03 * DAMPING


@pytest.mark.thorough
@pytest.mark.parametrize("name", [PUSHED, HEAVY])
def test_intervals_hold_the_truth(name: str) -> None:
    """In nine of ten records, as they say of 95 in 100."""
    found = [fit(name, seed) for seed in range(DRAWS)]
    assert sum(bool(own.lower[0] <= DAMPING <= own.upper[0]) for own in found) >= HELD


def test_a_record_that_round_off_begins_before_its_step_has_a_first_sample() -> None:
    """It was what the memory held."""
    steps = np.tile(np.eye(2), (8, 1, 1))
    motion = FreeAndForced(steps, np.ones((8, 1, 1)), np.zeros((8, 1)))
    for begin in (0.0, -1e-16, -1e-13):
        forced, free = motion.readings(begin + np.array([0.0, 0.1, 1.2]))
        np.testing.assert_allclose(free, 1.0)
        np.testing.assert_allclose(forced, 0.0, atol=1e-12)


def test_loads_over_time_have_no_periodic_motion() -> None:
    mechanism = load_mechanism(DATA / "heavy_slider_crank.toml")
    load = Load(
        "kick",
        AttachmentPoint("rod", 0.1),
        over="time",
        at=(0.0, 1.0),
        force=((0.0, 0.0), (1.0, 0.0)),
        torque=(0.0, 0.0),
    )
    engine = ReferenceEngine(replace(mechanism, loads=(load,)), 3)
    with pytest.raises(InputError, match="no motion repeats itself every turn"):
        forced_modes(engine, SPEED, [])
