"""Lines that say what is attached to the links of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from flexmech.linkages import JointSpring, LinkPoint, Load, Spring
from flexmech.mechanism.parts import AttachedBody


def attachment_lines(
    bodies: Iterable[AttachedBody],
    loads: Iterable[Load],
    springs: Iterable[Spring],
    joint_springs: Iterable[JointSpring],
    shaft_inertia: float,
) -> list[str]:
    """Bodies, loads, springs and the shaft, a line for each kind that there is.

    Parameters
    ----------
    bodies : iterable of AttachedBody
    loads : iterable of Load
    springs : iterable of Spring
    joint_springs : iterable of JointSpring
    shaft_inertia : float
        In kg m^2.

    Returns
    -------
    list of str
    """
    kinds = {
        "bodies": [_body(body) for body in bodies],
        "loads": [f"{load.name} on the {_place(load.point)}, {_size(load)}" for load in loads],
        "springs": [_spring(spring) for spring in springs],
        "springs in joints": [f"{own.joint} {', '.join(_in_joint(own))}" for own in joint_springs],
        "shaft": [f"{shaft_inertia:.6g} kg m^2"] if shaft_inertia else [],
    }
    return [f"{kind}: {'; '.join(texts)}" for kind, texts in kinds.items() if texts]


def _place(point: LinkPoint) -> str:
    if point.is_ground:
        return f"ground at ({1e3 * point.x:.6g}, {1e3 * point.y:.6g}) mm"
    return f"{point.link} at {1e3 * point.x:.6g} mm"


def _body(body: AttachedBody) -> str:
    size = f"{1e3 * body.mass:.6g} g, {body.inertia:.6g} kg m^2"
    along, across = (1e3 * part for part in body.offset)
    beside = f", its centre ({along:.6g}, {across:.6g}) mm from there" if any(body.offset) else ""
    return f"{body.link} {size} at {1e3 * body.position:.6g} mm{beside}"


def _size(load: Load) -> str:
    """Greatest force and torque of a load, and over what it changes."""
    force = max(math.hypot(*pair) for pair in load.force)
    torque = max(abs(own) for own in load.torque)
    parts = ([f"{force:.6g} N"] if force else []) + ([f"{torque:.6g} N m"] if torque else [])
    size = " and ".join(parts) or "0 N"
    if load.over == "constant":
        return size
    return f"at most {size}, over the {load.over.replace('_', ' ')}"


def _spring(spring: Spring) -> str:
    ends = f"{_place(spring.first)} to {_place(spring.second)}"
    return (
        f"{spring.name} {spring.stiffness:.6g} N/m, {1e3 * spring.free_length:.6g} mm long "
        f"without force, {ends}"
    )


def _in_joint(own: JointSpring) -> Iterator[str]:
    if own.torsional_stiffness:
        free = f"free at {math.degrees(own.free_angle):.6g} deg"
        yield f"{own.torsional_stiffness:.6g} N m/rad {free}"
    if own.torsional_damping:
        yield f"{own.torsional_damping:.6g} N m s/rad"
    if own.radial_stiffness is not None:
        yield f"{own.radial_stiffness:.6g} N/m radially"
