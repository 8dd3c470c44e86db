"""Values of kinematics at positions: of centres of mass, joints, frame, lumped masses, points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.aspects.shaking import shaking_of
from flexmech.analyses.schema import Values
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import (
    FourBar,
    InverseDynamics,
    LinkMass,
    RigidMotion,
    Slider,
    Topology,
    moving_points,
)
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism


def values_of(
    mechanism: Mechanism,
    forces: InverseDynamics,
    lumped: InverseDynamics | None,
    point: tuple[float, float] | None = None,
    shaft_torque: float | FloatArray = 0.0,
) -> Values:
    """All that has extremes: motion of links and points, forces, torque and power.

    Parameters
    ----------
    mechanism : Mechanism
    forces : InverseDynamics
        In positions (A,), by distributed masses.
    lumped : InverseDynamics or None
        By lumped masses.
    point : tuple of float, optional
        About which the shaking moment is taken, m.
    shaft_torque : float or ndarray, shape (A,)
        Of the drive on the shaft itself, N m.

    Returns
    -------
    dict
        With the names of points and sliders as ``point`` and ``slider``.
    """
    motion, linkage = forces.motion, mechanism.linkage
    shaking = shaking_of(mechanism, forces, point, shaft_torque)
    found = {
        "angular_velocity": motion.angular_velocity,
        "angular_acceleration": motion.angular_acceleration,
        **_of_centres(forces.masses, motion),
        **_of_forces(linkage.topology, forces),
        "shaking_force": shaking.force,
        "shaking_moment": shaking.moment,
        "moment_point": np.array(shaking.point),
        **_of_points(mechanism, motion),
    }
    if lumped is not None:
        by_lumps = _of_forces(linkage.topology, lumped)
        found |= {f"lumped_{name}": values for name, values in by_lumps.items()}
    if isinstance(linkage, FourBar):
        for name in ("transmission_angle", "reversed_transmission_angle"):
            found[name] = getattr(linkage, name)(motion.crank_angle)
    return found


def _of_centres(masses: Sequence[LinkMass], motion: RigidMotion) -> Values:
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
        "centre_position": motion.origin + arm,
        "centre_acceleration": acceleration,
        "inertia_force": -mass[:, None] * acceleration,
        "inertia_moment": -inertia * motion.angular_acceleration,
    }


def _of_forces(topology: Topology, forces: InverseDynamics) -> Values:
    """Joint forces and moments, torque and power."""
    names = topology.joint_names
    return {
        "joint_force": np.stack([forces.joint_force[name] for name in names], axis=1),
        "joint_moment": np.stack([forces.joint_moment[name] for name in names], axis=1),
        "driving_torque": forces.driving_torque,
        "driving_power": forces.driving_power,
    }


def of_lumps(mechanism: Mechanism, forces: InverseDynamics, elements: Sequence[int]) -> Values:
    """Place, size, acceleration and inertia force of every lumped mass, and its link.

    Parameters
    ----------
    mechanism : Mechanism
    forces : InverseDynamics
        In positions (A,).
    elements : sequence of int
        Of each link.

    Returns
    -------
    dict

    Raises
    ------
    InputError
        If no link has distributed mass.
    """
    places, sizes, accelerations, links = [], [], [], []
    for link, (mass, count) in enumerate(zip(forces.masses, elements, strict=True)):
        for x, lump in mass.lumps(count):
            links.append(mechanism.linkage.topology.link_names[link])
            places.append(x)
            sizes.append(lump)
            accelerations.append(_acceleration(forces.motion, link, x, mass.offset))
    if not sizes:
        raise InputError("lumped: no link has distributed mass that could be lumped; leave it out")
    acceleration = np.stack(accelerations, axis=1)
    return {
        "lump_link": links,
        "lump_position": np.array(places),
        "lump_mass": np.array(sizes),
        "lump_acceleration": acceleration,
        "lump_inertia_force": -np.array(sizes)[:, None] * acceleration,
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


@dataclass(frozen=True)
class _Point:
    """A point of a link: number of the link, and place along and across it in m."""

    link: int
    x: float
    y: float = 0.0


def _points_of(mechanism: Mechanism) -> dict[str, _Point]:
    """Points that move, by name, the coupler point of the model file last."""
    topology = mechanism.linkage.topology
    places = moving_points(mechanism.linkage)
    found = {name: _Point(*topology.end_place(place)) for name, place in places.items()}
    if (own := mechanism.coupler_point) is not None:
        along, across = own.distance * direction(np.asarray(own.angle))
        found["coupler point"] = _Point(topology.index("coupler"), float(along), float(across))
    return found


def _of_points(mechanism: Mechanism, motion: RigidMotion) -> Values:
    """Position, velocity and acceleration of points, and of sliders along their lines."""
    points, found = _points_of(mechanism), Values()
    kinds = ("position", "velocity", "acceleration")
    if points:
        for kind in kinds:
            at = getattr(motion, kind)
            values = [at(place.link, place.x, place.y) for place in points.values()]
            found[f"point_{kind}"] = np.stack(values, axis=1)
        found["point"] = list(points)
    topology = mechanism.linkage.topology
    if topology.sliders:
        slides = [_along_line(topology, motion, slider) for slider in topology.sliders]
        for kind, along in zip(kinds, zip(*slides, strict=True), strict=True):
            found[f"slider_{kind}"] = np.stack(along, axis=1)
        found["slider"] = [slider.joint for slider in topology.sliders]
    return found


def _along_line(topology: Topology, motion: RigidMotion, slider: Slider) -> tuple[FloatArray, ...]:
    """Position, velocity and acceleration of a slider along its line, (A,) each.

    On a link that rotates they are relative to it, and count from the link's start.
    """
    place = topology.end_place(slider.link_end)
    moved = motion.position(*place), motion.velocity(*place), motion.acceleration(*place)
    if not slider.guide:
        along = direction(np.asarray(slider.direction))
        return tuple(np.asarray(each @ along) for each in moved)
    guide = topology.index(slider.guide)
    origin = (motion.origin, motion.origin_velocity, motion.origin_acceleration)
    s, v, a = (each - own[:, guide] for each, own in zip(moved, origin, strict=True))
    omega, alpha = motion.angular_velocity[:, guide], motion.angular_acceleration[:, guide]
    turned = motion.angle[:, guide] + slider.direction
    along, across = direction(turned), normal(turned)

    def part(vector: FloatArray, axis: FloatArray) -> FloatArray:
        return np.asarray(np.sum(vector * axis, axis=-1))

    # Rates of s . along, whose direction turns with the guide.
    rate = part(v, along) + omega * part(s, across)
    second = part(a, along) + 2 * omega * part(v, across) + alpha * part(s, across)
    return part(s, along), rate, second - omega**2 * part(s, along)
