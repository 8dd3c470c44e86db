"""Where links need a node, or a cable's node an angle, because something takes hold there."""

from __future__ import annotations

from collections.abc import Iterator

from flexmech.linkages import LinkBody, LinkEnd, LinkMass, Load, Topology
from flexmech.linkages.link_mass import LEAST_DISTANCE
from flexmech.mechanism import Mechanism


def held_places(mechanism: Mechanism, mass: LinkMass, link: str, exact: bool) -> list[float]:
    """Places along a link that need a node.

    Point masses and bodies, and on exact beams points at which loads or springs act: a cable
    takes forces anywhere, but a torque and what turns with the link at nodes alone.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    exact : bool
        Whether it is of exact beams.

    Returns
    -------
    list of float
        In m.
    """
    places = [*mass.point_positions, *(body.position for body in mass.bodies)]
    points = [load.point.x for load in _turned_loads(mechanism, link)]
    if exact:
        points += [load.point.x for load in mechanism.loads if load.point.link == link]
        for spring in mechanism.springs:
            points += [end.x for end in (spring.first, spring.second) if end.link == link]
    least = LEAST_DISTANCE * mass.length
    for point in points:
        if all(abs(point - place) >= least for place in (0.0, mass.length, *places)):
            places.append(point)
    return places


def gripped_places(mechanism: Mechanism, mass: LinkMass, link: str) -> list[float]:
    """Places along a link of cables at which something holds or asks for the angle, in m.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    """
    topology = mechanism.linkage.topology
    ends = [end for weld in topology.welds for end in (weld.leader, weld.follower)]
    ends += [clamp.held for clamp in topology.clamps[1:]]
    places = [0.0 if end.end == "start" else mass.length for end in ends if end.link == link]
    places += [load.point.x for load in _turned_loads(mechanism, link)]
    bodies = [*mass.bodies, *turned_bodies(mechanism, mass, link)]
    return [*places, *(body.position for body in bodies)]


def turned_bodies(mechanism: Mechanism, mass: LinkMass, link: str) -> list[LinkBody]:
    """Bodies without mass at the ends of a link of cables on which springs in joints turn.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    """
    ends: set[LinkEnd] = set()
    for own in mechanism.joint_springs:
        if own.torsional_stiffness or own.torsional_damping:
            pair = ends_of_joint(mechanism.linkage.topology, own.joint)
            ends |= {end for end in pair if end is not None and end.link == link}
    places = sorted(0.0 if end.end == "start" else mass.length for end in ends)
    return [LinkBody(place, 0.0) for place in places]


def ends_of_joint(topology: Topology, joint: str) -> tuple[LinkEnd, LinkEnd | None]:
    """Following or held end of a pin or pivot, and its leading end."""
    for pin in topology.pins:
        if pin.joint == joint:
            return pin.follower, pin.leader
    pivot = next(pivot for pivot in topology.pivots if pivot.joint == joint)
    return pivot.held, None


def leading_end(topology: Topology, end: LinkEnd) -> LinkEnd:
    """Follow rigid pins and welds to the end that carries the place; springs part ends.

    Parameters
    ----------
    topology : Topology
    end : LinkEnd

    Returns
    -------
    LinkEnd
    """
    sprung = {pin.joint for pin in topology.pins if pin.sprung}
    leaders = {tie.follower: tie.leader for tie in topology.ties if tie.joint not in sprung}
    while end in leaders:
        end = leaders[end]
    return end


def hanging_on(topology: Topology, end: LinkEnd) -> list[str]:
    """Joints whose leading link ends in another joint's follower and is placed by its leader.

    What they put on that leader in a model of :func:`leading_end`, they put on the follower's link.

    Parameters
    ----------
    topology : Topology
    end : LinkEnd
        Follower of a rigid pin or weld.

    Returns
    -------
    list of str
    """
    sprung = {pin.joint for pin in topology.pins if pin.sprung}
    leaders = {tie.follower: tie.leader for tie in topology.ties if tie.joint not in sprung}
    found = []
    for tie in topology.ties:
        place: LinkEnd | None = tie.leader
        while place is not None and place != end:
            place = leaders.get(place)
        if place is not None:
            found.append(tie.joint)
    return found


def _turned_loads(mechanism: Mechanism, link: str) -> Iterator[Load]:
    """Loads on a link that turn with it, or have a torque."""
    for load in mechanism.loads:
        if load.point.link == link and (load.axes == "link" or any(load.torque)):
            yield load
