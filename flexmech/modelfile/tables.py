"""The tables of a model file, as pydantic models that hold SI floats."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from flexmech.materials import REFERENCE_TEMPERATURE
from flexmech.modelfile.hygrothermal_tables import (
    CouplerPointTable,
    HygrothermalTable,
    WettedTable,
)
from flexmech.modelfile.laminate_tables import (
    FibreTable,
    LaminateLinkTable,
    LaminateTable,
    MatrixTable,
    PlyTable,
)
from flexmech.modelfile.quantities import (
    Acceleration,
    AngularSpeed,
    BendingStiffness,
    Density,
    Expansion,
    Force,
    Length,
    LengthOrZero,
    Mass,
    MassPerLength,
    PoissonRatio,
    RotaryInertia,
    Stress,
    Temperature,
)
from flexmech.modelfile.table import DampedTable, PointMassTable, Table, Text

__all__ = [
    "FourBarTable",
    "GeneralLinkTable",
    "JointTable",
    "LinkTable",
    "MaterialTable",
    "ModelFile",
    "RectangleLinkTable",
    "RotatingArmTable",
]


class FourBarTable(Table):
    """Ground pivots O2 and O4, crank O2-A, coupler A-B, rocker O4-B."""

    kind: Literal["four-bar"]
    ground: Length = Field(description="Distance r1 between the ground pivots O2 and O4")
    crank: Length = Field(description="Crank length r2, O2 to A")
    coupler: Length = Field(description="Coupler length r3, A to B")
    rocker: Length = Field(description="Rocker length r4, O4 to B")
    branch: Literal["open", "crossed"] = Field(
        default="open", description="'open' has B above at crank angle zero"
    )
    coupler_point: CouplerPointTable | None = Field(
        default=None, description="Point of the coupler whose path matters"
    )
    ground_thermal_expansion: Expansion = Field(
        default=0.0,
        description="Of the frame between the ground pivots; 0 if left out",
        json_schema_extra={"default": "0 1/K"},
    )


class RotatingArmTable(Table):
    """One link clamped to a hub that turns about O2."""

    kind: Literal["rotating-arm"]
    length: Length = Field(description="Arm length, from the clamp to the free end")
    hub_radius: LengthOrZero = Field(
        default=0.0,
        description="Distance from the axis to the clamp; zero if left out",
        json_schema_extra={"default": "0 m"},
    )


class MaterialTable(DampedTable, HygrothermalTable):
    """An isotropic material."""

    youngs_modulus: Stress = Field(description="Young's modulus E")
    density: Density = Field(description="Density rho")
    poisson_ratio: PoissonRatio = Field(description="Poisson's ratio nu (for shear)")


class RectangleLinkTable(DampedTable, WettedTable):
    """A link whose section is a solid rectangle; its own damping overrides the material's."""

    section: Literal["rectangle"]
    material: Text = Field(description="Name of a table under [materials]")
    in_plane_thickness: Length = Field(
        description="Extent of the section in the linkage's plane: h in I = b h^3 / 12"
    )
    out_of_plane_width: Length = Field(
        description="Extent of the section along the joint axes: b in I = b h^3 / 12"
    )
    point_masses: list[PointMassTable] = Field(default_factory=list)


class GeneralLinkTable(DampedTable):
    """A link whose section is given by its stiffness and mass per length."""

    section: Literal["general"]
    axial_stiffness: Force = Field(description="EA")
    bending_stiffness: BendingStiffness = Field(description="EI, for bending in the plane")
    shear_stiffness: Force = Field(description="kGA, with the shear correction factor k")
    mass_per_length: MassPerLength = Field(description="rho A")
    rotary_inertia: RotaryInertia = Field(description="rho I, mass moment of inertia per length")
    in_plane_thickness: Length = Field(description="Extent of the section in the linkage's plane")
    point_masses: list[PointMassTable] = Field(default_factory=list)


LinkTable = Annotated[
    RectangleLinkTable | LaminateLinkTable | GeneralLinkTable, Field(discriminator="section")
]


class JointTable(Table):
    """A joint: O2, A, B and O4 of a four-bar; O2 of a rotating arm."""

    mass: Mass = Field(description="Point mass at the joint")


class EnvironmentTable(Table):
    """What surrounds the linkage."""

    gravity: tuple[Acceleration, Acceleration] = Field(
        default=(0.0, 0.0),
        description="Gravitational acceleration along x and y; none if left out",
        json_schema_extra={"default": ["0 m/s^2", "0 m/s^2"]},
    )
    reference_temperature: Temperature = Field(
        default=REFERENCE_TEMPERATURE,
        description="At which lengths, sections and moduli are as stated; 20 degC if left out",
        json_schema_extra={"default": "20 degC"},
    )


class OperationTable(Table):
    """How the mechanism is meant to run."""

    crank_speeds: list[AngularSpeed] = Field(
        default_factory=list, description="Crank speeds that the mechanism is meant for"
    )


class ModelFile(Table):
    """A model file of flexmech."""

    name: Text = Field(description="Short name, used in titles")
    source: Text = Field(description="Publication, drawing or measurement of the numbers")
    notes: str = Field(default="", description="Anything a reader should know")
    linkage: Annotated[FourBarTable | RotatingArmTable, Field(discriminator="kind")]
    materials: dict[str, MaterialTable] = Field(default_factory=dict)
    fibres: dict[str, FibreTable] = Field(default_factory=dict)
    matrices: dict[str, MatrixTable] = Field(default_factory=dict)
    plies: dict[str, PlyTable] = Field(default_factory=dict)
    laminates: dict[str, LaminateTable] = Field(default_factory=dict)
    links: dict[str, LinkTable] = Field(description="One table for each moving link")
    joints: dict[str, JointTable] = Field(default_factory=dict)
    environment: EnvironmentTable = Field(default_factory=EnvironmentTable)
    operation: OperationTable = Field(default_factory=OperationTable)
