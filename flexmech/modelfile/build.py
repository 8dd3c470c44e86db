"""From the tables of a model file to a mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from flexmech.errors import InputError, suggestion
from flexmech.linkages import Linkage
from flexmech.materials import Laminate
from flexmech.mechanism import Mechanism, PointMass, Provenance, Wetting
from flexmech.modelfile.base_table import DampedTable
from flexmech.modelfile.document import MaterialTable, ModelFile
from flexmech.modelfile.laminates import build_laminates
from flexmech.modelfile.link_tables import (
    GeneralLinkTable,
    LaminateLinkTable,
    LinkTable,
    RectangleLinkTable,
)
from flexmech.modelfile.messages import known_name, located
from flexmech.sections import BeamSection, DampingTimes, LaminateSection, SpecificDamping

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
        linkage = tables.linkage.linkage
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
        coupler_point=tables.linkage.point,
        reference_temperature=tables.environment.reference_temperature,
        ground_thermal_expansion=tables.linkage.ground_thermal_expansion,
        wetting={
            name: Wetting(table.exposed_faces, table.exposed_sides)
            for name, table in tables.links.items()
        },
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
    elif table.laminate is not None:
        known_name(f"{shown}: links.{link}.laminate", "laminates", table.laminate, tables.laminates)


def _section(
    table: LinkTable, materials: Mapping[str, MaterialTable], laminates: Mapping[str, Laminate]
) -> BeamSection:
    if isinstance(table, GeneralLinkTable):
        return _general(table, laminates)
    if isinstance(table, LaminateLinkTable):
        layers = LaminateSection(
            laminates[table.laminate], table.out_of_plane_width, table.reduction
        )
        return _with_damping(BeamSection.of_laminate(layers), table)
    stated = materials[table.material]
    section = BeamSection.rectangle(
        stated.material,
        in_plane_thickness=table.in_plane_thickness,
        out_of_plane_width=table.out_of_plane_width,
    )
    return _with_damping(section, table if table.has_damping else stated)


def _general(table: GeneralLinkTable, laminates: Mapping[str, Laminate]) -> BeamSection:
    layers = None
    if table.laminate is not None and table.out_of_plane_width is not None:
        layers = LaminateSection(
            laminates[table.laminate], table.out_of_plane_width, table.reduction
        )
    loss, times = table.specific_damping, table.damping_times
    section = BeamSection(
        axial_stiffness=table.axial_stiffness,
        bending_stiffness=table.bending_stiffness,
        shear_stiffness=table.shear_stiffness,
        mass_per_length=table.mass_per_length,
        rotary_inertia=table.rotary_inertia,
        in_plane_thickness=table.in_plane_thickness,
        neutral_axis=table.neutral_axis,
        mass_axis=table.mass_axis,
        specific_damping=None if loss is None else SpecificDamping(**loss.model_dump()),
        layers=layers,
        free_strain=table.free_strain,
        free_curvature=table.free_curvature,
    )
    if times is None:
        return _with_damping(section, table)
    stated = DampingTimes(**times.model_dump())
    return replace(section, damping=stated, damping_frequency=table.damping_frequency)


def _with_damping(section: BeamSection, table: DampedTable) -> BeamSection:
    if table.damping_frequency is None:
        return section.with_damping_time(table.damping_time or 0.0)
    if table.damping_ratio is None:
        return section.with_damping_frequency(table.damping_frequency)
    return section.with_damping_ratio(table.damping_ratio, table.damping_frequency)


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
