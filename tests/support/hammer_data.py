"""A small hammer test of two angles, by the reference engine, for pictures and panels."""

from __future__ import annotations

from functools import cache

import numpy as np

from flexmech import HammerRequest, HammerTest, LinkPoint, hammer_test
from tests.support.gauge_record import ALUMINIUM, ENGINE, damped


@cache
def small_test(noise: float = 0.0) -> HammerTest:
    """Two angles, two modes, without the package for LSCF."""
    request = HammerRequest(
        np.radians([30.0, 96.9]),
        response=LinkPoint("rocker", 0.4),
        modes=2,
        noise=noise,
        method="circle-fit",
    )
    return hammer_test(ENGINE.with_(mechanism=damped(ALUMINIUM, every=1.4e-4)), request)
