"""Tables of a model file that describe matter: heat and water, fibres, plies, laminates."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from flexmech.errors import InputError, suggestion
from flexmech.materials import REFERENCE_TEMPERATURE, Hygrothermal, ResinContent
from flexmech.materials.constituents import DIMENSIONS
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from flexmech.modelfile.base_table import (
    ActivationEnergy,
    AngleOfTurn,
    Density,
    DiffusivityValue,
    Expansion,
    Flag,
    MoistureContent,
    MoistureExpansion,
    PlyMoistureExpansion,
    PoissonRatio,
    PositiveRatio,
    Ratio,
    SpecificDamping,
    Stress,
    Table,
    Temperature,
    Text,
    Thickness,
)
from flexmech.numbers import NOT_NEGATIVE
from flexmech.units import TEMPERATURE, TEMPERATURE_DIFFERENCE, parse_quantity


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


Weave = Literal["unidirectional", "woven"]


class ConstituentTable(Table):
    """A resin, or what a fibre has in common with one."""

    youngs_modulus: Stress = Field(description="Young's modulus E; of a fibre, along it")
    shear_modulus: Stress = Field(description="Shear modulus G")
    density: Density = Field(description="Density rho")
    poisson_ratio: PoissonRatio = Field(description="Poisson's ratio nu")
    specific_damping: SpecificDamping = Field(
        default=0.0, description="Energy lost in a cycle over its largest; 0 if left out"
    )
    name: str | None = Field(default=None, description="That of its table if left out")
    source: str = Field(default="", description="Publication or measurement of the numbers")
    uncertainty: dict[str, str | float] = Field(
        default_factory=dict, description="Of properties by their keys, in units of theirs"
    )

    @field_validator("uncertainty")
    @classmethod
    def _spreads(cls, given: dict[str, str | float]) -> dict[str, str | float]:
        for key, value in given.items():
            if key not in DIMENSIONS:
                raise InputError(f"unknown property {key!r}; {suggestion(key, list(DIMENSIONS))}")
            _spread(key, value)
        return given

    @property
    def spreads(self) -> dict[str, float]:
        """Uncertainties in SI units."""
        return {key: _spread(key, value) for key, value in self.uncertainty.items()}


def _spread(key: str, value: object) -> float:
    dimension = DIMENSIONS[key]
    if dimension is TEMPERATURE:
        dimension = TEMPERATURE_DIFFERENCE
    # As little or as much as anybody likes.
    spread = parse_quantity(value, dimension)
    if not NOT_NEGATIVE.hold(spread):
        raise InputError(f"must {NOT_NEGATIVE.words}, got {value!r}")
    return spread


class FibreTable(ConstituentTable):
    """A fibre; isotropic across it unless its transverse moduli are given."""

    transverse_modulus: Stress | None = Field(default=None, description="E across the fibre")
    transverse_shear_modulus: Stress | None = Field(
        default=None, description="G in the fibre's cross-section"
    )
    thermal_expansion: Expansion = Field(
        default=0.0,
        description="Strain per temperature; 0 if left out",
        json_schema_extra={"default": "0 1/K"},
    )
    moisture_expansion: MoistureExpansion = Field(
        default=0.0,
        description="Strain per moisture of the fibre; 0 if left out",
        json_schema_extra={"default": 0},
    )


class MatrixTable(ConstituentTable, HygrothermalTable):
    """A resin, with what heat and water do to it."""

    tensile_strength: Stress | None = Field(default=None, description="Of the dry resin")


class CompositionTable(Table):
    """What a ply is composed of."""

    fibre: Text = Field(description="Published fibre, or a table under [fibres]")
    matrix: Text = Field(description="Published resin, or a table under [matrices]")
    fibre_volume_fraction: Ratio = Field(description="Volume of fibres over that of the ply")
    rule: Literal["chamis", "halpin-tsai", "rule-of-mixtures"] = Field(
        default="chamis", description="How moduli across the fibres follow from the constituents"
    )
    weave: Weave = Field(
        default="unidirectional",
        description="'woven': balanced fabric, as crimp-free crossed layers",
    )


class AnyPlyTable(Table):
    """What all plies have in common."""

    name: str | None = Field(default=None, description="That of its table if left out")
    thickness: Thickness | None = Field(default=None, description="Of one layer of this ply")


class ConstituentPlyTable(AnyPlyTable, CompositionTable):
    """A ply computed from its fibre and its resin."""

    type: Literal["constituents"]


class OrthotropicPlyTable(AnyPlyTable):
    """A ply by its measured constants."""

    type: Literal["orthotropic"]
    longitudinal_modulus: Stress = Field(description="E1, along the fibres")
    transverse_modulus: Stress = Field(description="E2, across them")
    in_plane_shear_modulus: Stress = Field(description="G12")
    longitudinal_shear_modulus: Stress | None = Field(
        default=None, description="G13; G12 if left out"
    )
    transverse_shear_modulus: Stress | None = Field(
        default=None, description="G23; E2 / (2 (1 + nu12)) if left out"
    )
    poisson_ratio: Ratio = Field(description="nu12: contraction across over stretch along")
    density: Density = Field(description="Density rho")
    longitudinal_damping: SpecificDamping = Field(
        default=0.0, description="Energy lost in a cycle over its largest, along the fibres"
    )
    transverse_damping: SpecificDamping = Field(default=0.0, description="The same across them")
    shear_damping: SpecificDamping = Field(default=0.0, description="The same in shear")
    longitudinal_thermal_expansion: Expansion = Field(
        default=0.0,
        description="Strain along the fibres per temperature; 0 if left out",
        json_schema_extra={"default": "0 1/K"},
    )
    transverse_thermal_expansion: Expansion = Field(
        default=0.0, description="The same across them", json_schema_extra={"default": "0 1/K"}
    )
    longitudinal_moisture_expansion: PlyMoistureExpansion = Field(
        default=0.0,
        description="Strain along the fibres per moisture of the resin; 0 if left out",
        json_schema_extra={"default": 0},
    )
    transverse_moisture_expansion: PlyMoistureExpansion = Field(
        default=0.0, description="The same across them", json_schema_extra={"default": 0}
    )
    matrix: Text | None = Field(
        default=None,
        description="Resin under [matrices] by which the ply takes up water and softens",
    )
    fibre_volume_fraction: Ratio | None = Field(
        default=None, description="Volume of fibres over that of the ply, with matrix"
    )
    weave: Weave = Field(
        default="unidirectional",
        description="'woven': the constants are those of the unidirectional ply of a fabric",
    )
    resin: ResinTable | None = Field(
        default=None, description="In place of matrix: the resin that is in the ply"
    )
    constituents: CompositionTable | None = Field(
        default=None,
        description="In place of matrix: what the ply is composed of, where its constants are "
        "others than follow from it",
    )

    @model_validator(mode="after")
    def _resin_with_its_share(self) -> OrthotropicPlyTable:
        if (self.matrix is None) != (self.fibre_volume_fraction is None):
            raise InputError("matrix and fibre_volume_fraction belong together; give both or none")
        if sum(known is not None for known in (self.matrix, self.resin, self.constituents)) > 1:
            raise InputError("matrix, resin and constituents are given; keep one of them")
        return self


class IsotropicPlyTable(AnyPlyTable):
    """A layer of an isotropic material, such as a metal sheet or a core."""

    type: Literal["isotropic"]
    material: Text = Field(description="Name of a table under [materials]")


PlyTable = Annotated[
    ConstituentPlyTable | OrthotropicPlyTable | IsotropicPlyTable, Field(discriminator="type")
]


def _one_or_each(value: Any) -> str:
    return "each" if isinstance(value, list) else "one"


# Told apart before they are read: what is wrong in a list is then reported of its entry.
OneOrEach = Annotated[
    Annotated[Thickness, Tag("one")] | Annotated[list[Thickness], Tag("each")],
    Discriminator(_one_or_each),
]


class LaminateTable(Table):
    """Plies stacked through the thickness of a link, in the plane of the linkage."""

    stacking: Text = Field(
        description="Plies from the lowest y of the link's frame up (from the right to the left "
        "when looking from its first joint along it), as in '[C/G/C]', '[C@0/C@45/C@-45]s' "
        "(angle in degrees; s mirrors the stack) or '[C@90*2/G]' (twice)"
    )
    angles: list[AngleOfTurn] | None = Field(
        default=None, description="Of the fibres against the link's axis, instead of '@'"
    )
    ply_thickness: OneOrEach | None = Field(
        default=None, description="Of every layer, or one for each; else that of the ply's table"
    )
