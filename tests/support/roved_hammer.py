"""A small hammer test whose impact roves over a grid, for tests of what is made of it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import xarray as xr

from flexmech import HammerRequest, HammerTest, ReferenceEngine, hammer_test, load_mechanism
from flexmech.example_models import example_model

ANGLES = np.radians([20.0, 96.9])
POINTS_A_LINK = 3
# In s. More than the plies have, so that records are short; unequal, so that modes are complex.
DAMPING_TIMES = {"crank": 1e-6, "coupler": 8e-6, "rocker": 2e-6}


def damped_engine() -> ReferenceEngine:
    mechanism = load_mechanism(example_model("composite_fourbar"))
    sections = {
        name: section.with_damping_time(DAMPING_TIMES[name])
        for name, section in mechanism.sections.items()
    }
    return ReferenceEngine(replace(mechanism, sections=sections), elements=2)


@cache
def roved_test() -> HammerTest:
    request = HammerRequest(ANGLES, modes=3, averages=2, grid=POINTS_A_LINK)
    return hammer_test(damped_engine(), request)


def roved_dataset() -> xr.Dataset:
    return roved_test().dataset
