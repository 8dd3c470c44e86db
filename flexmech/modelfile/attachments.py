"""From the tables of a model file to bodies, loads and springs."""

from __future__ import annotations

import itertools
from pathlib import Path

from flexmech.errors import InputError
from flexmech.linkages import (
    GROUND,
    JointSpring,
    LinkPoint,
    Load,
    Spring,
    Topology,
    shown_crank_angle,
)
from flexmech.linkages.topology import LinkEnd
from flexmech.mechanism import AttachedBody, PointMass
from flexmech.mechanism.checks import checked_joint_springs
from flexmech.modelfile.attachment_tables import LoadTable, PlaceTable
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.link_places import LinkPlaces
from flexmech.modelfile.link_tables import RigidLinkTable
from flexmech.modelfile.linkage_tables import PlanarTable
from flexmech.modelfile.load_rows import Rows, load_rows
from flexmech.modelfile.messages import Findings


def point_masses(
    tables: ModelFile, places: LinkPlaces, findings: Findings
) -> tuple[PointMass, ...]:
    """Point masses along links.

    Parameters
    ----------
    tables : ModelFile
    places : LinkPlaces
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    tuple of PointMass
    """
    masses = []
    for link in places.names:
        for number, point in enumerate(
            tables.links[link].point_masses if link in tables.links else []
        ):
            with findings.at(f"links.{link}.point_masses[{number}].position"):
                place = places.place(link, point.position, point.beam)
                masses.append(PointMass(place.link, place.x, point.mass))
    return tuple(masses)


def attached_bodies(
    tables: ModelFile, places: LinkPlaces, findings: Findings
) -> tuple[AttachedBody, ...]:
    """Rigid bodies: masses of rigid links, bodies on links, inertias of sliders.

    Parameters
    ----------
    tables : ModelFile
    places : LinkPlaces
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    tuple of AttachedBody
    """
    bodies = []
    for link in places.names:
        table = tables.links.get(link)
        if isinstance(table, RigidLinkTable) and (table.mass or table.inertia):
            with findings.at(f"links.{link}.centre"):
                middle = places.length(link) / 2
                place = places.place(link, middle if table.centre is None else table.centre)
                bodies.append(AttachedBody(place.link, place.x, table.mass, table.inertia))
        for number, body in enumerate(table.bodies if table is not None else []):
            with findings.at(f"links.{link}.bodies[{number}].position"):
                place = places.place(link, body.position, body.beam)
                bodies.append(
                    AttachedBody(place.link, place.x, body.mass, body.inertia, body.offset)
                )
    for joint in tables.joints.values():
        if joint.inertia and joint.guide in places.beams:
            guide = places.beams[joint.guide][0]
            bodies.append(AttachedBody(guide.name, 0.0, inertia=joint.inertia))
    return tuple(bodies)


def joint_springs(
    tables: ModelFile, topology: Topology, findings: Findings
) -> tuple[JointSpring, ...]:
    """Springs and dampers in joints.

    Parameters
    ----------
    tables : ModelFile
    topology : Topology
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    tuple of JointSpring
    """
    found: list[JointSpring] = []
    for name, joint in tables.joints.items():
        with findings.at(f"joints.{name}"):
            # A joint that is not there is told of all its keys.
            if joint.spring and name in topology.joint_names:
                found += checked_joint_springs(topology, [JointSpring(name, **joint.spring)])
    return tuple(found)


def springs(tables: ModelFile, places: LinkPlaces, findings: Findings) -> tuple[Spring, ...]:
    """Springs between points.

    Parameters
    ----------
    tables : ModelFile
    places : LinkPlaces
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    tuple of Spring
    """
    found = []
    for name, table in tables.springs.items():
        with findings.at(f"springs.{name}"):
            first, second = (_spring_end(end, tables, places) for end in table.points)
            found.append(
                Spring(name, first, second, table.stiffness, table.free_length, table.damping)
            )
    return tuple(found)


def _spring_end(
    end: str | tuple[float, float] | PlaceTable, tables: ModelFile, places: LinkPlaces
) -> LinkPoint:
    if isinstance(end, PlaceTable):
        return places.place(end.link, end.position)
    if not isinstance(end, str):
        return LinkPoint(GROUND, *end)
    drawing = tables.linkage
    if isinstance(drawing, PlanarTable) and end in drawing.ground and end in drawing.points:
        return LinkPoint(GROUND, *drawing.points[end])
    first = places.ends(end)[0]
    still = _still_joints(places)
    return _of_ground(still[end], places) if end in still else places.at_end(first)


def _still_joints(places: LinkPlaces) -> dict[str, LinkEnd]:
    """Joints that stand on the ground with the link ends there: pivots, the axis of the shaft."""
    topology = places.linkage.topology
    clamps = {clamp.joint: clamp.held for clamp in topology.clamps if clamp.hub == 0.0}
    return {pivot.joint: pivot.held for pivot in topology.pivots} | clamps


def _of_ground(held: LinkEnd, places: LinkPlaces) -> LinkPoint:
    """Where an end that does not move is on the ground."""
    linkage, place = places.linkage, places.at_end(held)
    motion = linkage.motion(shown_crank_angle(linkage))
    x, y = motion.position(linkage.topology.index(place.link), place.x)
    return LinkPoint(GROUND, float(x), float(y))


def loads(
    tables: ModelFile, places: LinkPlaces, folder: Path, findings: Findings
) -> tuple[Load, ...]:
    """Forces and torques on links.

    Parameters
    ----------
    tables : ModelFile
    places : LinkPlaces
    folder : Path
        Where files that loads name are looked for.
    findings : Findings
        What is wrong; completed here.

    Returns
    -------
    tuple of Load
    """
    found = []
    for name, table in tables.loads.items():
        with findings.at(f"loads.{name}"):
            point = _load_point(table, places)
            at, rows = load_rows(table, folder)
            _check_increasing(table, at)
            _check_moved(table, rows, places)
            found.append(
                Load(
                    name,
                    point,
                    tuple((x, y) for x, y, _ in rows),
                    tuple(torque for _, _, torque in rows),
                    table.axes,
                    table.over or "constant",
                    at,
                )
            )
    return tuple(found)


def _load_point(table: LoadTable, places: LinkPlaces) -> LinkPoint:
    if table.point is None:
        assert table.link is not None
        assert table.position is not None
        return places.place(table.link, table.position)
    ends = places.ends(table.point)
    links = list(dict.fromkeys(places.parent(end.link) for end in ends))
    if table.link is not None:
        if table.link not in places.beams:
            places.place(table.link, 0.0)
        names = {beam.name for beam in places.beams[table.link]}
        ends = [end for end in ends if end.link in names]
        if not ends:
            raise InputError(
                f"link {table.link} does not pass through {table.point}; there are "
                f"{', '.join(links)}"
            )
    turns = table.axes == "link" or table.torque is not None or table.over is not None
    if len(links) > 1 and turns and table.link is None:
        raise InputError(
            f"{', '.join(links)} meet at {table.point}; say on which the load acts, as link = "
            f'"{links[0]}"'
        )
    return places.at_end(ends[0])


def _check_increasing(table: LoadTable, at: tuple[float, ...]) -> None:
    """Refuse rows whose places do not increase; names the row or the line."""
    for number, (before, place) in enumerate(itertools.pairwise(at), start=1):
        if place <= before:
            row = (
                f"table[{number}]"
                if table.file is None
                else f"file {table.file}: line {number + 2}"
            )
            raise InputError(f"{row}: its places must increase, each beyond the one before it")


def _check_moved(table: LoadTable, rows: Rows, places: LinkPlaces) -> None:
    """Refuse a force on a point of the ground, unless the link there is named."""
    if table.point is None or table.link is not None or not any(x or y for x, y, _ in rows):
        return
    if table.point in _still_joints(places):
        raise InputError(
            f"{table.point} is a point of the ground, where a force moves nothing; choose a point "
            "that moves, or name the link there whose bearing carries the force"
        )
