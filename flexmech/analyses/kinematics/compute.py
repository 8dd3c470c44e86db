"""Rigid motion and inverse dynamics of a mechanism over crank angles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.kinematics.extremes import is_whole
from flexmech.analyses.kinematics.over_time import forces_along, over_time
from flexmech.analyses.kinematics.quantities import Forces, extremes_dataset
from flexmech.analyses.kinematics.request import KinematicsRequest
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.analyses.kinematics.variables import of_centres, of_forces, of_lumps, of_points
from flexmech.analyses.motor import motor_attributes, motor_variables, settled_variables
from flexmech.analyses.remarks import crank_speed_text
from flexmech.analyses.shaking import (
    harmonic_variables,
    shaking_of,
    shaking_variables,
)
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linear_system import Engine, checked_mechanism
from flexmech.linkages import (
    Drive,
    FourBar,
    InverseDynamics,
    Linkage,
    MotorRun,
    PlanarLinkage,
    assemblable,
    continuous_angles,
)
from flexmech.mechanism import Mechanism, with_motor_run

# Of a turn whose harmonics are told: orders alias into them from those beyond 700 alone.
_HARMONIC_STEPS = 720
# Of a move with its dwell, or of a turn after a run-up; and of a whole law.
_STEPS_OF_A_CYCLE, _MOST_STEPS = 720, 20_000
# A linkage whose range of motion has a gap of less than a degree passes as one that turns.
_TURN = np.radians(np.arange(0.0, 360.0))


def kinematics(
    mechanism: Mechanism | Engine,
    speed: KinematicsRequest | float | None = None,
    *,
    speed_unit: str | None = None,
) -> Kinematics:
    """Angles, velocities, accelerations, joint forces and driving torque of the rigid linkage.

    The shaft turns at constant speed, or has an acceleration besides. Loads over time begin at
    crank angle zero. Kumar & Chandrakar, eqs. 1.22, 1.23 and 1.35 to 1.44 (1.36 corrected).

    Parameters
    ----------
    mechanism : Mechanism or Engine
        Of an engine its mechanism counts.
    speed : float or KinematicsRequest, optional
        Crank speed in ``speed_unit``, over a turn in steps of one degree, or all that can be asked
        for. Left out: the mechanism's drive, or the greatest speed at which it operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s,
        that of the request, or that of the model file for the mechanism's speed.

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
    if not isinstance(speed, KinematicsRequest):
        drive = mechanism.drive if speed is None and speed_unit is None else None
        speed = KinematicsRequest(crank_speed=speed, speed_unit=speed_unit, drive=drive)
    elif speed_unit is not None:
        raise InputError("speed_unit: the request has its own; give it there")
    request = speed.of(mechanism)
    speed = request.speed_of(mechanism)
    elements = request.lumped_of(mechanism)
    if request.crank_acceleration:
        _refuse_loads_over_time(mechanism)

    if request.law is not None:
        return Kinematics(with_units(_along_law(mechanism, request.law, request), "kinematics"))

    def at(angles: FloatArray) -> tuple[InverseDynamics, InverseDynamics | None]:
        motion = mechanism.linkage.motion(angles, speed, request.crank_acceleration)
        time = angles / speed if speed else np.zeros_like(angles)
        forces = mechanism.inverse_dynamics(motion, time)
        if elements is None:
            return forces, None
        return forces, mechanism.inverse_dynamics(motion, time, elements)

    shaft = mechanism.shaft_inertia * request.crank_acceleration
    asked = request.crank_angles, request.moment_point, shaft
    dataset = kinematics_dataset(mechanism, *at(request.crank_angles), elements, request, shaft)
    found = extremes_dataset(mechanism, at, *asked)
    if request.crank_acceleration:
        # States, and not one run: power has no mean.
        found = found.drop_vars([n for n in found if str(n).startswith("mean_")])
    dataset = with_units(
        dataset.merge(found).merge(_harmonics(mechanism, at, request)), "kinematics"
    )
    return Kinematics(dataset.assign_attrs(warning=_on_turning(mechanism, request)))


def _along_law(mechanism: Mechanism, drive: Drive, request: KinematicsRequest) -> xr.Dataset:
    """Everything over the time of a law of motion."""
    elements = request.lumped_of(mechanism)
    if isinstance(drive, MotorRun):
        mechanism = with_motor_run(mechanism, drive)
    at = forces_along(mechanism, drive, elements)
    cycles = drive.run_time(1.0) / drive.cycle_time
    steps = int(min(np.ceil(round(_STEPS_OF_A_CYCLE * cycles, 6)), _MOST_STEPS))
    time = drive.run_time(1.0) / steps * np.arange(steps + 1.0)
    shaft = mechanism.shaft_inertia * drive.crank_acceleration(time)
    dataset = kinematics_dataset(mechanism, *at(time), elements, request, shaft)
    found = over_time(dataset, mechanism, drive, time, at, request.moment_point)
    if not isinstance(drive, MotorRun):
        return found
    given = motor_variables(drive, drive.motor_output(time), drive.rotor_speed(time))
    found = found.merge(given).merge(settled_variables(drive, mechanism))
    return found.assign_attrs(motor_attributes(drive))


def _harmonics(mechanism: Mechanism, at: Forces, request: KinematicsRequest) -> xr.Dataset:
    """Harmonics of the shaking force; nothing where the angles are no whole turns of one run."""
    first, last = request.crank_angles[[0, -1]].tolist()
    if not is_whole(last - first) or request.crank_acceleration:
        return xr.Dataset()
    angles = first + 2 * np.pi * np.arange(_HARMONIC_STEPS) / _HARMONIC_STEPS
    try:
        forces, _ = at(angles)
    except InputError:
        # A dead point that is between the angles asked for.
        return xr.Dataset()
    found = shaking_of(mechanism, forces, request.moment_point)
    return xr.Dataset(harmonic_variables(found, angles))


def _on_turning(mechanism: Mechanism, request: KinematicsRequest) -> str:
    """Warning of a crank that is to turn and cannot turn fully; empty where it can."""
    linkage = mechanism.linkage
    if not request.speed_of(mechanism) or _turns_fully(linkage):
        return ""
    kind = f" ({linkage.grashof_class})" if isinstance(linkage, FourBar) else ""
    speed = crank_speed_text(
        {"crank_speed": request.speed_of(mechanism), "speed_unit": request.shown_unit(mechanism)}
    )
    return (
        f"the crank cannot turn fully{kind}, so that it cannot run at {speed}: the numbers are of "
        "states in which it passes an angle at that speed; change the lengths, or let it swing"
    )


def _turns_fully(linkage: Linkage) -> bool:
    """Whether the crank makes whole turns; what stands still has none to make."""
    if isinstance(linkage, FourBar):
        return linkage.crank_turns_fully
    if isinstance(linkage, PlanarLinkage) and linkage.drawing.is_stationary:
        return True
    return bool(not linkage.change_angles.size and assemblable(linkage, _TURN).all())


def _refuse_loads_over_time(mechanism: Mechanism) -> None:
    """An accelerated crank passes an angle at no known time."""
    names = [load.name for load in mechanism.loads if load.over == "time"]
    if names:
        raise InputError(
            f"crank_acceleration: the load {names[0]} goes over time, and when a crank that "
            "accelerates is at an angle is not known; leave the acceleration out, or give the "
            "load over the crank angle"
        )


_ANGLE, _LINK = "crank_angle", "link"


def kinematics_dataset(
    mechanism: Mechanism,
    forces: InverseDynamics,
    lumped: InverseDynamics | None,
    elements: Sequence[int] | None,
    request: KinematicsRequest,
    shaft: float | FloatArray,
) -> xr.Dataset:
    """Everything that tables and pictures show.

    Parameters
    ----------
    mechanism : Mechanism
    forces : InverseDynamics
        Of the distributed masses.
    lumped : InverseDynamics or None
        Of lumped masses.
    elements : sequence of int or None
        Of each link, whose mass is lumped.
    request : KinematicsRequest
    shaft : float or ndarray, shape (A,)
        Torque in N m that the shaft's own inertia takes.

    Returns
    -------
    xarray.Dataset
    """
    linkage, motion = mechanism.linkage, forces.motion
    topology = linkage.topology
    shaking = shaking_of(mechanism, forces, request.moment_point, shaft)
    dataset = xr.Dataset(
        {
            "angle": ((_ANGLE, _LINK), continuous_angles(linkage, motion)),
            "angular_velocity": ((_ANGLE, _LINK), motion.angular_velocity),
            "angular_acceleration": ((_ANGLE, _LINK), motion.angular_acceleration),
            **of_centres(forces.masses, motion),
            **of_forces(topology, forces),
            **shaking_variables(shaking, _ANGLE),
            "moment_point": ("component", np.array(shaking.point)),
            **of_points(mechanism, motion),
        },
        coords={
            _ANGLE: motion.crank_angle,
            _LINK: list(topology.link_names),
            "component": ["x", "y"],
            "joint": list(topology.joint_names),
            "joint_kind": ("joint", list(topology.joint_kinds)),
            "force_on": ("joint", [on for on, _ in topology.joint_sides]),
            "force_by": ("joint", [by for _, by in topology.joint_sides]),
        },
    )
    if isinstance(linkage, FourBar):
        for name in ("transmission_angle", "reversed_transmission_angle"):
            dataset[name] = _ANGLE, getattr(linkage, name)(motion.crank_angle)
    if lumped is not None and elements is not None:
        by_lumps = of_forces(topology, lumped)
        dataset = dataset.assign({f"lumped_{name}": of for name, of in by_lumps.items()})
        dataset = dataset.assign(of_lumps(forces.masses, elements, motion))
        lumps = (mass.lumps(count) for mass, count in zip(forces.masses, elements, strict=True))
        names = np.repeat(topology.link_names, [len(of_link) for of_link in lumps])
        dataset = dataset.assign_coords(lump_link=("lump", names))
    speed = request.speed_of(mechanism)
    attributes = {
        **origin(mechanism),
        "crank_speed": speed,
        "speed_unit": request.shown_unit(mechanism),
    }
    if request.crank_acceleration:
        attributes["crank_acceleration"] = float(request.crank_acceleration)
        attributes["shaft_inertia_torque"] = float(shaft)
    if elements is not None:
        attributes["lumped"] = ",".join(map(str, elements))
    return dataset.assign_attrs(attributes)
