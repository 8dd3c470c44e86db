"""Tables of a model file that describe links: their sections, damping and point masses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from flexmech.errors import InputError
from flexmech.modelfile.base_table import (
    BendingStiffness,
    Curvature,
    DampedTable,
    Distance,
    Flag,
    Force,
    Inertia,
    LengthOrZero,
    Mass,
    MassPerLength,
    Ratio,
    RotaryInertia,
    SpecificDamping,
    Table,
    Text,
    Thickness,
    TimeOrZero,
    Width,
)
from flexmech.modelfile.material_tables import WettedTable

Beam = Annotated[int, Field(ge=1, strict=True)]
OF_BEAM = (
    "Of a chain of beams: number of the one from whose start the position counts, 1 is the first; "
    "from the chain's first joint along all of them if left out"
)
SECTIONLESS = "none"


class PointMassTable(Table):
    """A point mass on a link."""

    position: LengthOrZero = Field(description="Distance from the link's first joint")
    mass: Mass = Field(description="Mass of the point")
    beam: Beam | None = Field(default=None, description=OF_BEAM)


class BodyTable(Table):
    """A rigid body that is fixed to a link: a hub, a piston, a counterweight."""

    position: LengthOrZero = Field(
        description="Distance from the link's first joint of the section that it is fixed to"
    )
    mass: Mass = Field(
        default=0.0, description="0 if left out", json_schema_extra={"default": "0 kg"}
    )
    inertia: Inertia = Field(
        default=0.0,
        description="About its own centre of mass",
        json_schema_extra={"default": "0 kg m^2"},
    )
    offset: tuple[Distance, Distance] = Field(
        default=(0.0, 0.0),
        description="Of its centre of mass, along and across the link, to the left positive",
        json_schema_extra={"default": ["0 m", "0 m"]},
    )
    beam: Beam | None = Field(default=None, description=OF_BEAM)

    @model_validator(mode="after")
    def _has_mass_or_inertia(self) -> BodyTable:
        if not self.model_fields_set & {"mass", "inertia"}:
            raise InputError("mass and inertia are missing; give one of them or both")
        return self


class AnyLinkTable(DampedTable, WettedTable):
    """What all links have in common."""

    points: list[Text] | None = Field(
        default=None,
        description="Of kind planar: points at its two ends, or a chain of more that beams join",
    )
    rigid: Flag = Field(
        default=False, description="Of kind planar: whether it has mass but does not bend"
    )
    point_masses: list[PointMassTable] = Field(default_factory=list)
    bodies: list[BodyTable] = Field(
        default_factory=list, description="Rigid bodies that are fixed to it"
    )


class RectangleLinkTable(AnyLinkTable):
    """A link whose section is a solid rectangle; its own damping overrides the material's."""

    section: Literal["rectangle"]
    material: Text = Field(description="Name of a table under [materials]")
    in_plane_thickness: Thickness = Field(
        description="Extent of the section in the linkage's plane: h in I = b h^3 / 12"
    )
    out_of_plane_width: Width = Field(
        description="Extent of the section along the joint axes: b in I = b h^3 / 12"
    )


class LaminateLinkTable(AnyLinkTable):
    """A link made of a laminate whose layers lie in the plane of the linkage."""

    section: Literal["laminate"]
    laminate: Text = Field(description="Name of a table under [laminates]")
    out_of_plane_width: Width = Field(description="Extent of the section along the joint axes")
    reduction: Literal["narrow", "wide"] = Field(
        default="narrow",
        description="'narrow': free to contract along the joint axes; 'wide': held from it",
    )
    twist: Literal["free", "held"] | None = Field(
        default=None,
        description="Of off-axis plies that twist as they bend: 'held' by joints at both ends; "
        "'free'. Left out: as the link's joints have it",
    )

    def _check_frequency_alone(self) -> None:
        """Take the specific damping of the plies at that frequency."""


class DampingTimesTable(Table):
    """Kelvin-Voigt times of a section by deformation."""

    axial: TimeOrZero = Field(description="Of stretching along the neutral axis")
    bending: TimeOrZero = Field(description="Of bending about it")
    shear: TimeOrZero = Field(description="Of shear")
    warping: TimeOrZero | None = Field(
        default=None, description="Of warping cross-sections; as of bending if left out"
    )


class SpecificDampingTable(Table):
    """Energy that a section loses in a cycle over its largest, by deformation."""

    axial: SpecificDamping = Field(description="Of stretching along the neutral axis")
    bending: SpecificDamping = Field(description="Of bending about it")
    shear: SpecificDamping = Field(description="Of shear")
    warping: SpecificDamping | None = Field(
        default=None, description="Of warping cross-sections; as of bending if left out"
    )


class GeneralLinkTable(AnyLinkTable):
    """A link whose section is given by its stiffness and mass per length."""

    section: Literal["general"]
    axial_stiffness: Force = Field(description="EA")
    bending_stiffness: BendingStiffness = Field(
        description="EI about the neutral axis, for bending in the plane"
    )
    shear_stiffness: Force = Field(description="kGA, with the shear correction factor k")
    mass_per_length: MassPerLength = Field(description="rho A")
    rotary_inertia: RotaryInertia = Field(description="rho I, mass moment of inertia per length")
    in_plane_thickness: Thickness = Field(
        description="Extent of the section in the linkage's plane"
    )
    neutral_axis: Distance = Field(
        default=0.0,
        description="Distance of the neutral axis from the line of the pins, to the left positive",
        json_schema_extra={"default": "0 m"},
    )
    mass_axis: Distance = Field(
        default=0.0,
        description="The same of the centre of mass",
        json_schema_extra={"default": "0 m"},
    )
    free_strain: Ratio = Field(default=0.0, description="Of the neutral axis, without load")
    free_curvature: Curvature = Field(
        default=0.0,
        description="Without load; positive turns to the left along the link",
        json_schema_extra={"default": "0 1/m"},
    )
    damping_times: DampingTimesTable | None = Field(
        default=None, description="In place of damping_time, where deformations differ"
    )
    specific_damping: SpecificDampingTable | None = Field(
        default=None, description="With damping_frequency alone: the damping at that frequency"
    )
    laminate: Text | None = Field(
        default=None,
        description="Layers of the section, a table under [laminates], for stresses inside it; "
        "its stiffness stays as stated here",
    )
    out_of_plane_width: Width | None = Field(default=None, description="With laminate")
    reduction: Literal["narrow", "wide"] = Field(default="narrow", description="With laminate")
    twist: Literal["free", "held"] | None = Field(default=None, description="With laminate")

    @model_validator(mode="after")
    def _nothing_twice_or_alone(self) -> GeneralLinkTable:
        if (self.laminate is None) != (self.out_of_plane_width is None):
            raise InputError("laminate and out_of_plane_width belong together; give both or none")
        if self.damping_times is not None and self.has_damping:
            raise InputError(
                "damping_times and damping_time or damping_ratio are both given; keep one"
            )
        return self

    def _check_frequency_alone(self) -> None:
        if self.specific_damping is None and self.damping_times is None:
            super()._check_frequency_alone()


class RigidLinkTable(AnyLinkTable):
    """A rigid link without a section: its mass is stated, or that of its bodies."""

    section: Literal["none"] = Field(default="none", description="Left out")
    mass: Mass = Field(
        default=0.0, description="Of the link; 0 if left out", json_schema_extra={"default": "0 kg"}
    )
    inertia: Inertia = Field(
        default=0.0,
        description="About its centre of mass",
        json_schema_extra={"default": "0 kg m^2"},
    )
    centre: LengthOrZero | None = Field(
        default=None,
        description="Distance of its centre of mass from its first joint; its middle if left out",
    )

    @model_validator(mode="after")
    def _is_rigid(self) -> RigidLinkTable:
        if not self.rigid:
            raise InputError("a link without a section is rigid; write rigid = true or a section")
        return self


def _without_section(table: Any) -> Any:
    """Name what a rigid link without a section is, by which tables of links are told apart.

    Whatever else than true or false is said of it is refused there.
    """
    said = isinstance(table, Mapping) and table.get("rigid", False) is not False
    return {**table, "section": SECTIONLESS} if said and "section" not in table else table


LinkTable = Annotated[
    Annotated[
        RectangleLinkTable | LaminateLinkTable | GeneralLinkTable | RigidLinkTable,
        Field(discriminator="section"),
    ],
    BeforeValidator(_without_section),
]
