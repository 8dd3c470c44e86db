"""Rigid motion and inverse dynamics of a mechanism over crank angles."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.law import law_attributes, law_values
from flexmech.analyses.aspects.motor import motor_attributes, motor_values, settled_values
from flexmech.analyses.aspects.motor_choice import DrivenShaft, candidate_values
from flexmech.analyses.aspects.shaking import harmonic_values, shaft_torque, shaking_of
from flexmech.analyses.aspects.sizing import Driven, sizing_values
from flexmech.analyses.check.remarks import turns_fully
from flexmech.analyses.datasets import origin
from flexmech.analyses.extremes import is_whole
from flexmech.analyses.kinematics.positions import (
    SCHEMA,
    Forces,
    extreme_values,
    of_lumps,
    values_of,
)
from flexmech.analyses.kinematics.request import KinematicsRequest
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.analyses.requests import asks
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import crank_speed_text
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import (
    Drive,
    FourBar,
    InverseDynamics,
    MotorRun,
    RigidMotion,
    continuous_angles,
)
from flexmech.linkages.frame_forces import ShakingForce
from flexmech.mechanics import Engine, checked_mechanism
from flexmech.mechanism import Mechanism, with_motor_run

# Steps of a turn whose harmonics and means are given: orders alias into them from those beyond 700
# alone.
_HARMONIC_STEPS = 720
# Steps of a move with its dwell, or of a turn after a run-up; and most steps of a whole law.
_STEPS_OF_A_CYCLE, _MOST_STEPS = 720, 20_000
# Between two of these parts of a run a linkage and its loads have one extreme.
_PARTS_OF_A_RUN = 720


@asks(KinematicsRequest)
def kinematics(mechanism: Mechanism | Engine, request: KinematicsRequest) -> Kinematics:
    """Angles, velocities, accelerations, joint forces and driving torque of the rigid linkage.

    The shaft turns at constant speed, or has an acceleration besides. Loads over time begin at
    crank angle zero. Kumar & Chandrakar, eqs. 1.22, 1.23 and 1.35 to 1.44 (1.36 corrected).

    Parameters
    ----------
    mechanism : Mechanism or Engine
        A mechanism, or an engine, whose mechanism counts.

    Returns
    -------
    Kinematics

    Raises
    ------
    InputError
        If the linkage cannot be assembled or locks at a crank angle, its connections do not
        determine the forces, the numbers of lumped masses do not fit its links, or the crank
        accelerates under a load over time.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> found = flexmech.kinematics(mechanism, 20.0)
    >>> float(abs(found.dataset["driving_torque"]).max().round(3))  # N m
    0.33
    """
    own = mechanism.mechanism if isinstance(mechanism, Engine) else mechanism
    mechanism = checked_mechanism(own)
    request = request.of(mechanism)
    speed = request.speed_of(mechanism)
    elements = request.lumped_of(mechanism)
    if request.crank_acceleration:
        _refuse_loads_over_time(mechanism)

    if request.motors is not None:
        _refuse_motors(request, speed)

    if request.law is not None:
        return Kinematics(_along_law(mechanism, request.law, request))

    def at(angles: FloatArray) -> tuple[InverseDynamics, InverseDynamics | None]:
        motion = mechanism.linkage.motion(angles, speed, request.crank_acceleration)
        time = angles / speed if speed else np.zeros_like(angles)
        return _forces(mechanism, motion, time, elements)

    shaft = mechanism.shaft_inertia * request.crank_acceleration
    forces = at(request.crank_angles)
    values = _values(mechanism, *forces, request, shaft)
    values |= extreme_values(mechanism, at, request.crank_angles, request.moment_point, shaft)
    attributes = _attributes(mechanism, request)
    if request.crank_acceleration:
        # States, and not one run: power has no mean.
        values = {name: one for name, one in values.items() if not name.startswith("mean_")}
        attributes["crank_acceleration"] = float(request.crank_acceleration)
        attributes["shaft_inertia_torque"] = float(shaft)
    values |= _over_steps(mechanism, at, request, speed)
    turns = is_whole(float(np.ptp(request.crank_angles)))
    attributes["sizing_over"] = "the turn" if turns else "the crank angles asked for"
    attributes["warning"] = _on_turning(mechanism, request)
    return Kinematics(SCHEMA.dataset(values).assign_attrs(attributes))


def _along_law(mechanism: Mechanism, drive: Drive, request: KinematicsRequest) -> xr.Dataset:
    """Everything over the time of a law of motion."""
    elements = request.lumped_of(mechanism)
    if isinstance(drive, MotorRun):
        mechanism = with_motor_run(mechanism, drive)

    def at(time: FloatArray) -> tuple[InverseDynamics, InverseDynamics | None]:
        return _forces(mechanism, drive.motion(mechanism.linkage, time), time, elements)

    on_shaft = partial(shaft_torque, drive, mechanism.shaft_inertia)
    cycles = drive.run_time(1.0) / drive.cycle_time
    steps = int(min(np.ceil(round(_STEPS_OF_A_CYCLE * cycles, 6)), _MOST_STEPS))
    time = drive.run_time(1.0) / steps * np.arange(steps + 1.0)
    point, step = request.moment_point, float(time[-1] - time[0]) / _PARTS_OF_A_RUN
    forces, lumped = at(time)
    values = _values(mechanism, forces, lumped, request, on_shaft(time))
    values |= extreme_values(mechanism, at, time, point, on_shaft, step=step)
    for name in ("least", "greatest"):
        values[f"{name}_time"] = values[f"{name}_angle"]
        values[f"{name}_angle"] = drive.crank_angle(values[f"{name}_time"])
    values |= {"time": time, **law_values(drive, time, mechanism.shaft_inertia)}
    attributes = _attributes(mechanism, request) | law_attributes(drive)
    attributes["run_up_time"] = drive.law_time
    attributes["sizing_over"] = "the run"
    torque = forces.driving_torque + mechanism.shaft_inertia * drive.crank_acceleration(time)
    driven = [Driven("shaft", torque, drive.crank_speed(time))]
    if isinstance(drive, MotorRun):
        values |= motor_values(drive, drive.motor_output(time), drive.rotor_speed(time))
        driven.append(Driven("motor", values["motor_torque"], values["motor_speed"]))
        values |= settled_values(drive, mechanism)
        attributes |= motor_attributes(drive)
    if request.motors is not None:
        shaft = driven[0]
        acceleration = drive.crank_acceleration(time)
        angles = forces.motion.crank_angle
        values |= _candidates(mechanism, request, time, angles, shaft, acceleration)
    values |= sizing_values(time, driven, forces.joint_force, drive)
    return SCHEMA.dataset(values, "time").assign_attrs(attributes)


def _forces(
    mechanism: Mechanism, motion: RigidMotion, time: FloatArray, elements: Sequence[int] | None
) -> tuple[InverseDynamics, InverseDynamics | None]:
    """Inverse dynamics by distributed masses, and by lumped ones if they are asked for."""
    forces = mechanism.inverse_dynamics(motion, time)
    if elements is None:
        return forces, None
    return forces, mechanism.inverse_dynamics(motion, time, elements)


def _over_steps(
    mechanism: Mechanism, at: Forces, request: KinematicsRequest, speed: float
) -> Values:
    """Sizes of motor and bearings, and over whole turns harmonics of the shaking force.

    Over one turn, or from the first crank angle to the last; nothing where they are no states of
    one run.
    """
    first, last = request.crank_angles[[0, -1]].tolist()
    whole = is_whole(last - first)
    if request.crank_acceleration or first == last:
        return {}
    steps = np.arange(_HARMONIC_STEPS + 1) / _HARMONIC_STEPS
    angles = first + (2 * np.pi if whole else last - first) * steps
    try:
        forces, _ = at(angles)
    except InputError:
        if request.motors is not None:
            raise
        # A dead point that is between the angles asked for.
        return {}
    shaft = Driven("shaft", forces.driving_torque, np.full_like(angles, speed))
    values = sizing_values(angles, [shaft], forces.joint_force)
    if request.motors is not None:
        still = np.zeros_like(angles)
        values |= _candidates(mechanism, request, angles, angles, shaft, still)
    if whole:
        found = shaking_of(mechanism, forces, request.moment_point)
        turn = ShakingForce(found.force[:-1], found.moment[:-1], found.point)
        values |= harmonic_values(turn, angles[:-1])
    return values


def _candidates(
    mechanism: Mechanism,
    request: KinematicsRequest,
    place: FloatArray,
    angles: FloatArray,
    shaft: Driven,
    acceleration: FloatArray,
) -> Values:
    """Motors of the catalogue against the shaft at crank angles (N,) of one run."""
    # Torque for an acceleration of 1 rad/s^2 beside that of the linkage at rest: loads cancel.
    moved, held = (
        mechanism.inverse_dynamics(mechanism.linkage.motion(angles, 0.0, rate), 0.0 * angles)
        for rate in (1.0, 0.0)
    )
    inertia = moved.driving_torque - held.driving_torque + mechanism.shaft_inertia
    driven = DrivenShaft(place, shaft.torque, shaft.speed, acceleration, inertia)
    return candidate_values(request.catalogue, driven)


def _refuse_motors(request: KinematicsRequest, speed: float) -> None:
    if isinstance(request.law, MotorRun):
        raise InputError(
            "motors: the linkage is under a motor already, whose size is in sizing.csv; give a "
            "speed or a law of motion"
        )
    if request.law is None and not speed:
        raise InputError("motors: at rest no motor is needed; give a crank speed other than zero")


def _on_turning(mechanism: Mechanism, request: KinematicsRequest) -> str:
    """Warning of a crank that is to turn and cannot turn fully; empty where it can."""
    linkage = mechanism.linkage
    if not request.speed_of(mechanism) or turns_fully(linkage):
        return ""
    kind = f" ({linkage.grashof_class})" if isinstance(linkage, FourBar) else ""
    speed = crank_speed_text(
        {"crank_speed": request.speed_of(mechanism), "speed_unit": request.shown_unit(mechanism)}
    )
    return (
        f"the crank cannot turn fully{kind}, so that it cannot run at {speed}: the numbers hold "
        "where it passes an angle at that speed; change the lengths, or let it swing"
    )


def _refuse_loads_over_time(mechanism: Mechanism) -> None:
    """An accelerated crank passes an angle at no known time."""
    names = [load.name for load in mechanism.loads if load.over == "time"]
    if names:
        raise InputError(
            f"crank_acceleration: the load {names[0]} goes over time, and when a crank that "
            "accelerates is at an angle is not known; leave the acceleration out, or give the "
            "load over the crank angle"
        )


def _values(
    mechanism: Mechanism,
    forces: InverseDynamics,
    lumped: InverseDynamics | None,
    request: KinematicsRequest,
    shaft: float | FloatArray,
) -> Values:
    """All variables over the positions, with the names along their dimensions.

    ``shaft`` is the torque in N m on the shaft itself and on a motor's rotor.
    """
    linkage, motion = mechanism.linkage, forces.motion
    topology, elements = linkage.topology, request.lumped_of(mechanism)
    return {
        "crank_angle": motion.crank_angle,
        "link": list(topology.link_names),
        "component": ["x", "y"],
        "joint": list(topology.joint_names),
        "joint_kind": list(topology.joint_kinds),
        "force_on": [on for on, _ in topology.joint_sides],
        "force_by": [by for _, by in topology.joint_sides],
        "angle": continuous_angles(linkage, motion),
        **values_of(mechanism, forces, lumped, request.moment_point, shaft),
        **({} if elements is None else of_lumps(mechanism, forces, elements)),
    }


def _attributes(mechanism: Mechanism, request: KinematicsRequest) -> dict[str, str | float]:
    """Where the numbers come from, and the speed that they are of."""
    elements = request.lumped_of(mechanism)
    return {
        **origin(mechanism),
        "crank_speed": request.speed_of(mechanism),
        "speed_unit": request.shown_unit(mechanism),
        **({} if elements is None else {"lumped": ",".join(map(str, elements))}),
    }
