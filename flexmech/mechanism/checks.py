"""Checks that parts on links are of the right kind, on the link, and apart."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from flexmech.arrays import ROUND_OFF
from flexmech.errors import InputError
from flexmech.linkages import (
    AttachmentPoint,
    Drive,
    JointSpring,
    Linkage,
    Load,
    LockedCrank,
    MotorDrive,
    Spring,
    Topology,
)
from flexmech.linkages.link_mass import LEAST_DISTANCE
from flexmech.mechanism.parts import AttachedBody, JointPin, PointMass, SprungFrame, Wetting
from flexmech.validation import (
    NOT_NEGATIVE,
    check_instance,
    check_number,
    checked_number,
    checked_tuple,
)

Part = TypeVar("Part")

PARTS: Mapping[str, tuple[type, str]] = {
    "link_masses": (PointMass, "PointMass(link, m, kg)"),
    "bodies": (AttachedBody, "AttachedBody(link, m, kg)"),
    "loads": (Load, "Load(name, point, force)"),
    "springs": (Spring, "Spring(name, first, second)"),
    "joint_springs": (JointSpring, "JointSpring(joint)"),
    "joint_pins": (JointPin, "JointPin(joint, m)"),
}
"""Fields of a mechanism with parts on its links or in its joints: of what class, and how made."""


def check_joint_masses(topology: Topology, masses: Mapping[str, float]) -> None:
    """Refuse a mass that is in no joint, or negative."""
    check_instance(masses, Mapping, "joint_masses", "give masses in kg by the names of joints")
    for joint, mass in masses.items():
        if joint not in topology.joint_names:
            raise InputError(
                f"joint_masses: unknown joint {joint!r}; joints are {topology.joint_names}"
            )
        check_number(mass, f"joint_masses: {joint}", "kg", NOT_NEGATIVE)


def check_shaft(inertia: float, drive: object) -> None:
    """Refuse an inertia below zero, and a value that is no drive; None means no drive."""
    check_number(inertia, "shaft_inertia", "kg m^2", NOT_NEGATIVE)
    remedy = "give a drive that turns the crank, as ConstantSpeed(20.0), or a LawDrive"
    if drive is not None and not isinstance(drive, MotorDrive):
        check_instance(drive, Drive, "drive", remedy)
    if isinstance(drive, LockedCrank):
        raise InputError(f"drive: a locked crank does not turn; {remedy}")


def check_frame(frame: object) -> None:
    """Refuse what is no frame on springs."""
    if frame is not None:
        check_instance(frame, SprungFrame, "frame", "give a SprungFrame, or leave it out")


def checked_speeds(speeds: Iterable[float]) -> tuple[float, ...]:
    """Crank speeds; refuse what is no number."""
    remedy = "give crank speeds in rad/s, as (20.0,)"
    given = checked_tuple(speeds, object, "operating_speeds", remedy)
    return tuple(checked_number(speed, "each of operating_speeds", "rad/s") for speed in given)


def checked_parts(topology: Topology, name: str, parts: Iterable[Part]) -> tuple[Part, ...]:
    """Parts of a mechanism that are on its links or in its joints.

    Parameters
    ----------
    topology : Topology
    name : str
        Name of the mechanism's field: one of :data:`PARTS`.
    parts : iterable

    Returns
    -------
    tuple

    Raises
    ------
    InputError
        If one is of another kind, on no link, or in no pin or pivot.
    """
    kind, made = PARTS[name]
    given = checked_tuple(parts, kind, name, f"give {made} in a tuple")
    kinds = zip(topology.joint_names, topology.joint_kinds, strict=True)
    turning = sorted(joint for joint, kind_of_joint in kinds if kind_of_joint in ("pin", "pivot"))
    for attached in given:
        if isinstance(attached, PointMass):
            _check_on_link(topology, name, attached.link, attached.position)
            check_number(attached.mass, f"{name}: mass on the {attached.link}", "kg", NOT_NEGATIVE)
        elif isinstance(attached, AttachedBody):
            _check_on_link(
                topology, f"body on the {attached.link}", attached.link, attached.position
            )
        elif isinstance(attached, Load):
            _check_on_link(topology, f"load {attached.name}", attached.point.link, attached.point.x)
        elif isinstance(attached, Spring):
            for end in (attached.first, attached.second):
                if not end.is_ground:
                    _check_on_link(topology, f"spring {attached.name}", end.link, end.x)
        elif isinstance(attached, JointSpring) and attached.joint not in turning:
            raise InputError(
                f"spring in joint {attached.joint}: it is no pin or pivot; these are {turning}"
            )
        elif isinstance(attached, JointPin):
            _check_pin(topology, attached)
    return given


def _check_pin(topology: Topology, pin: JointPin) -> None:
    """Refuse a pin in a joint that has none, and eyes of links that do not meet there."""
    known = topology.turning_ends
    if pin.joint not in known:
        raise InputError(
            f"diameter of joint {pin.joint}: it is no pin, pivot or slider; these are "
            f"{sorted(known)}"
        )
    links = [end.link for end in known[pin.joint] if end is not None]
    for eye in pin.eyes:
        if eye.link not in links:
            raise InputError(
                f"pin of joint {pin.joint}: the {eye.link} has no eye there; give those of "
                f"{' and '.join(links)}"
            )


def sprung_linkage(linkage: Linkage, springs: Iterable[JointSpring]) -> Linkage:
    """The linkage with springs in place of rigid bearings in joints with a radial stiffness.

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
        If the linkage has springs in a joint where none has a radial stiffness.
    """
    sprung = linkage.topology.sprung_joints
    radial = {spring.joint for spring in springs if spring.radial_stiffness is not None}
    if loose := sorted(sprung - radial):
        raise InputError(
            f"joint_springs: the linkage has springs alone hold {', '.join(loose)}, and there is "
            "none; give JointSpring(joint, radial_stiffness=N/m), or leave it out of the sprung "
            "joints of the linkage"
        )
    return linkage if radial == sprung else linkage.sprung_at(radial)


def check_wetting(topology: Topology, wetting: Mapping[str, Wetting]) -> None:
    """Refuse wetted faces of no link."""
    remedy = "give Wetting() by the names of links"
    check_instance(wetting, Mapping, "wetting", remedy)
    for name, faces in wetting.items():
        if name not in topology.link_names:
            raise InputError(f"wetting: unknown link {name!r}; links are {topology.link_names}")
        check_instance(faces, Wetting, f"wetting of the {name}", remedy)


def _check_on_link(topology: Topology, what: str, link: str, x: float) -> None:
    """Refuse a point that is not on a link of the linkage."""
    if link not in topology.link_names:
        raise InputError(f"{what}: unknown link {link!r}; links are {topology.link_names}")
    check_number(x, f"{what}: position on the {link}", "m")
    length = topology.links[topology.index(link)].length
    if not 0 <= x <= length * (1 + ROUND_OFF):
        raise InputError(f"{what}: position {x:g} m is not on the {link} (0 to {length:g} m)")


def places_apart(
    points: Iterable[AttachmentPoint], link: str, length: float, taken: Sequence[float]
) -> list[float]:
    """Places of points on a link at which a mesh can have nodes.

    Those nearer than 1/500 of the link's length to another one or to an end are left out: an
    element between them would be stiffer than round-off allows.

    Parameters
    ----------
    points : iterable of AttachmentPoint
        Points of any links.
    link : str
    length : float
        Length of the link in m.
    taken : sequence of float
        Where there are nodes already, m from the start.

    Returns
    -------
    list of float
        In m from the start.
    """
    places: list[float] = []
    for x in sorted({point.x for point in points if point.link == link}):
        others = (0.0, length, *taken, *places)
        if min(abs(x - other) for other in others) >= LEAST_DISTANCE * length:
            places.append(x)
    return places
