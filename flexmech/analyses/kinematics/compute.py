"""Rigid motion and inverse dynamics of a mechanism over crank angles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.kinematics.request import KinematicsRequest
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.errors import InputError
from flexmech.linear_system import checked_mechanism
from flexmech.linkages import (
    FourBar,
    InverseDynamics,
    LinkMass,
    RigidMotion,
    Topology,
    continuous_angles,
)
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism
from flexmech.numbers import check_instance
from flexmech.types import FloatArray


def kinematics(mechanism: Mechanism, request: KinematicsRequest | None = None) -> Kinematics:
    """Angles, velocities, accelerations, joint forces and driving torque of the rigid linkage.

    The shaft turns at constant speed. Loads over time begin at crank angle zero.

    Parameters
    ----------
    mechanism : Mechanism
    request : KinematicsRequest, optional
        A turn in steps of one degree at the mechanism's speed if left out.

    Returns
    -------
    Kinematics

    Raises
    ------
    InputError
        If the linkage cannot be assembled or locks at a crank angle, its connections do not
        determine the forces, or the numbers of lumped masses do not fit its links.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> found = flexmech.kinematics(mechanism, flexmech.KinematicsRequest(crank_speed=20.0))
    >>> float(abs(found.dataset["driving_torque"]).max().round(3))  # N m
    0.33
    """
    mechanism = checked_mechanism(mechanism)
    request = KinematicsRequest() if request is None else request
    check_instance(request, KinematicsRequest, "request", "give a flexmech.KinematicsRequest")
    speed, elements = request.speed_of(mechanism), request.lumped_of(mechanism)
    motion = mechanism.linkage.motion(request.crank_angles, speed)
    time = request.crank_angles / speed if speed else np.zeros_like(request.crank_angles)
    forces = mechanism.inverse_dynamics(motion, time)
    lumped = None
    if elements is not None:
        lumped = mechanism.inverse_dynamics(motion, time, elements)
    return Kinematics(kinematics_dataset(mechanism, forces, lumped, elements, request))


ANGLE, LINK = "crank_angle", "link"
PLANE = (ANGLE, LINK, "component")


def kinematics_dataset(
    mechanism: Mechanism,
    forces: InverseDynamics,
    lumped: InverseDynamics | None,
    elements: Sequence[int] | None,
    request: KinematicsRequest,
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

    Returns
    -------
    xarray.Dataset
    """
    linkage, motion = mechanism.linkage, forces.motion
    topology = linkage.topology
    dataset = xr.Dataset(
        {
            "angle": ((ANGLE, LINK), continuous_angles(linkage, motion)),
            "angular_velocity": ((ANGLE, LINK), motion.angular_velocity),
            "angular_acceleration": ((ANGLE, LINK), motion.angular_acceleration),
            **_of_centres(forces.masses, motion),
            **_of_forces(topology, forces),
        },
        coords={
            ANGLE: request.crank_angles,
            LINK: list(topology.link_names),
            "component": ["x", "y"],
            "joint": list(topology.joint_names),
            "joint_kind": ("joint", list(topology.joint_kinds)),
        },
    )
    if isinstance(linkage, FourBar):
        for name in ("transmission_angle", "reversed_transmission_angle"):
            dataset[name] = ANGLE, getattr(linkage, name)(request.crank_angles)
    if lumped is not None and elements is not None:
        of_lumps = _of_forces(topology, lumped)
        dataset = dataset.assign({f"lumped_{name}": of for name, of in of_lumps.items()})
        dataset = dataset.assign(_of_lumps(forces.masses, elements, motion))
        lumps = (mass.lumps(count) for mass, count in zip(forces.masses, elements, strict=True))
        names = np.repeat(topology.link_names, [len(of_link) for of_link in lumps])
        dataset = dataset.assign_coords(lump_link=("lump", names))
    speed = request.speed_of(mechanism)
    attributes = {**origin(mechanism), "crank_speed": speed, "speed_unit": request.speed_unit}
    if elements is not None:
        attributes["lumped"] = ",".join(map(str, elements))
    return with_units(dataset, "kinematics").assign_attrs(attributes)


def _of_centres(
    masses: Sequence[LinkMass], motion: RigidMotion
) -> dict[str, tuple[tuple[str, ...], FloatArray]]:
    """Centres of mass, their accelerations, and inertia forces without weight."""
    along, across = (np.array(each) for each in zip(*(m.centre for m in masses), strict=True))
    mass = np.array([m.moment(0) for m in masses])
    inertia = np.array([m.central_inertia for m in masses])
    arm = along[:, None] * direction(motion.angle) + across[:, None] * normal(motion.angle)
    ahead = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
    acceleration = (
        motion.origin_acceleration
        + motion.angular_acceleration[..., None] * ahead
        - motion.angular_velocity[..., None] ** 2 * arm
    )
    return {
        "centre_position": (PLANE, motion.origin + arm),
        "centre_acceleration": (PLANE, acceleration),
        "inertia_force": (PLANE, -mass[:, None] * acceleration),
        "inertia_moment": ((ANGLE, LINK), -inertia * motion.angular_acceleration),
    }


def _of_forces(
    topology: Topology, forces: InverseDynamics
) -> dict[str, tuple[tuple[str, ...], FloatArray]]:
    """Joint forces and moments, torque and power."""
    names = topology.joint_names
    force = np.stack([forces.joint_force[name] for name in names], axis=1)
    moment = np.stack([forces.joint_moment[name] for name in names], axis=1)
    return {
        "joint_force": ((ANGLE, "joint", "component"), force),
        "joint_moment": ((ANGLE, "joint"), moment),
        "driving_torque": ((ANGLE,), forces.driving_torque),
        "driving_power": ((ANGLE,), forces.driving_power),
    }


def _of_lumps(
    masses: Sequence[LinkMass], elements: Sequence[int], motion: RigidMotion
) -> dict[str, tuple[tuple[str, ...], FloatArray]]:
    """Place, size, acceleration and inertia force of every lumped mass."""
    places, sizes, accelerations = [], [], []
    for link, (mass, count) in enumerate(zip(masses, elements, strict=True)):
        for x, lump in mass.lumps(count):
            places.append(x)
            sizes.append(lump)
            accelerations.append(_acceleration(motion, link, x, mass.offset))
    if not sizes:
        raise InputError("lumped: no link has distributed mass that could be lumped; leave it out")
    acceleration = np.stack(accelerations, axis=1)
    plane = (ANGLE, "lump", "component")
    return {
        "lump_position": (("lump",), np.array(places)),
        "lump_mass": (("lump",), np.array(sizes)),
        "lump_acceleration": (plane, acceleration),
        "lump_inertia_force": (plane, -np.array(sizes)[:, None] * acceleration),
    }


def _acceleration(motion: RigidMotion, link: int, x: float, y: float) -> FloatArray:
    """Of a point of a link; shape (..., 2)."""
    quarter = motion.acceleration(link, x)
    if not y:
        return quarter
    across = normal(motion.angle[..., link])
    along = direction(motion.angle[..., link])
    square = motion.angular_velocity[..., link, None] ** 2
    return np.asarray(
        quarter - y * (motion.angular_acceleration[..., link, None] * along + square * across)
    )
