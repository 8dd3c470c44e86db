"""From the tables of a model file to a mechanism."""

from __future__ import annotations

from collections.abc import Mapping

from flexmech.errors import InputError
from flexmech.linkages import CouplerPoint, FourBar, Linkage, RotatingArm
from flexmech.materials import Laminate
from flexmech.mechanism import Mechanism, PointMass, Provenance, Wetting
from flexmech.modelfile.hygrothermal_tables import WettedTable
from flexmech.modelfile.laminate_tables import LaminateLinkTable
from flexmech.modelfile.laminates import build_laminates, material_of
from flexmech.modelfile.messages import known_name, located
from flexmech.modelfile.table import DampedTable, suggestion
from flexmech.modelfile.tables import (
    FourBarTable,
    GeneralLinkTable,
    LinkTable,
    MaterialTable,
    ModelFile,
    RectangleLinkTable,
    RotatingArmTable,
)
from flexmech.sections import BeamSection, LaminateSection

__all__ = ["build_mechanism"]


def build_mechanism(tables: ModelFile, shown: str, file: str, sha256: str) -> Mechanism:
    """Mechanism of a model file whose keys and units are right.

    Parameters
    ----------
    tables : ModelFile
    shown : str
        What messages call the file.
    file, sha256 : str
        Base name and hash for the provenance.

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        If the lengths do not close, a link is missing or unknown, a material or joint is
        unknown, or a point mass is off its link.
    """
    with located(shown, "linkage"):
        linkage = _linkage(tables.linkage)
    topology = linkage.topology
    _check_names(shown, "links", list(tables.links), list(topology.link_names))
    _check_names(shown, "joints", list(tables.joints), list(topology.joint_names))
    for link in topology.links:
        if link.name not in tables.links:
            raise InputError(
                f"{shown}: links.{link.name}: is missing; add a table [links.{link.name}] with "
                "its section"
            )
    laminates = build_laminates(tables, shown)
    sections = {}
    for name in topology.link_names:
        table = tables.links[name]
        _check_material(shown, name, table, tables)
        with located(shown, f"links.{name}"):
            sections[name] = _section(table, tables.materials, laminates)
    return Mechanism(
        linkage=linkage,
        sections=sections,
        joint_masses={name: joint.mass for name, joint in tables.joints.items()},
        link_masses=_point_masses(tables, linkage, shown),
        gravity=tables.environment.gravity,
        operating_speeds=tuple(tables.operation.crank_speeds),
        provenance=Provenance(tables.name, tables.source, file, sha256),
        coupler_point=_coupler_point(tables.linkage),
        reference_temperature=tables.environment.reference_temperature,
        ground_thermal_expansion=(
            tables.linkage.ground_thermal_expansion
            if isinstance(tables.linkage, FourBarTable)
            else 0.0
        ),
        wetting={
            name: Wetting(table.exposed_faces, table.exposed_sides)
            for name, table in tables.links.items()
            if isinstance(table, WettedTable)
        },
    )


def _coupler_point(table: FourBarTable | RotatingArmTable) -> CouplerPoint | None:
    if isinstance(table, RotatingArmTable) or table.coupler_point is None:
        return None
    return CouplerPoint(table.coupler_point.distance, table.coupler_point.angle)


def _linkage(table: FourBarTable | RotatingArmTable) -> Linkage:
    if isinstance(table, RotatingArmTable):
        return RotatingArm(length=table.length, hub_radius=table.hub_radius)
    return FourBar(
        ground=table.ground,
        crank=table.crank,
        coupler=table.coupler,
        rocker=table.rocker,
        branch=table.branch,
    )


def _check_names(shown: str, table: str, given: list[str], known: list[str]) -> None:
    for name in given:
        if name not in known:
            raise InputError(
                f"{shown}: {table}.{name}: the linkage has no such {table.removesuffix('s')}; "
                f"{suggestion(name, known)}"
            )


def _check_material(shown: str, link: str, table: LinkTable, tables: ModelFile) -> None:
    if isinstance(table, RectangleLinkTable):
        known_name(f"{shown}: links.{link}.material", "materials", table.material, tables.materials)
    elif isinstance(table, LaminateLinkTable):
        known_name(f"{shown}: links.{link}.laminate", "laminates", table.laminate, tables.laminates)


def _section(
    table: LinkTable, materials: Mapping[str, MaterialTable], laminates: Mapping[str, Laminate]
) -> BeamSection:
    if isinstance(table, GeneralLinkTable):
        section = BeamSection(
            axial_stiffness=table.axial_stiffness,
            bending_stiffness=table.bending_stiffness,
            shear_stiffness=table.shear_stiffness,
            mass_per_length=table.mass_per_length,
            rotary_inertia=table.rotary_inertia,
            in_plane_thickness=table.in_plane_thickness,
        )
        return _with_damping(section, table)
    if isinstance(table, LaminateLinkTable):
        layers = LaminateSection(
            laminates[table.laminate], table.out_of_plane_width, table.reduction
        )
        section = BeamSection.of_laminate(layers)
        if table.damping_frequency is not None and table.damping_ratio is None:
            return section.with_damping_frequency(table.damping_frequency)
        return _with_damping(section, table)
    stated = materials[table.material]
    section = BeamSection.rectangle(
        material_of(stated),
        in_plane_thickness=table.in_plane_thickness,
        out_of_plane_width=table.out_of_plane_width,
    )
    return _with_damping(section, table if table.has_damping else stated)


def _with_damping(section: BeamSection, table: DampedTable) -> BeamSection:
    if table.damping_ratio is not None and table.damping_frequency is not None:
        return section.with_damping_ratio(table.damping_ratio, table.damping_frequency)
    return section.with_damping_time(table.damping_time or 0.0)


def _point_masses(tables: ModelFile, linkage: Linkage, shown: str) -> tuple[PointMass, ...]:
    masses = []
    for link in linkage.topology.links:
        for number, point in enumerate(tables.links[link.name].point_masses):
            if point.position > link.length:
                raise InputError(
                    f"{shown}: links.{link.name}.point_masses[{number}].position: "
                    f"got {point.position:g} m, which is beyond the end of the {link.name}; "
                    f"choose 0 to {link.length:g} m from its first joint"
                )
            masses.append(PointMass(link.name, point.position, point.mass))
    return tuple(masses)
