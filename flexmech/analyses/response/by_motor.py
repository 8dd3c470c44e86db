"""A run under a motor: its engines, what the motor gives, and how the crank runs up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.analyses.aspects.motor import last_turn, motor_values
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.schema import Values
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linear_system import Engine
from flexmech.linkages import MotorRun
from flexmech.linkages.motors.integrated_run import states_along
from flexmech.mechanism import with_motor_run
from flexmech.time_domain import Trajectory


def with_motor(
    engines: Sequence[Engine], request: ResponseRequest, environment: Environment | None
) -> tuple[list[Engine], ResponseRequest]:
    """Engines whose shaft is free and has the motor's rotor, and the request of a run with them.

    Parameters
    ----------
    engines : sequence of Engine
        Of one mechanism.
    request : ResponseRequest
    environment : HygrothermalState or Exposure, optional
        In which the rigid linkage has other lengths and masses.

    Returns
    -------
    list of Engine
    ResponseRequest
        Both as they are where there is no motor.

    Raises
    ------
    InputError
        If the motor does not move the linkage.
    """
    run = request.drive
    if not isinstance(run, MotorRun):
        return list(engines), request
    mechanism = engines[0].mechanism
    if environment is not None:
        wet = mechanism_in_state(mechanism, environment)
        request = replace(request, speed=run.drive).of(wet)
        run = request.drive
        assert isinstance(run, MotorRun)
    if run.stall is not None and run.stall.time == 0:
        raise InputError(
            f"drive: the motor does not start: at {np.degrees(run.stall.crank_angle):.4g} deg it "
            f"gives the crank {run.stall.torque:.4g} N m at rest, and {run.stall.needed:.4g} N m "
            "would hold the linkage there; there is no run of elastic links: give a stronger "
            "motor or another start_angle"
        )
    own = with_motor_run(mechanism, run)
    return [engine.with_(mechanism=own, shaft="free") for engine in engines], request


def motor_of_run(refined: Trajectory, request: ResponseRequest, refinement: int) -> Values:
    """What the motor gives in a run, and how evenly the crank turns in its last turn.

    Parameters
    ----------
    refined : Trajectory
        At the refined samples.
    request : ResponseRequest
    refinement : int
        Refined samples for each one asked for.

    Returns
    -------
    dict
        Empty without a motor.
    """
    run, shaft = request.drive, refined.shaft
    if not isinstance(run, MotorRun) or shaft is None:
        return {}
    time = refined.time
    speed = run.crank_speed(time) + shaft.rate
    angle = run.crank_angle(time) + shaft.rotation
    train = run.equation.train
    states = states_along(train, time, angle, speed, run.states(0.0))
    given = train.motor_output(speed, states)
    values = motor_values(run, given, train.rotor_speed(speed, states))
    mean, fluctuation = last_turn(angle, speed, time)
    return {
        **{name: of_time[::refinement] for name, of_time in values.items()},
        "last_turn_speed": mean,
        "last_turn_fluctuation": fluctuation,
    }
