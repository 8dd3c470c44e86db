"""What is on the links of a mechanism must be on them, and of the right kind."""

from __future__ import annotations

from collections.abc import Iterable

from flexmech.errors import InputError
from flexmech.linkages import JointSpring, LinkPoint, Load, Spring, Topology
from flexmech.mechanism.parts import AttachedBody, PointMass
from flexmech.numbers import NOT_NEGATIVE, check_instance, check_number

__all__ = ["check_bodies", "check_loads", "check_point_masses", "check_springs"]


def check_point_masses(topology: Topology, points: Iterable[PointMass]) -> None:
    """Refuse a point mass that is on no link, or negative."""
    for point in points:
        check_instance(point, PointMass, "each of link_masses", "give PointMass(link, m, kg)")
        if point.link not in topology.link_names:
            raise InputError(
                f"link_masses: unknown link {point.link!r}; links are {topology.link_names}"
            )
        length = topology.links[topology.index(point.link)].length
        check_number(point.position, f"link_masses: position on the {point.link}", "m")
        if not 0 <= point.position <= length:
            raise InputError(
                f"link_masses: position {point.position:g} m is not on the {point.link} "
                f"(0 to {length:g} m)"
            )
        check_number(point.mass, f"link_masses: mass on the {point.link}", "kg", NOT_NEGATIVE)


def check_bodies(topology: Topology, bodies: Iterable[AttachedBody]) -> None:
    """Refuse a body that is on no link."""
    for body in bodies:
        check_instance(body, AttachedBody, "each of bodies", "give AttachedBody(link, m, kg)")
        _check_on_link(topology, f"body on the {body.link}", LinkPoint(body.link, body.position))


def check_loads(topology: Topology, loads: Iterable[Load]) -> None:
    """Refuse a load that is on no link."""
    for load in loads:
        check_instance(load, Load, "each of loads", "give Load(name, point, force)")
        _check_on_link(topology, f"load {load.name}", load.point)


def check_springs(
    topology: Topology, springs: Iterable[Spring], joint_springs: Iterable[JointSpring]
) -> None:
    """Refuse a spring with an end on no link, or in a joint that is no pin or pivot.

    Parameters
    ----------
    topology : Topology
    springs : iterable of Spring
    joint_springs : iterable of JointSpring

    Raises
    ------
    InputError
        If one is.
    """
    for spring in springs:
        check_instance(spring, Spring, "each of springs", "give Spring(name, first, second)")
        for point in (spring.first, spring.second):
            _check_on_link(topology, f"spring {spring.name}", point)
    kinds = zip(topology.joint_names, topology.joint_kinds, strict=True)
    sprung = sorted(joint for joint, kind in kinds if kind in ("pin", "pivot"))
    for own in joint_springs:
        check_instance(own, JointSpring, "each of joint_springs", "give JointSpring(joint)")
        if own.joint not in sprung:
            raise InputError(f"joint_springs: {own.joint!r} is no pin or pivot; these are {sprung}")


def _check_on_link(topology: Topology, what: str, point: LinkPoint) -> None:
    """Refuse a point that is not on a link of the linkage or on the ground."""
    if point.is_ground:
        return
    if point.link not in topology.link_names:
        raise InputError(f"{what}: unknown link {point.link!r}; links are {topology.link_names}")
    length = topology.links[topology.index(point.link)].length
    if not 0 <= point.x <= length:
        raise InputError(
            f"{what}: position {point.x:g} m is not on the {point.link} (0 to {length:g} m)"
        )
