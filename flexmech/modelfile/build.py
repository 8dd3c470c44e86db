"""From the tables of a model file to a mechanism."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

from flexmech.errors import InputError, suggestion
from flexmech.linkages import (
    CouplerPoint,
    FourBar,
    Linkage,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    RotatingArm,
)
from flexmech.materials import Laminate
from flexmech.mechanism import Mechanism, Provenance, SprungFrame, Wetting
from flexmech.modelfile.attachment_tables import JointTable
from flexmech.modelfile.attachments import (
    attached_bodies,
    joint_springs,
    loads,
    point_masses,
    springs,
)
from flexmech.modelfile.base_table import DampedTable
from flexmech.modelfile.document import MaterialTable, ModelFile
from flexmech.modelfile.laminates import build_laminates
from flexmech.modelfile.link_places import LinkPlaces, joint_pins
from flexmech.modelfile.link_tables import (
    GeneralLinkTable,
    LaminateLinkTable,
    RectangleLinkTable,
    RigidLinkTable,
)
from flexmech.modelfile.linkage_tables import FourBarTable, PlanarTable
from flexmech.modelfile.messages import Findings, known_name
from flexmech.modelfile.placing import placed_points
from flexmech.sections import (
    BeamSection,
    DampingTimes,
    LaminateSection,
    Layers,
    SheetSection,
)


def build_mechanism(
    tables: ModelFile, shown: str, provenance: Provenance, folder: Path = Path()
) -> Mechanism:
    """Mechanism of a model file whose keys and units are right.

    Parameters
    ----------
    tables : ModelFile
    shown : str
        What messages call the file.
    provenance : Provenance
        Provenance of the mechanism.
    folder : Path
        Where files that the model names are looked for.

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        If the lengths do not close, a link is missing or unknown, a material or joint is
        unknown, or a point mass is off its link.
    """
    findings = Findings(shown)
    laminates = build_laminates(tables, findings)
    linkage = _stated_linkage(tables, findings)
    stated_point, point = getattr(tables.linkage, "coupler_point", None), None
    with findings.at("linkage.coupler_point"):
        point = None if stated_point is None else stated_point.made(CouplerPoint)
    if linkage is None:
        findings.refuse()
    assert linkage is not None
    topology, places = linkage.topology, LinkPlaces(linkage)
    _check_names(findings, "links", list(tables.links), list(places.beams))
    _check_names(
        findings, "joints", _joints_of_topology(tables, linkage), list(topology.joint_names)
    )
    sections = {}
    for name in topology.link_names:
        table_name = places.table_of(name, tables.links)
        with findings.at(f"links.{table_name}"):
            if table_name not in tables.links:
                raise InputError(f"is missing; add a table [links.{table_name}] with its section")
            table = tables.links[table_name]
            if isinstance(table, RigidLinkTable):
                continue
            # What is wrong with its laminate is told there.
            known = _known_material(findings, table_name, table, tables)
            if known and getattr(table, "laminate", None) in {None, *laminates}:
                sections[name] = _section(table, tables.materials, laminates)
    masses = point_masses(tables, places, findings)
    bodies = attached_bodies(tables, places, findings)
    stated_loads = loads(tables, places, folder, findings)
    stated_springs = springs(tables, places, findings)
    in_joints = joint_springs(tables, topology, findings)
    pins = joint_pins(tables, places, findings)
    drive, frame = None, None
    with findings.at("drive"):
        drive = None if tables.drive is None else tables.drive.drive(folder)
    with findings.at("frame"):
        frame = None if tables.frame is None else tables.frame.made(SprungFrame)
    findings.refuse()
    return Mechanism(
        linkage=linkage,
        sections=sections,
        joint_masses={
            name: joint.mass
            for name, joint in tables.joints.items()
            if "mass" in joint.model_fields_set
        },
        link_masses=masses,
        gravity=tables.environment.gravity,
        operating_speeds=tuple(speed.value for speed in tables.operation.crank_speeds),
        speed_unit=tables.operation.speed_unit,
        provenance=provenance,
        coupler_point=point,
        reference_temperature=tables.environment.reference_temperature,
        ground_thermal_expansion=tables.linkage.ground_thermal_expansion,
        wetting={
            name: Wetting(table.exposed_faces, table.exposed_sides)
            for name in topology.link_names
            for table in [tables.links[places.table_of(name, tables.links)]]
        },
        bodies=bodies,
        loads=stated_loads,
        springs=stated_springs,
        joint_springs=in_joints,
        joint_pins=pins,
        shaft_inertia=tables.shaft.inertia,
        drive=drive,
        frame=frame,
    )


def _stated_linkage(tables: ModelFile, findings: Findings) -> Linkage | None:
    """Linkage of a model file; None where something is wrong, which the findings tell."""
    if isinstance(tables.linkage, PlanarTable):
        return _drawn(tables, tables.linkage, findings)
    _refuse_drawing_keys(tables, findings)
    with findings.at("linkage"):
        if isinstance(tables.linkage, FourBarTable):
            return tables.linkage.made(FourBar)
        return tables.linkage.made(RotatingArm)
    return None


def _refuse_drawing_keys(tables: ModelFile, findings: Findings) -> None:
    """Refuse keys of a drawing in the file of a linkage that is none."""
    kind = tables.linkage.kind
    remedy = f'leave it out, or draw the linkage with kind = "planar": a {kind} has its own'
    for name, link in tables.links.items():
        for key in ("points", "rigid", "length", "angle"):
            if key in link.model_fields_set:
                findings.found.append(f"links.{name}.{key}: {remedy} links")
    for name, joint in tables.joints.items():
        for key in ("kind", "links", "direction", "guide", "inertia", "offset"):
            if key in joint.model_fields_set:
                findings.found.append(f"joints.{name}.{key}: {remedy} joints")


def _drawn(tables: ModelFile, table: PlanarTable, findings: Findings) -> PlanarLinkage | None:
    places = placed_points(tables, table, findings).points
    links, joints = _links(tables, findings), _joints(tables, places, findings)
    if findings.found:
        return None
    # Points of the ground that springs alone use belong to them.
    used = {point for link in links for point in link.points}
    sprung_to = {
        end for spring in tables.springs.values() for end in spring.points if isinstance(end, str)
    }
    unused = (set(table.ground) & sprung_to) - used
    with findings.at("linkage"):
        return PlanarLinkage(
            points={name: place for name, place in places.items() if name not in unused},
            links=tuple(links),
            ground=tuple(point for point in table.ground if point not in unused),
            joints=tuple(joints),
            drawn_at=table.drawn_at,
        )
    return None


def _links(tables: ModelFile, findings: Findings) -> list[PlanarLink]:
    """Links with points; tables without are of single beams of theirs."""
    links = [
        PlanarLink(name, tuple(table.points), table.rigid)
        for name, table in tables.links.items()
        if table.points is not None
    ]
    beams = {beam.name: link for link in links for beam in link.beams}
    for name, table in tables.links.items():
        if table.points is not None:
            continue
        with findings.at(f"links.{name}"):
            if name not in beams:
                raise InputError(
                    "points is missing; add the points at its two ends, for example points = "
                    '["A", "B"]'
                )
            if table.rigid or table.point_masses or table.bodies:
                raise InputError(
                    f"is a beam of link {beams[name].name}; state rigid, point_masses and bodies "
                    "there, with beam = its number"
                )
    return links


def _joints(tables: ModelFile, places: Collection[str], findings: Findings) -> list[PlanarJoint]:
    joints = []
    for name, joint in tables.joints.items():
        with findings.at(f"joints.{name}"):
            drawn = PlanarJoint(
                name, joint.kind or "pin", tuple(joint.links), joint.direction, joint.guide or ""
            )
            _check_slider_keys(joint)
            # A table may be of a further joint at a point, which has a name but no kind.
            if name in places or drawn != PlanarJoint(name):
                joints.append(drawn)
    return joints


def _check_slider_keys(joint: JointTable) -> None:
    if joint.inertia and joint.kind != "slider":
        raise InputError(
            "inertia belongs to a slider; give another joint's body to a link, in its bodies"
        )
    if joint.offset is not None and joint.kind != "slider":
        raise InputError("offset belongs to a slider; leave it out of another joint")
    if joint.inertia and not joint.guide:
        raise InputError("a slider on the ground does not turn; leave its inertia out")


def _joints_of_topology(tables: ModelFile, linkage: Linkage) -> list[str]:
    """Joints of the file that must be of the topology: of a drawing, with mass, spring or pin."""
    if not isinstance(linkage, PlanarLinkage):
        return list(tables.joints)
    drawn = linkage.points
    return [
        name
        for name, joint in tables.joints.items()
        if name not in drawn or {"mass", "diameter"} & joint.model_fields_set or joint.has_spring
    ]


def _check_names(findings: Findings, table: str, given: list[str], known: list[str]) -> None:
    for name in given:
        with findings.at(f"{table}.{name}"):
            if name not in known:
                raise InputError(
                    f"the linkage has no such {table.removesuffix('s')}; {suggestion(name, known)}"
                )


SectionTable = RectangleLinkTable | LaminateLinkTable | GeneralLinkTable


def _known_material(findings: Findings, link: str, table: SectionTable, tables: ModelFile) -> bool:
    """Whether there are tables for what a link is made of."""
    if isinstance(table, RectangleLinkTable):
        key, plural, got, known = "material", "materials", table.material, list(tables.materials)
    elif table.laminate is not None:
        key, plural, got, known = "laminate", "laminates", table.laminate, list(tables.laminates)
    else:
        return True
    return findings.none_at(f"links.{link}.{key}", lambda: known_name(plural, got, known))


def _section(
    table: SectionTable, materials: Mapping[str, MaterialTable], laminates: Mapping[str, Laminate]
) -> BeamSection:
    if isinstance(table, GeneralLinkTable):
        return _general(table, laminates)
    if isinstance(table, LaminateLinkTable):
        return _with_damping(BeamSection.of_laminate(_layers(table, laminates)), table)
    stated = materials[table.material]
    section = BeamSection.rectangle(
        stated.material,
        in_plane_thickness=table.in_plane_thickness,
        out_of_plane_width=table.out_of_plane_width,
    )
    return _with_damping(section, table if table.has_damping else stated)


def _layers(
    table: LaminateLinkTable | GeneralLinkTable, laminates: Mapping[str, Laminate]
) -> Layers:
    assert table.laminate is not None
    laminate = laminates[table.laminate]
    if table.layers == "across width":
        assert table.in_plane_thickness is not None
        return SheetSection(laminate, table.in_plane_thickness)
    assert table.out_of_plane_width is not None
    return LaminateSection(laminate, table.out_of_plane_width, table.reduction, table.twist)


def _general(table: GeneralLinkTable, laminates: Mapping[str, Laminate]) -> BeamSection:
    layers = None if table.laminate is None else _layers(table, laminates)
    section = table.made(
        BeamSection, layers=layers, shear_stiffness=table.shear_stiffness, damping_frequency=None
    )
    if table.damping_times is None:
        return _with_damping(section, table)
    times = table.damping_times.made(DampingTimes)
    return replace(section, damping=times, damping_frequency=table.damping_frequency)


def _with_damping(section: BeamSection, table: DampedTable) -> BeamSection:
    if table.damping_time is not None:
        return section.with_damping_time(table.damping_time)
    if table.damping_frequency is None:
        return section
    if table.damping_ratio is None:
        return section.with_damping_frequency(table.damping_frequency)
    return section.with_damping_ratio(table.damping_ratio, table.damping_frequency)
