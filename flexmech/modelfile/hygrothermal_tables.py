"""Keys of a model file that say what heat and water do."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from flexmech.errors import InputError
from flexmech.materials import REFERENCE_TEMPERATURE, Hygrothermal, ResinContent
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from flexmech.modelfile.base_table import Flag, Table
from flexmech.modelfile.fields import (
    ActivationEnergy,
    DiffusivityValue,
    Expansion,
    MoistureContent,
    MoistureExpansion,
    PositiveRatio,
    Ratio,
    Temperature,
)


class HygrothermalTable(Table):
    """What heat and water do to a resin; what is left out, they do not do."""

    thermal_expansion: Expansion = Field(
        default=0.0,
        description="Strain per temperature, dry; 0 if left out",
        json_schema_extra={"default": "0 1/K"},
    )
    wet_thermal_expansion: Expansion | None = Field(
        default=None,
        description="The same at equilibrium_moisture; linear between the two",
    )
    moisture_expansion: MoistureExpansion = Field(
        default=0.0,
        description="Strain per moisture, as '3.02e-3 1/percent'; 0 if left out",
        json_schema_extra={"default": 0},
    )
    equilibrium_moisture: MoistureContent | None = Field(
        default=None,
        description="Mass of water over the resin's dry mass in the end at 100 % humidity",
    )
    humidity_exponent: PositiveRatio | None = Field(
        default=None,
        description="Moisture goes with relative humidity to this power; 1 if left out",
    )
    glass_transition: Temperature | None = Field(
        default=None, description="Of the dry resin; without it heat and water do not soften it"
    )
    diffusivity: DiffusivityValue | None = Field(
        default=None, description="Of water in the resin at diffusivity_temperature"
    )
    diffusivity_temperature: Temperature | None = Field(
        default=None, description="At which diffusivity holds; 20 degC if left out"
    )
    activation_energy: ActivationEnergy | None = Field(
        default=None, description="Of diffusion, by Arrhenius' law; 0 if left out"
    )

    @model_validator(mode="after")
    def _nothing_alone(self) -> HygrothermalTable:
        for key, needed in (
            ("wet_thermal_expansion", "equilibrium_moisture"),
            ("humidity_exponent", "equilibrium_moisture"),
            ("diffusivity_temperature", "diffusivity"),
            ("activation_energy", "diffusivity"),
        ):
            if getattr(self, key) is not None and getattr(self, needed) is None:
                raise InputError(f"{key} is given without {needed}; give both")
        return self

    @property
    def hygrothermal(self) -> Hygrothermal:
        """Hygrothermal properties that are stated."""
        equilibrium = diffusivity = None
        if self.equilibrium_moisture is not None:
            equilibrium = MoistureEquilibrium(
                self.equilibrium_moisture, self.humidity_exponent or 1.0
            )
        if self.diffusivity is not None:
            diffusivity = Diffusivity(
                self.diffusivity,
                self.diffusivity_temperature or REFERENCE_TEMPERATURE,
                self.activation_energy or 0.0,
            )
        return Hygrothermal(
            thermal_expansion=self.thermal_expansion,
            wet_thermal_expansion=self.wet_thermal_expansion,
            moisture_expansion=self.moisture_expansion,
            equilibrium=equilibrium,
            diffusivity=diffusivity,
            glass_transition=self.glass_transition,
        )


class ResinTable(HygrothermalTable):
    """The resin in a ply that is given by its constants."""

    mass_fraction: Ratio = Field(default=1.0, description="Of the dry ply")
    volume_fraction: Ratio = Field(default=1.0, description="Of the ply")

    @property
    def content(self) -> ResinContent:
        """The resin and its share of the ply."""
        return ResinContent(self.hygrothermal, self.mass_fraction, self.volume_fraction)


class WettedTable(Table):
    """Where water enters a link."""

    exposed_faces: Literal["both", "lower", "upper"] = Field(
        default="both",
        description="Faces towards the sides of the link in the linkage's plane; 'lower' is the "
        "one to the right when looking from its first joint along it",
    )
    exposed_sides: Flag = Field(
        default=False, description="Whether water enters along the joint axes too"
    )
