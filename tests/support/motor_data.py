"""A four-bar under a DC motor, rigid and running, for pictures and words."""

from __future__ import annotations

from functools import cache

import xarray as xr

from flexmech import (
    DcMotor,
    Kinematics,
    KinematicsRequest,
    MotorDrive,
    ReferenceEngine,
    Response,
    ResponseRequest,
    kinematics,
    response,
)
from tests.support.strategies import fourbar

__all__ = ["MOTOR", "motor_dataset", "motor_kinematics", "motor_response"]

MOTOR = MotorDrive(DcMotor(1.2, 0.06, 12.0, gear_ratio=10.0, inertia=2e-5))


@cache
def motor_kinematics() -> Kinematics:
    return kinematics(fourbar(), KinematicsRequest(drive=MOTOR))


@cache
def motor_response() -> Response:
    request = ResponseRequest(MOTOR, revolutions=0.2, samples=60, modes=2, step=2e-4)
    return response(ReferenceEngine(fourbar(damping_time=1e-5), 2), request)


def motor_dataset() -> xr.Dataset:
    return motor_response().dataset.copy()
