"""A run by a law of motion or under a motor: its engines, speed, power and what the motor gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.law import law_attributes, law_values
from flexmech.analyses.aspects.motor import (
    last_turn,
    motor_attributes,
    motor_values,
    settled_values,
)
from flexmech.analyses.aspects.sizing import Driven
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.response.agreement import listed
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.residual_vibration import LEAST_SAMPLES
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linkages import ConstantSpeed, MotorRun
from flexmech.linkages.motors.integrated_run import states_along
from flexmech.mechanics import Engine
from flexmech.mechanics.running import Trajectory
from flexmech.mechanism import with_motor_run

# Rotation of a free shaft in rad beyond which equations for small ones show.
_LARGE_ROTATION = np.radians(5)


def law_of_run(engine: Engine, request: ResponseRequest) -> Values:
    """Speed and acceleration of the crank over time, and what its shaft's own inertia takes.

    Parameters
    ----------
    engine : Engine
    request : ResponseRequest

    Returns
    -------
    dict
        Empty of a run at constant speed.
    """
    drive, time = request.drive, request.sample_time()
    if drive.is_constant:
        return {}
    # Of a free shaft the driving torque is what the shaft is given, its inertia's share included.
    inertia = engine.mechanism.shaft_inertia if engine.shaft == "prescribed" else 0.0
    values: Values = {**law_values(drive, time, inertia)}
    if isinstance(drive, MotorRun):
        values |= settled_values(drive, engine.mechanism)
    return values


def drive_attributes(request: ResponseRequest) -> dict[str, str | float]:
    """Attributes that tell the drive: its speed, or the greatest one of a law and its words.

    Parameters
    ----------
    request : ResponseRequest

    Returns
    -------
    dict
        ``drive`` and ``crank_speed_at_end`` of a law or a table alone.
    """
    drive = request.drive
    if isinstance(drive, ConstantSpeed) or drive.is_constant:
        return {"crank_speed": drive.speed}
    told = {"crank_speed": drive.greatest_speed, **law_attributes(drive)}
    if isinstance(drive, MotorRun):
        told |= motor_attributes(drive)
    return told | {"crank_speed_at_end": drive.speed}


def spectra_from(request: ResponseRequest) -> float:
    """Time in s from which on spectra are made.

    From the final speed on, or from the stop; of a run that ends with its law from the start.
    """
    after = request.duration - request.drive.law_time
    return request.drive.law_time if after >= LEAST_SAMPLES * request.sample_interval else 0.0


def driven_values(refined: Trajectory, request: ResponseRequest, refinement: int) -> Values:
    """Power of the drive along a run by a law of motion.

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
        Empty of a run at constant speed.
    """
    drive, time = request.drive, refined.time
    if drive.is_constant:
        return {}
    speed = drive.crank_speed(time)
    if refined.shaft is not None:
        speed = speed + refined.shaft.rate
    power = refined.driving_torque * speed
    return {
        "driving_power": power[::refinement],
        "peak_driving_power": peaks_between(power[:, None], time)[0][0],
    }


def with_motor(
    engines: Sequence[Engine], request: ResponseRequest, environment: Environment | None
) -> tuple[list[Engine], ResponseRequest]:
    """Engines whose shaft is free and has the motor's rotor, and the request of a run with them.

    Parameters
    ----------
    engines : sequence of Engine
        Engines of one mechanism.
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


def motor_of_run(
    refined: Trajectory, request: ResponseRequest, refinement: int
) -> tuple[Values, FloatArray | None, list[Driven]]:
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
    ndarray, shape (N,), or None
        Rate of the angular momentum of the rotor in N m at the samples asked for.
    list of Driven
        Torque and speed of the motor at the refined samples.
    """
    from scipy.interpolate import CubicSpline

    run, shaft = request.drive, refined.shaft
    if not isinstance(run, MotorRun) or shaft is None:
        return {}, None, []
    time = refined.time
    speed = run.crank_speed(time) + shaft.rate
    angle = run.crank_angle(time) + shaft.rotation
    train = run.equation.train
    states = states_along(train, time, angle, speed, run.states(0.0))
    given = train.motor_output(speed, states)
    values = motor_values(run, given, train.rotor_speed(speed, states))
    # The rotor turns with a frame on springs as well.
    spin = 0.0 if refined.frame is None else refined.frame.rate[:, 2]
    momentum = CubicSpline(time, train.motor.inertia * (values["motor_speed"] + spin))
    mean, fluctuation = last_turn(angle, speed, time)
    told: Values = {name: of_time[::refinement] for name, of_time in values.items()}
    told |= {"last_turn_speed": mean, "last_turn_fluctuation": fluctuation}
    motor = Driven("motor", values["motor_torque"], values["motor_speed"])
    return told, np.asarray(momentum(time[::refinement], 1)), [motor]


def shaft_aspect(data: xr.Dataset) -> Aspect:
    """How far a free shaft leaves its prescribed motion, and what linear theory makes of it.

    Parameters
    ----------
    data : xarray.Dataset
        Data of the response.

    Returns
    -------
    Aspect
        Nothing where the shaft turns as prescribed.
    """
    if "shaft_rotation" not in data:
        return Aspect()
    peak = data["peak_shaft_rotation"]
    part = 100 * data["peak_crank_speed_fluctuation"] / abs(data.attrs["crank_speed"])
    left = "under the torque that drives the rigid linkage; it leaves its prescribed "
    if "motor_torque" in data:
        left = "under the motor; with elastic links it leaves the rigid linkage's "
        if data.attrs["start"] == "periodic":
            left = "under the motor; it leaves the settled motion that was found directly in its "
    lines = [
        f"shaft: free, {left}"
        f"angle by at most {listed(DEGREES * peak, '{:.4g} deg')}, its speed the crank speed "
        f"by at most {listed(part, '{:.3g} %')}"
    ]
    if "motor_torque" in data:
        # Its equations follow the shaft at any rotation.
        return Aspect(details=tuple(lines))
    linear = peak.sel(engine=~data["nonlinear"].astype(bool))
    if linear.sizes["engine"] and float(linear.max()) > _LARGE_ROTATION:
        lines.append(
            f"shaft: the equations of {', '.join(map(str, linear['engine'].values))} are for "
            f"small rotations, its own is beyond the {np.degrees(_LARGE_ROTATION):.0f} deg up to "
            "which they hold; trust the exudyn engine, or give the shaft more inertia"
        )
    return Aspect(details=tuple(lines))
