"""Values of kinematics at positions: of centres of mass, joints, frame, lumped masses, points.

Least and greatest values over a turn or a run, of all quantities that have extremes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from flexmech.analyses.aspects.shaking import shaking_of
from flexmech.analyses.extremes import extremes, mean_over_turns
from flexmech.analyses.schema import Values, schema_of
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
    rocker_swing,
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
        Torque of the drive on the shaft itself, N m.

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
        Elements of each link.

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
    """Acceleration of a point of a link; shape (..., 2)."""
    quarter = motion.acceleration(link, x)
    if not y:
        return quarter
    across = normal(motion.angle[..., link])
    along = direction(motion.angle[..., link])
    square = motion.angular_velocity[..., link, None] ** 2
    return np.asarray(
        quarter - y * (motion.angular_acceleration[..., link, None] * along + square * across)
    )


class LinkPlace(NamedTuple):
    """A point of a link.

    Parameters
    ----------
    link : int
        Number of the link.
    x, y : float
        Along the link from its start, and across it, in m.
    """

    link: int
    x: float
    y: float = 0.0


def points_of(mechanism: Mechanism) -> dict[str, LinkPlace]:
    """Points that move, by name, the coupler point of the model file last."""
    topology = mechanism.linkage.topology
    places = moving_points(mechanism.linkage)
    found = {name: LinkPlace(*topology.end_place(place)) for name, place in places.items()}
    if (own := mechanism.coupler_point) is not None:
        along, across = own.distance * direction(np.asarray(own.angle))
        found["coupler point"] = LinkPlace(topology.index("coupler"), float(along), float(across))
    return found


def _of_points(mechanism: Mechanism, motion: RigidMotion) -> Values:
    """Position, velocity and acceleration of points, and of sliders along their lines."""
    points, found = points_of(mechanism), Values()
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


Forces = Callable[[FloatArray], tuple[InverseDynamics, InverseDynamics | None]]
"""From crank angles (A,) to the forces there, by distributed masses and by lumped ones if any."""

SCHEMA = schema_of(__package__)

# Quantities with extremes by their names: the variable, and what of it counts, its ``size``, its
# ``value``, or a component by its number. Those of one group are over one dimension.
_SOUGHT: tuple[dict[str, tuple[str, str | int]], ...] = (
    {
        "angular_velocity": ("angular_velocity", "size"),
        "angular_acceleration": ("angular_acceleration", "size"),
        "centre_acceleration": ("centre_acceleration", "size"),
    },
    {"joint_force": ("joint_force", "size")},
    {"driving_torque": ("driving_torque", "value")},
    {"lumped_joint_force": ("lumped_joint_force", "size")},
    {"lumped_driving_torque": ("lumped_driving_torque", "value")},
    {"driving_power": ("driving_power", "value")},
    {"shaking_force": ("shaking_force", "size"), "shaking_moment": ("shaking_moment", "value")},
    {
        "position_x": ("point_position", 0),
        "position_y": ("point_position", 1),
        "velocity": ("point_velocity", "size"),
        "acceleration": ("point_acceleration", "size"),
    },
    {
        f"slider_{name}": (f"slider_{name}", "value")
        for name in ("position", "velocity", "acceleration")
    },
    {
        "transmission_angle": ("transmission_angle", "value"),
        "reversed_transmission_angle": ("reversed_transmission_angle", "value"),
    },
)


class Sought(NamedTuple):
    """A number at positions whose extremes are sought.

    Parameters
    ----------
    name, of : str
        What it is, and link, joint or point that it is of; empty of the whole linkage.
    unit : str
        SI unit.
    values : ndarray, shape (A,)
    """

    name: str
    of: str
    unit: str
    values: FloatArray


def sought(values: Values, mechanism: Mechanism) -> Iterator[Sought]:
    """Every number that has extremes, always in one order.

    Parameters
    ----------
    values : dict
        Values of :func:`flexmech.analyses.kinematics.positions.values_of`.
    mechanism : Mechanism

    Yields
    ------
    Sought
    """
    topology = mechanism.linkage.topology
    names = {"link": topology.link_names, "joint": topology.joint_names, **values}
    for group in _SOUGHT:
        known = {name: each for name, each in group.items() if each[0] in values}
        if not known:
            continue
        dims = SCHEMA.variables[next(iter(known.values()))[0]].over
        for number, of in enumerate(names[dims[1]] if len(dims) > 1 and dims[1] in names else [""]):
            for name, (variable, counts) in known.items():
                own = values[variable][:, number] if of else values[variable]
                yield Sought(name, of, SCHEMA.variables[variable].unit, _counted(own, counts))


def _counted(values: Any, counts: str | int) -> FloatArray:
    if isinstance(counts, int):
        return np.asarray(values[:, counts])
    if counts == "value":
        return np.asarray(values)
    return np.asarray(np.linalg.norm(values, axis=-1) if values.ndim > 1 else abs(values))


def extreme_values(
    mechanism: Mechanism,
    at: Forces,
    crank_angles: FloatArray,
    point: tuple[float, float] | None = None,
    shaft_torque: float | Callable[[FloatArray], FloatArray] = 0.0,
    *,
    step: float | None = None,
) -> Values:
    """Least and greatest values from the first crank angle to the last, and the mean power.

    Between the angles too, unless the linkage cannot be moved through all of them.

    Parameters
    ----------
    mechanism : Mechanism
    at : callable
        See :data:`Forces`.
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    point : tuple of float, optional
    shaft_torque : float or callable
        Torque of the drive on the shaft itself, N m; or what gives it at the angles.
    step : float, optional
        Where the angles are times: in what steps extremes are sought, in s.

    Returns
    -------
    dict
        Variables over ``extreme``, and single numbers.
    """

    def found_at(angles: FloatArray) -> list[Sought]:
        torque = shaft_torque(angles) if callable(shaft_torque) else shaft_torque
        return list(sought(values_of(mechanism, *at(angles), point, torque), mechanism))

    def values_at(angles: FloatArray) -> FloatArray:
        return np.stack([one.values for one in found_at(angles)], axis=1)

    named = found_at(crank_angles[:1])
    found, mean = extremes(values_at, crank_angles, step=step), None
    if step is None and np.isfinite(found.error).all():
        mean = mean_over_turns(lambda angles: at(angles)[0].driving_power, crank_angles)
    values: Values = {
        "least": found.least,
        "least_angle": found.least_angle,
        "greatest": found.greatest,
        "greatest_angle": found.greatest_angle,
        "extreme_error": found.error,
        "extreme_quantity": [one.name for one in named],
        "extreme_of": [one.of for one in named],
        "extreme_unit": [one.unit for one in named],
    }
    if mean is not None:
        values["mean_driving_power"], values["mean_driving_power_error"] = mean
        linkage = mechanism.linkage
        if isinstance(linkage, FourBar) and linkage.grashof_class == "crank-rocker":
            values["rocker_swing"] = rocker_swing(linkage)
    return values
