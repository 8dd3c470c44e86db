"""Tables of a model file that describe links: their sections, damping and point masses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Set
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from flexmech import si
from flexmech.errors import InputError
from flexmech.mechanism import AttachedBody, PointMass
from flexmech.modelfile import base_table as base
from flexmech.modelfile.material_tables import WettedTable
from flexmech.sections import BeamSection, DampingTimes, LayerDirection, SpecificDamping

Beam = Annotated[int, Field(ge=1, strict=True)]
OF_BEAM = (
    "Chain of beams: number of the beam from whose start the position counts, 1 is the first; "
    "from the chain's first joint along all of them if left out"
)
SECTIONLESS = "none"


class PointMassTable(base.RecordTable, of=PointMass):
    """A point mass on a link."""

    beam: Beam | None = base.optional(OF_BEAM)


class BodyTable(base.RecordTable, of=AttachedBody):
    """A rigid body that is fixed to a link: a hub, a piston, a counterweight."""

    beam: Beam | None = base.optional(OF_BEAM)

    @model_validator(mode="after")
    def _has_mass_or_inertia(self) -> BodyTable:
        if not self.model_fields_set & {"mass", "inertia"}:
            raise InputError("mass and inertia are missing; give one of them or both")
        return self


Corner = tuple[si.Distance, si.Distance]


class PlateTable(base.Table):
    """A rigid plate that is fixed to a section of a link: a body with the mass of its shape."""

    shape: Literal["triangle"] = Field(description="Shape of a plate of even thickness")
    corners: tuple[Corner, Corner, Corner] | None = base.optional(
        "Corners along and across the link from its first joint; left out: the coupler's joints "
        "and its coupler_point, or the three points of a link of a planar linkage"
    )
    position: si.LengthOrZero | None = base.optional(
        "Distance from the link's first joint of the section that carries it; opposite to its "
        "centre of mass if left out"
    )
    mass: si.BodyMass | None = base.optional("Mass of the plate; or give material and thickness")
    material: base.Text | None = base.optional("With thickness: name of a table under [materials]")
    thickness: si.Width | None = base.optional("With material: along the joint axes")

    @model_validator(mode="after")
    def _has_a_mass(self) -> PlateTable:
        stated = {key for key in ("mass", "material", "thickness") if getattr(self, key)}
        if stated not in ({"mass"}, {"material", "thickness"}):
            raise InputError("give either mass, or material and thickness, of the plate")
        return self


def _kind_of_body(value: Any) -> str:
    plate = isinstance(value, PlateTable) or (isinstance(value, Mapping) and "shape" in value)
    return "plate" if plate else "body"


AnyBodyTable = Annotated[
    Annotated[BodyTable, Tag("body")] | Annotated[PlateTable, Tag("plate")],
    Discriminator(_kind_of_body),
]


class AnyLinkTable(base.DampedTable, WettedTable):
    """What all links have in common."""

    points: list[base.Text] | None = base.optional(
        "Planar linkages: points at its two ends, or a chain of more that beams join"
    )
    length: si.Length | None = base.optional(
        "Planar linkages: length between its two points; places one that is not drawn"
    )
    angle: si.AngleOfTurn | None = base.optional(
        "Planar linkages, with length: angle from its first point to its second, to the "
        "ground's x axis, at drawn_at; drawn_at itself for the crank if left out"
    )
    rigid: base.Flag = base.optional(
        "Planar linkages: whether it has mass but does not bend", False
    )
    point_masses: list[PointMassTable] = Field(default_factory=list)
    bodies: list[AnyBodyTable] = Field(
        default_factory=list, description="Rigid bodies that are fixed to it"
    )


class RectangleLinkTable(AnyLinkTable):
    """A link whose section is a solid rectangle; its own damping overrides the material's."""

    section: Literal["rectangle"]
    material: base.Text = Field(description="Name of a table under [materials]")
    in_plane_thickness: si.Thickness = Field(
        description="Extent of the section in the linkage's plane: h in I = b h^3 / 12"
    )
    out_of_plane_width: si.Width = Field(
        description="Extent of the section along the joint axes: b in I = b h^3 / 12"
    )


LAYERS = (
    "'through thickness': stacked in the linkage's plane, which bending bends them through; "
    "'across width': parallel to that plane, as cut from a flat sheet, stacked along the joint axes"
)


def check_size(layers: LayerDirection, given: Set[str]) -> None:
    """Refuse a laminate whose other extent is missing, or stated where the laminate has it.

    Parameters
    ----------
    layers : str
        Where they are stacked.
    given : set of str
        Keys of the table.

    Raises
    ------
    InputError
        That names the keys.
    """
    across = layers == "across width"
    needed, other = "out_of_plane_width", "in_plane_thickness"
    if across:
        needed, other = other, needed
    if needed not in given:
        raise InputError(f'{needed} is missing, which layers = "{layers}" needs')
    if other in given:
        raise InputError(
            f'{other}: with layers = "{layers}" it is the thickness of the laminate; leave it out, '
            f"and give {needed}"
        )
    for key in {"reduction", "twist"} & given if across else ():
        raise InputError(
            f'{key} is of layers through the thickness; leave it out of layers = "{layers}"'
        )


class LaminateLinkTable(AnyLinkTable):
    """A link made of a laminate."""

    section: Literal["laminate"]
    laminate: base.Text = Field(description="Name of a table under [laminates]")
    layers: LayerDirection = base.optional(LAYERS, "through thickness")
    out_of_plane_width: si.Width | None = base.optional(
        "Extent of the section along the joint axes; with layers across the width the laminate's "
        "thickness is that"
    )
    in_plane_thickness: si.Thickness | None = base.optional(
        "With layers across the width alone: extent of the section in the linkage's plane"
    )
    reduction: Literal["narrow", "wide"] = base.optional(
        "'narrow': free to contract along the joint axes; 'wide': held from it", "narrow"
    )
    twist: Literal["free", "held"] | None = base.optional(
        "Twist of off-axis plies that twist as they bend: 'held' by joints at both ends; "
        "'free'. Left out: as the link's joints have it"
    )

    @model_validator(mode="after")
    def _has_its_size(self) -> LaminateLinkTable:
        check_size(self.layers, self.model_fields_set)
        return self

    def _check_frequency_alone(self) -> None:
        """Take the specific damping of the plies at that frequency."""


class DampingTimesTable(
    base.RecordTable,
    of=DampingTimes,
    without={"stated"},
    required={"axial", "bending", "shear"},
):
    """Kelvin-Voigt times of a section by deformation."""


class SpecificDampingTable(base.RecordTable, of=SpecificDamping):
    """Energy that a section loses in a cycle over its largest, by deformation."""


class GeneralLinkTable(AnyLinkTable, base.RecordTable, of=BeamSection):
    """A link whose section is given by its stiffness and mass per length."""

    section: Literal["general"]
    shear_stiffness: si.ShearStiffness = base.optional(
        'kGA, with the shear correction factor k; "rigid", or left out, of a beam that does not '
        "shear",
        math.inf,
        "rigid",
    )
    damping_times: DampingTimesTable | None = base.optional(
        "In place of damping_time, where deformations differ"
    )
    specific_damping: SpecificDampingTable | None = base.optional(
        "With damping_frequency alone: the damping at that frequency"
    )
    laminate: base.Text | None = base.optional(
        "Layers of the section, a table under [laminates], for stresses inside it; "
        "its stiffness stays as stated here"
    )
    layers: LayerDirection = base.optional("With laminate", "through thickness")
    out_of_plane_width: si.Width | None = base.optional("With laminate through the thickness")
    reduction: Literal["narrow", "wide"] = base.optional("With laminate", "narrow")
    twist: Literal["free", "held"] | None = base.optional("With laminate")

    @model_validator(mode="after")
    def _nothing_twice_or_alone(self) -> GeneralLinkTable:
        across = self.layers == "across width"
        if self.laminate is None and across:
            raise InputError("layers is of a laminate, which is missing; give both or none")
        if (self.laminate is None or across) != (self.out_of_plane_width is None):
            raise InputError(
                "laminate and out_of_plane_width belong together; give both or none, and "
                "out_of_plane_width of no laminate with layers across the width"
            )
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

    section: Literal["none"] = base.optional("Left out", "none")
    mass: si.Mass = base.optional("Mass of the link; 0 if left out", 0.0, "0 kg")
    inertia: si.Inertia = base.optional("About its centre of mass", 0.0, "0 kg m^2")
    centre: si.LengthOrZero | None = base.optional(
        "Distance of its centre of mass from its first joint; its middle if left out"
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
