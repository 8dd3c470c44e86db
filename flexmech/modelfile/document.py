"""A whole model file, as pydantic models that hold SI floats."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints

from flexmech import si
from flexmech.materials import REFERENCE_TEMPERATURE, Material
from flexmech.modelfile import base_table as base
from flexmech.modelfile.attachment_tables import JointTable, LoadTable, ShaftTable, SpringTable
from flexmech.modelfile.drive_table import DriveTable
from flexmech.modelfile.link_tables import LinkTable
from flexmech.modelfile.linkage_tables import FrameTable, LinkageTable
from flexmech.modelfile.material_tables import (
    FatigueTable,
    FibreTable,
    HygrothermalTable,
    LaminateTable,
    MatrixTable,
    PlyTable,
)
from flexmech.units import ANGULAR_SPEED

# Kept with its spaces, so that what is written is read back.
Name = Annotated[str, StringConstraints(pattern=r"\S")]


class MaterialTable(
    base.DampedTable,
    HygrothermalTable,
    of=Material,
    required={"youngs_modulus", "density", "poisson_ratio"},
):
    """An isotropic material."""

    fatigue: FatigueTable | None = base.optional(
        "Endurance under repeated stress; strength then counts cycles of stress"
    )

    @property
    def material(self) -> Material:
        """The material that is stated."""
        fatigue = None if self.fatigue is None else self.fatigue.strength
        return self.made(Material, hygrothermal=self.hygrothermal, fatigue=fatigue)


class EnvironmentTable(base.Table):
    """What surrounds the linkage."""

    gravity: tuple[si.Acceleration, si.Acceleration] = base.optional(
        "Gravitational acceleration along x and y; none if left out",
        (0.0, 0.0),
        ["0 m/s^2", "0 m/s^2"],
    )
    reference_temperature: si.Temperature = base.optional(
        "At which lengths, sections and moduli are as stated; 20 degC if left out",
        REFERENCE_TEMPERATURE,
        "20 degC",
    )


class OperationTable(base.Table):
    """How the mechanism is meant to run."""

    crank_speeds: list[si.WrittenSpeed] = Field(
        default_factory=list, description="Crank speeds that the mechanism is meant for"
    )

    @property
    def speed_unit(self) -> str:
        """Unit of the last speed: that in which results speak of crank speeds."""
        return self.crank_speeds[-1].unit if self.crank_speeds else ANGULAR_SPEED.unit


class ModelFile(base.Table):
    """A model file of flexmech."""

    name: Name | None = base.optional("Short name, used in titles; that of the file if left out")
    source: str = base.optional("Publication, drawing or measurement of the numbers", "")
    notes: str = base.optional("Anything a reader should know", "")
    linkage: LinkageTable
    materials: dict[str, MaterialTable] = Field(default_factory=dict)
    fibres: dict[str, FibreTable] = Field(default_factory=dict)
    matrices: dict[str, MatrixTable] = Field(default_factory=dict)
    plies: dict[str, PlyTable] = Field(default_factory=dict)
    laminates: dict[str, LaminateTable] = Field(default_factory=dict)
    links: dict[str, LinkTable] = Field(description="One table for each moving link")
    joints: dict[str, JointTable] = Field(default_factory=dict)
    shaft: ShaftTable = Field(default_factory=ShaftTable)
    drive: DriveTable | None = None
    frame: FrameTable | None = None
    loads: dict[Name, LoadTable] = Field(default_factory=dict)
    springs: dict[Name, SpringTable] = Field(default_factory=dict)
    environment: EnvironmentTable = Field(default_factory=EnvironmentTable)
    operation: OperationTable = Field(default_factory=OperationTable)
