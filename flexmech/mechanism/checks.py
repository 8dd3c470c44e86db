"""What is on the links of a mechanism must be on them, of the right kind, and apart."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from flexmech.errors import InputError
from flexmech.linkages import (
    LEAST_DISTANCE,
    JointSpring,
    Linkage,
    LinkPoint,
    Load,
    Spring,
    Topology,
)
from flexmech.mechanism.parts import AttachedBody, PointMass, Wetting
from flexmech.numbers import (
    NOT_NEGATIVE,
    check_instance,
    check_number,
    checked_number,
    checked_tuple,
)


def check_joint_masses(topology: Topology, masses: Mapping[str, float]) -> None:
    """Refuse a mass that is in no joint, or negative."""
    check_instance(masses, Mapping, "joint_masses", "give masses in kg by the names of joints")
    for joint, mass in masses.items():
        if joint not in topology.joint_names:
            raise InputError(
                f"joint_masses: unknown joint {joint!r}; joints are {topology.joint_names}"
            )
        check_number(mass, f"joint_masses: {joint}", "kg", NOT_NEGATIVE)


def checked_speeds(speeds: Iterable[float]) -> tuple[float, ...]:
    """Crank speeds; refuse what is no number."""
    remedy = "give crank speeds in rad/s, as (20.0,)"
    given = checked_tuple(speeds, object, "operating_speeds", remedy)
    return tuple(checked_number(speed, "each of operating_speeds", "rad/s") for speed in given)


def checked_point_masses(topology: Topology, points: Iterable[PointMass]) -> tuple[PointMass, ...]:
    """Point masses; refuse one that is on no link, or negative."""
    remedy = "give PointMass(link, m, kg) in a tuple"
    given = checked_tuple(points, PointMass, "link_masses", remedy)
    for point in given:
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
    return given


def checked_bodies(topology: Topology, bodies: Iterable[AttachedBody]) -> tuple[AttachedBody, ...]:
    """Bodies; refuse one that is on no link."""
    remedy = "give AttachedBody(link, m, kg) in a tuple"
    given = checked_tuple(bodies, AttachedBody, "bodies", remedy)
    for body in given:
        _check_on_link(topology, f"body on the {body.link}", LinkPoint(body.link, body.position))
    return given


def checked_loads(topology: Topology, loads: Iterable[Load]) -> tuple[Load, ...]:
    """Loads; refuse one that is on no link."""
    given = checked_tuple(loads, Load, "loads", "give Load(name, point, force) in a tuple")
    for load in given:
        _check_on_link(topology, f"load {load.name}", load.point)
    return given


def checked_springs(topology: Topology, springs: Iterable[Spring]) -> tuple[Spring, ...]:
    """Springs; refuse one with an end on no link."""
    given = checked_tuple(springs, Spring, "springs", "give Spring(name, first, second) in a tuple")
    for spring in given:
        for point in (spring.first, spring.second):
            _check_on_link(topology, f"spring {spring.name}", point)
    return given


def checked_joint_springs(
    topology: Topology, springs: Iterable[JointSpring]
) -> tuple[JointSpring, ...]:
    """Springs in joints; refuse one in a joint that is no pin or pivot."""
    kinds = zip(topology.joint_names, topology.joint_kinds, strict=True)
    turning = sorted(joint for joint, kind in kinds if kind in ("pin", "pivot"))
    remedy = "give JointSpring(joint) in a tuple"
    given = checked_tuple(springs, JointSpring, "joint_springs", remedy)
    for own in given:
        if own.joint not in turning:
            raise InputError(
                f"spring in joint {own.joint}: it is no pin or pivot; these are {turning}"
            )
    return given


def sprung_linkage(linkage: Linkage, springs: Iterable[JointSpring]) -> Linkage:
    """The linkage with springs alone holding the joints that have a radial stiffness.

    Parameters
    ----------
    linkage : Linkage
    springs : iterable of JointSpring

    Returns
    -------
    Linkage

    Raises
    ------
    InputError
        If the linkage says that springs hold a joint where none has a radial stiffness.
    """
    sprung = linkage.topology.sprung_joints
    held = {own.joint for own in springs if own.radial_stiffness is not None}
    if loose := sorted(sprung - held):
        raise InputError(
            f"joint_springs: the linkage has springs alone hold {', '.join(loose)}, and there is "
            "none; give JointSpring(joint, radial_stiffness=N/m), or leave it out of the sprung "
            "joints of the linkage"
        )
    return linkage if held == sprung else linkage.sprung_at(held)


def check_wetting(topology: Topology, wetting: Mapping[str, Wetting]) -> None:
    """Refuse wetted faces of no link."""
    remedy = "give Wetting() by the names of links"
    check_instance(wetting, Mapping, "wetting", remedy)
    for name, faces in wetting.items():
        if name not in topology.link_names:
            raise InputError(f"wetting: unknown link {name!r}; links are {topology.link_names}")
        check_instance(faces, Wetting, f"wetting of the {name}", remedy)


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


def places_apart(
    points: Iterable[LinkPoint], link: str, length: float, taken: Sequence[float]
) -> list[float]:
    """Places of points on a link at which a mesh can have nodes.

    Those nearer than 1/500 of the link's length to another one or to an end are left out: an
    element between them would be stiffer than round-off allows.

    Parameters
    ----------
    points : iterable of LinkPoint
        Of any links.
    link : str
    length : float
        Of the link in m.
    taken : sequence of float
        Where there are nodes already, m from the start.

    Returns
    -------
    list of float
        In m from the start.
    """
    found: list[float] = []
    for x in sorted({point.x for point in points if point.link == link}):
        others = (0.0, length, *taken, *found)
        if min(abs(x - other) for other in others) >= LEAST_DISTANCE * length:
            found.append(x)
    return found
