"""A four-bar under a law of motion, rigid and running, for pictures and words."""

from __future__ import annotations

from functools import cache

import numpy as np
import xarray as xr

from flexmech import (
    Kinematics,
    KinematicsRequest,
    LawDrive,
    ReferenceEngine,
    Response,
    ResponseRequest,
    Shaping,
    kinematics,
    response,
)
from tests.support.strategies import fourbar

__all__ = [
    "LAW",
    "driven_dataset",
    "driven_kinematics",
    "driven_run",
    "shaped_dataset",
    "shaped_run",
]

LAW = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.1, start_angle=0.3)


@cache
def driven_run() -> Response:
    mechanism = fourbar(damping_time=1e-5, shaft_inertia=1e-4)
    request = ResponseRequest(LAW, samples=240, step=2e-4)
    return response(ReferenceEngine(mechanism, 2), request)


def driven_dataset() -> xr.Dataset:
    return driven_run().dataset.copy()


@cache
def shaped_run() -> Response:
    """The law beside its shaped form, and three times of a move."""
    mechanism = fourbar(damping_time=1e-5)
    shaping = Shaping("zv", modes=(1, 2))
    request = ResponseRequest(
        LAW, samples=240, step=2e-4, shaping=shaping, move_times=(0.1, 0.15, 0.2)
    )
    return response(ReferenceEngine(mechanism, 2), request)


def shaped_dataset() -> xr.Dataset:
    return shaped_run().dataset.copy()


@cache
def driven_kinematics() -> Kinematics:
    return kinematics(fourbar(shaft_inertia=1e-4), KinematicsRequest(drive=LAW))
