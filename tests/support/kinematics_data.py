"""Kinematics of the aluminium four-bar with lumped masses, for pictures and pages."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

from flexmech import Kinematics, KinematicsRequest, kinematics
from tests.support.strategies import fourbar

__all__ = ["kinematics_dataset", "kinematics_result"]


@cache
def kinematics_result(lumped: tuple[int, ...] | None = (1, 4, 4)) -> Kinematics:
    angles = np.radians(np.arange(0.0, 361.0, 15.0))
    return kinematics(fourbar(), KinematicsRequest(angles, 20.0, lumped))


def kinematics_dataset() -> xr.Dataset:
    return kinematics_result().dataset.copy()
