"""Rigid motion and inverse dynamics of a mechanism over crank angles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import origin, with_units
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.analyses.requests import in_radians
from flexmech.arrays import FloatArray
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
from flexmech.validation import check_count, check_instance, check_number, checked_tuple

# Elements of a link whose mass is lumped: with so many the inertia force is the distributed one to
# six digits.
_MOST_LUMPS = 1000


@dataclass(frozen=True)
class KinematicsRequest:
    """Crank angles, speed and acceleration, and how masses are lumped for a comparison.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        In rad, increasing; a turn in steps of one degree if left out.
    crank_speed : float, optional
        In rad/s; may be zero or negative. Left out: the first speed at which the mechanism
        operates, zero if it names none.
    lumped : sequence of int, optional
        For each link in order the number of elements whose mass is halved onto their ends, or
        one number for all; Kumar & Chandrakar's Figure 1.5 has (1, 4, 4).
    speed_unit : str
        In which crank speeds are printed and drawn.
    crank_acceleration : float, optional
        In rad/s^2, alpha2 of Kumar & Chandrakar's eqs. 1.35 to 1.40. At each crank angle
        the crank has the speed and this acceleration: these are states, and not one run through
        all angles.

    Raises
    ------
    InputError
        If angles, speed or acceleration are no numbers, angles do not increase, or a number of
        elements is below one or beyond 1000.

    Examples
    --------
    >>> flexmech.KinematicsRequest(crank_speed=20.0, lumped=(1, 4, 4)).crank_angles.shape
    (361,)
    """

    crank_angles: FloatArray = field(default_factory=lambda: np.radians(np.arange(361.0)))
    crank_speed: float | None = None
    lumped: Sequence[int] | None = None
    speed_unit: str = "rad/s"
    crank_acceleration: float = 0.0

    def __post_init__(self) -> None:
        angles = in_radians("crank_angles", self.crank_angles)
        if angles.ndim != 1 or not angles.size or np.any(np.diff(angles) <= 0):
            raise InputError(
                f"crank_angles must be one or more in increasing order, got shape {angles.shape}"
            )
        object.__setattr__(self, "crank_angles", angles)
        if self.crank_speed is not None:
            check_number(self.crank_speed, "crank_speed", "rad/s")
        check_number(self.crank_acceleration, "crank_acceleration", "rad/s^2")
        if self.lumped is not None:
            remedy = "give the elements of each link, as (1, 4, 4)"
            counts = checked_tuple(self.lumped, object, "lumped", remedy)
            for count in counts:
                check_count(count, "lumped: each number of elements")
                if count > _MOST_LUMPS:
                    raise InputError(
                        f"lumped: {count} elements of a link are beyond {_MOST_LUMPS}; the "
                        "distributed mass is what they tend to"
                    )
            object.__setattr__(self, "lumped", counts)

    def speed_of(self, mechanism: Mechanism) -> float:
        """Crank speed in rad/s: the one asked for, or the first at which a mechanism operates."""
        if self.crank_speed is not None:
            return float(self.crank_speed)
        return float(mechanism.operating_speeds[0]) if mechanism.operating_speeds else 0.0

    def lumped_of(self, mechanism: Mechanism) -> tuple[int, ...] | None:
        """Number of elements of each link of a mechanism; None where masses stay distributed.

        Parameters
        ----------
        mechanism : Mechanism

        Returns
        -------
        tuple of int or None

        Raises
        ------
        InputError
            If there are not as many numbers as links.
        """
        links = mechanism.linkage.topology.link_names
        if self.lumped is None:
            return None
        if len(self.lumped) == 1:
            return tuple(self.lumped) * len(links)
        if len(self.lumped) != len(links):
            raise InputError(
                f"lumped: {len(self.lumped)} numbers of elements for {len(links)} links; give one "
                f"for all, or one for each of {', '.join(links)}"
            )
        return tuple(self.lumped)


def kinematics(mechanism: Mechanism, request: KinematicsRequest | None = None) -> Kinematics:
    """Angles, velocities, accelerations, joint forces and driving torque of the rigid linkage.

    The shaft turns at constant speed, or has an acceleration besides. Loads over time begin at
    crank angle zero. Kumar & Chandrakar, eqs. 1.22, 1.23 and 1.35 to 1.44 (1.36 corrected).

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
        determine the forces, the numbers of lumped masses do not fit its links, or the crank
        accelerates under a load over time.

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
    if request.crank_acceleration:
        _refuse_loads_over_time(mechanism)
    motion = mechanism.linkage.motion(request.crank_angles, speed, request.crank_acceleration)
    time = request.crank_angles / speed if speed else np.zeros_like(request.crank_angles)
    forces = mechanism.inverse_dynamics(motion, time)
    lumped = None
    if elements is not None:
        lumped = mechanism.inverse_dynamics(motion, time, elements)
    return Kinematics(kinematics_dataset(mechanism, forces, lumped, elements, request))


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
_PLANE = (_ANGLE, _LINK, "component")


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
            "angle": ((_ANGLE, _LINK), continuous_angles(linkage, motion)),
            "angular_velocity": ((_ANGLE, _LINK), motion.angular_velocity),
            "angular_acceleration": ((_ANGLE, _LINK), motion.angular_acceleration),
            **_of_centres(forces.masses, motion),
            **_of_forces(topology, forces),
        },
        coords={
            _ANGLE: request.crank_angles,
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
            dataset[name] = _ANGLE, getattr(linkage, name)(request.crank_angles)
    if lumped is not None and elements is not None:
        of_lumps = _of_forces(topology, lumped)
        dataset = dataset.assign({f"lumped_{name}": of for name, of in of_lumps.items()})
        dataset = dataset.assign(_of_lumps(forces.masses, elements, motion))
        lumps = (mass.lumps(count) for mass, count in zip(forces.masses, elements, strict=True))
        names = np.repeat(topology.link_names, [len(of_link) for of_link in lumps])
        dataset = dataset.assign_coords(lump_link=("lump", names))
    speed = request.speed_of(mechanism)
    attributes = {**origin(mechanism), "crank_speed": speed, "speed_unit": request.speed_unit}
    if request.crank_acceleration:
        acceleration = float(request.crank_acceleration)
        attributes["crank_acceleration"] = acceleration
        attributes["shaft_inertia_torque"] = mechanism.shaft_inertia * acceleration
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
        "centre_position": (_PLANE, motion.origin + arm),
        "centre_acceleration": (_PLANE, acceleration),
        "inertia_force": (_PLANE, -mass[:, None] * acceleration),
        "inertia_moment": ((_ANGLE, _LINK), -inertia * motion.angular_acceleration),
    }


def _of_forces(
    topology: Topology, forces: InverseDynamics
) -> dict[str, tuple[tuple[str, ...], FloatArray]]:
    """Joint forces and moments, torque and power."""
    names = topology.joint_names
    force = np.stack([forces.joint_force[name] for name in names], axis=1)
    moment = np.stack([forces.joint_moment[name] for name in names], axis=1)
    return {
        "joint_force": ((_ANGLE, "joint", "component"), force),
        "joint_moment": ((_ANGLE, "joint"), moment),
        "driving_torque": ((_ANGLE,), forces.driving_torque),
        "driving_power": ((_ANGLE,), forces.driving_power),
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
    plane = (_ANGLE, "lump", "component")
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
