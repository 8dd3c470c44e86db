"""A small hammer test of two angles, by the reference engine, for pictures, words and files."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

import flexmech
from flexmech.analyses.damping_ratios import with_damping_ratio

ALUMINIUM = flexmech.example_model("aluminium_fourbar")


@cache
def damped_engine(elements: int = 2) -> flexmech.ReferenceEngine:
    """The aluminium linkage with links that are damped."""
    mechanism = flexmech.load_mechanism(ALUMINIUM)
    return with_damping_ratio(flexmech.ReferenceEngine(mechanism, elements), 0.02)


@cache
def small_test(noise: float = 0.0) -> flexmech.HammerTest:
    """Two angles, two modes, without the package for LSCF."""
    return flexmech.hammer_test(damped_engine(), small_request(noise))


def small_request(noise: float) -> flexmech.HammerRequest:
    """From the coupler to the rocker."""
    return flexmech.HammerRequest(
        np.radians([30.0, 96.9]),
        response=flexmech.LinkPoint("rocker", 0.4),
        modes=2,
        noise=noise,
        method="circle-fit",
    )


def hammer_dataset() -> xr.Dataset:
    """What figures are drawn from; a copy that tests may change."""
    return small_test(0.01).dataset.copy(deep=True)
