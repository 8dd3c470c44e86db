"""From the tables of a model file to bodies, loads and springs; loads that vary, from CSV too."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from flexmech.errors import InputError
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    CouplerPoint,
    FourBar,
    JointSpring,
    Load,
    PlanarLinkage,
    Spring,
    Topology,
    picture_crank_angle,
)
from flexmech.linkages.topology import LinkEnd
from flexmech.mechanism import AttachedBody, PointMass
from flexmech.mechanism.checks import checked_parts
from flexmech.modelfile.attachment_tables import LoadTable, PlaceTable
from flexmech.modelfile.csv_files import check_rows, csv_lines
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.link_places import LinkPlaces
from flexmech.modelfile.link_tables import PlateTable, RigidLinkTable
from flexmech.modelfile.linkage_tables import PlanarTable
from flexmech.modelfile.messages import Findings, known_name
from flexmech.plausible import LOAD, Plausible, check_plausible, of_dimension
from flexmech.units import ANGLE, FORCE, TIME, TORQUE, Dimension, parse_quantity

# Area of a plate over the square of its longest side, below which its corners are on a line.
_FLAT = 1e-6
Corners = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


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
                masses.append(point.made(PointMass, link=place.link, position=place.x))
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
            key = f"links.{link}.bodies[{number}]"
            if isinstance(body, PlateTable):
                if body.material is not None and not findings.none_at(
                    f"{key}.material",
                    partial(known_name, "materials", body.material, list(tables.materials)),
                ):
                    continue
                with findings.at(f"{key}.corners"):
                    corners = _checked_corners(body, link, tables, places)
                    with findings.at(f"{key}.position"):
                        bodies.append(_plates_body(body, corners, link, tables, places))
                continue
            with findings.at(f"{key}.position"):
                place = places.place(link, body.position, body.beam)
                bodies.append(body.made(AttachedBody, link=place.link, position=place.x))
    for joint in tables.joints.values():
        if joint.inertia and joint.guide in places.beams:
            guide = places.beams[joint.guide][0]
            bodies.append(AttachedBody(guide.name, 0.0, inertia=joint.inertia))
    return tuple(bodies)


def _plates_body(
    table: PlateTable, corners: Corners, link: str, tables: ModelFile, places: LinkPlaces
) -> AttachedBody:
    """The body of a plate, whose centre is the mean of the corners of its triangle.

    About it the moment of inertia is the mass times the sum of the squared sides over 36.
    """
    beam, mass = places.beams[link][0], table.mass
    if mass is None:
        assert table.material is not None
        assert table.thickness is not None
        density = tables.materials[table.material].material.density
        mass = density * _area(corners) * table.thickness
    x, y = (sum(parts) / 3 for parts in zip(*corners, strict=True))
    foot = min(max(x, 0.0), beam.length)
    if table.position is not None:
        foot = places.place(beam.name, table.position).x
    squares = sum(math.dist(*side) ** 2 for side in itertools.combinations(corners, 2))
    return AttachedBody(beam.name, foot, mass, mass * squares / 36, (x - foot, y), corners)


def _area(corners: Corners) -> float:
    (x, y), *others = corners
    (along, across), (further, beside) = ((one - x, other - y) for one, other in others)
    return abs(along * beside - across * further) / 2


def _checked_corners(
    table: PlateTable, link: str, tables: ModelFile, places: LinkPlaces
) -> Corners:
    """Corners of a plate in the axes of the link's first beam; refuses those on one line."""
    corners = table.corners or _corners(link, tables, places)
    longest = max(math.dist(*side) for side in itertools.combinations(corners, 2))
    if _area(corners) <= _FLAT * longest**2:
        raise InputError("they stand on one line; give three that span a triangle")
    return corners


def _corners(link: str, tables: ModelFile, places: LinkPlaces) -> Corners:
    """Corners of a plate that a file leaves out, in the axes of the link's first beam."""
    linkage, beam = places.linkage, places.beams[link][0]
    point = getattr(tables.linkage, "coupler_point", None)
    if isinstance(linkage, FourBar) and link == "coupler" and point is not None:
        x, y = point.made(CouplerPoint).place.tolist()
        return (0.0, 0.0), (beam.length, 0.0), (x, y)
    if isinstance(linkage, PlanarLinkage):
        names = next(drawn.points for drawn in linkage.links if drawn.name == link)
        first, second, *others = (complex(*linkage.points[name]) for name in names)
        if len(others) == 1:
            third = (others[0] - first) * beam.length / (second - first)
            return (0.0, 0.0), (beam.length, 0.0), (third.real, third.imag)
    raise InputError(
        "is missing; add the plate's three corners along and across the link, for example "
        'corners = [["0 mm", "0 mm"], ["80 mm", "0 mm"], ["40 mm", "30 mm"]]'
    )


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
    joint_springs: list[JointSpring] = []
    for name, joint in tables.joints.items():
        with findings.at(f"joints.{name}"):
            # The message on a joint that does not exist names all its keys.
            if joint.has_spring and name in topology.joint_names:
                stated = [joint.made(JointSpring, joint=name)]
                joint_springs += checked_parts(topology, "joint_springs", stated)
    return tuple(joint_springs)


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
    springs = []
    for name, table in tables.springs.items():
        with findings.at(f"springs.{name}"):
            first, second = (_spring_end(end, tables, places) for end in table.points)
            springs.append(table.made(Spring, name=name, first=first, second=second))
    return tuple(springs)


def _spring_end(
    end: str | tuple[float, float] | PlaceTable, tables: ModelFile, places: LinkPlaces
) -> AttachmentPoint:
    if isinstance(end, PlaceTable):
        return places.place(end.link, end.position)
    if not isinstance(end, str):
        return AttachmentPoint(GROUND, *end)
    drawing = tables.linkage
    if isinstance(drawing, PlanarTable) and end in drawing.ground and end in drawing.points:
        return AttachmentPoint(GROUND, *drawing.points[end])
    first = places.ends(end)[0]
    fixed = _fixed_joints(places)
    return _of_ground(fixed[end], places) if end in fixed else places.at_end(first)


def _fixed_joints(places: LinkPlaces) -> dict[str, LinkEnd]:
    """Joints fixed to the ground with the link ends there: pivots, the axis of the shaft."""
    topology = places.linkage.topology
    clamps = {clamp.joint: clamp.link_end for clamp in topology.clamps if clamp.hub == 0.0}
    return {pivot.joint: pivot.link_end for pivot in topology.pivots} | clamps


def _of_ground(end: LinkEnd, places: LinkPlaces) -> AttachmentPoint:
    """Where an end that does not move is on the ground."""
    linkage, place = places.linkage, places.at_end(end)
    motion = linkage.motion(picture_crank_angle(linkage))
    x, y = motion.position(linkage.topology.index(place.link), place.x)
    return AttachmentPoint(GROUND, float(x), float(y))


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
    loads = []
    for name, table in tables.loads.items():
        with findings.at(f"loads.{name}"):
            point = _load_point(table, places)
            at, rows = load_rows(table, folder)
            _check_increasing(table, at)
            _check_moved(table, rows, places)
            loads.append(
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
    return tuple(loads)


def _load_point(table: LoadTable, places: LinkPlaces) -> AttachmentPoint:
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
    if table.point in _fixed_joints(places):
        raise InputError(
            f"{table.point} is a point of the ground, where a force moves nothing; choose a point "
            "that moves, or name the link there whose bearing carries the force"
        )


Rows = list[tuple[float, float, float]]
"""Force along x and y, and torque, of each place."""

COLUMNS = {"crank_angle": ("crank_angle_deg", "deg"), "time": ("time_s", "s")}
FORCE_COLUMNS = ("force_x_N", "force_y_N")
TORQUE_COLUMN = "torque_Nm"


def load_rows(table: LoadTable, folder: Path) -> tuple[tuple[float, ...], Rows]:
    """Places of a load, and force and torque of each.

    Parameters
    ----------
    table : LoadTable
    folder : Path
        Folder of the model file.

    Returns
    -------
    tuple of float
        In rad or s; empty for a load that does not vary.
    list of (float, float, float)
        In N, N and N m.

    Raises
    ------
    InputError
        If a row is none, its values have other units or sizes that none has, or the file cannot
        be read; names the row or the line.
    """
    if table.over is None:
        return (), [(*(table.force or (0.0, 0.0)), table.torque or 0.0)]
    dimensions = (ANGLE if table.over == "crank_angle" else TIME, FORCE, FORCE, TORQUE)
    if table.file is not None:
        return _of_file(folder / table.file, table.file, table.over, dimensions)
    assert table.table is not None
    if not table.table:
        raise InputError("table is empty; give at least one row")
    at: list[float] = []
    rows: Rows = []
    for number, row in enumerate(table.table):
        if len(row) not in (3, 4):
            raise InputError(
                f"table[{number}]: got {len(row)} values; give {table.over}, force along x and y, "
                "and a torque if there is one"
            )
        _append(at, rows, row, dimensions, f"table[{number}]")
    return tuple(at), rows


def _append(
    at: list[float],
    rows: Rows,
    row: Sequence[object],
    dimensions: Sequence[Dimension],
    where: str,
) -> None:
    """Add a row of quantities, each with its unit."""
    try:
        place, x, y, *torque = (
            _sized(value, dimension) for value, dimension in zip(row, dimensions, strict=False)
        )
    except InputError as error:
        raise error.within(where) from error
    at.append(place)
    rows.append((x, y, *(torque or [0.0])))  # type: ignore[arg-type]


def _sized(value: object, dimension: Dimension) -> float:
    size = parse_quantity(value, dimension)
    plausible: Plausible | None = LOAD if dimension is FORCE else of_dimension(dimension)
    if plausible is not None:
        check_plausible(size, value, plausible)
    return size


def _of_file(
    path: Path, shown: str, over: str, dimensions: Sequence[Dimension]
) -> tuple[tuple[float, ...], Rows]:
    column, unit = COLUMNS[over]
    head = [column, *FORCE_COLUMNS, TORQUE_COLUMN]
    titles, lines = csv_lines(path, shown, "load")
    if titles not in (head, head[:3]):
        raise InputError(f"file {shown}: its first line must be {','.join(head)}")
    check_rows(lines, titles, shown)
    at: list[float] = []
    rows: Rows = []
    for number, line in enumerate(lines, start=2):
        where = f"file {shown}: line {number}"
        cells = zip(line, (unit, "N", "N", "N m"), strict=False)
        _append(at, rows, [f"{cell} {of}" for cell, of in cells], dimensions, where)
    return tuple(at), rows
