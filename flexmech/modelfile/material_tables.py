"""Tables of a model file that describe matter: heat and water, fibres, plies, laminates."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from flexmech.errors import InputError, suggestion
from flexmech.materials import (
    REFERENCE_TEMPERATURE,
    FatigueStrength,
    Hygrothermal,
    PlyStrength,
    ResinContent,
)
from flexmech.materials.constituents import DIMENSIONS
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from flexmech.materials.strength import SYMBOLS
from flexmech.modelfile import base_table as base
from flexmech.units import TEMPERATURE, TEMPERATURE_DIFFERENCE, parse_quantity
from flexmech.validation import NOT_NEGATIVE


class HygrothermalTable(base.Table):
    """What heat and water do to a resin; what is left out, they do not do."""

    thermal_expansion: base.Expansion = base.optional(
        "Strain per temperature, dry; 0 if left out", 0.0, "0 1/K"
    )
    wet_thermal_expansion: base.Expansion | None = base.optional(
        "The same at equilibrium_moisture; linear between the two"
    )
    moisture_expansion: base.MoistureExpansion = base.optional(
        "Strain per moisture, as '3.02e-3 1/percent'; 0 if left out", 0.0, 0
    )
    equilibrium_moisture: base.MoistureContent | None = base.optional(
        "Mass of water over the resin's dry mass in the end at 100 % humidity"
    )
    humidity_exponent: base.PositiveRatio | None = base.optional(
        "Moisture goes with relative humidity to this power; 1 if left out"
    )
    glass_transition: base.Temperature | None = base.optional(
        "Of the dry resin; without it heat and water do not soften it"
    )
    diffusivity: base.DiffusivityValue | None = base.optional(
        "Of water in the resin at diffusivity_temperature"
    )
    diffusivity_temperature: base.Temperature | None = base.optional(
        "At which diffusivity holds; 20 degC if left out"
    )
    activation_energy: base.ActivationEnergy | None = base.optional(
        "Of diffusion, by Arrhenius' law; 0 if left out"
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
            self.thermal_expansion,
            self.wet_thermal_expansion,
            self.moisture_expansion,
            equilibrium,
            diffusivity,
            self.glass_transition,
        )


class ResinTable(HygrothermalTable):
    """The resin in a ply that is given by its constants."""

    mass_fraction: base.Ratio = base.optional("Of the dry ply", 1.0)
    volume_fraction: base.Ratio = base.optional("Of the ply", 1.0)

    @property
    def content(self) -> ResinContent:
        """The resin and its share of the ply."""
        return ResinContent(self.hygrothermal, self.mass_fraction, self.volume_fraction)


class WettedTable(base.Table):
    """Where water enters a link."""

    exposed_faces: Literal["both", "lower", "upper"] = base.optional(
        "Faces towards the sides of the link in the linkage's plane; 'lower' is the "
        "one to the right when looking from its first joint along it",
        "both",
    )
    exposed_sides: base.Flag = base.optional("Whether water enters along the joint axes too", False)


Weave = Literal["unidirectional", "woven"]


class ConstituentTable(base.Table):
    """A resin, or what a fibre has in common with one."""

    youngs_modulus: base.Stress = Field(description="Young's modulus E; of a fibre, along it")
    shear_modulus: base.Stress = Field(description="Shear modulus G")
    density: base.Density = Field(description="Density rho")
    poisson_ratio: base.PoissonRatio = Field(description="Poisson's ratio nu")
    specific_damping: base.SpecificDamping = base.optional(
        "Energy lost in a cycle over its largest; 0 if left out", 0.0
    )
    name: str | None = base.optional("That of its table if left out")
    source: str = base.optional("Publication or measurement of the numbers", "")
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

    transverse_modulus: base.Stress | None = base.optional("E across the fibre")
    transverse_shear_modulus: base.Stress | None = base.optional("G in the fibre's cross-section")
    thermal_expansion: base.Expansion = base.optional(
        "Strain per temperature; 0 if left out", 0.0, "0 1/K"
    )
    moisture_expansion: base.MoistureExpansion = base.optional(
        "Strain per moisture of the fibre; 0 if left out", 0.0, 0
    )


class MatrixTable(ConstituentTable, HygrothermalTable):
    """A resin, with what heat and water do to it."""

    tensile_strength: base.Stress | None = base.optional("Of the dry resin")


class CompositionTable(base.Table):
    """What a ply is composed of."""

    fibre: base.Text = Field(description="Published fibre, or a table under [fibres]")
    matrix: base.Text = Field(description="Published resin, or a table under [matrices]")
    fibre_volume_fraction: base.Ratio = Field(description="Volume of fibres over that of the ply")
    rule: Literal["chamis", "halpin-tsai", "rule-of-mixtures"] = base.optional(
        "How moduli across the fibres follow from the constituents", "chamis"
    )
    weave: Weave = base.optional(
        "'woven': balanced fabric, as crimp-free crossed layers", "unidirectional"
    )


class StrengthTable(base.Table):
    """Strengths of a ply at the reference temperature, dry; all positive."""

    Xt: base.Stress = Field(description="Tensile strength along the fibres")
    Xc: base.Stress = Field(description="Compressive strength along the fibres")
    Yt: base.Stress = Field(description="Tensile strength across the fibres")
    Yc: base.Stress = Field(description="Compressive strength across the fibres")
    S12: base.Stress = Field(description="Shear strength in the plane of the ply")
    S23: base.Stress | None = base.optional(
        "Shear strength in the plane across the fibres, for Hashin's criterion"
    )
    inclination_tension: base.Ratio | None = base.optional(
        "Puck's inclination of the failure curve at no transverse stress, on the side of tension "
        "(VDI 2014: 0.30 for glass, 0.35 for carbon in epoxy)"
    )
    inclination_compression: base.Ratio | None = base.optional(
        "The same on the side of compression (VDI 2014: 0.25 for glass, 0.30 for carbon in epoxy)"
    )
    source: str = base.optional("Publication or measurement of the numbers", "")

    @property
    def strength(self) -> PlyStrength:
        """The strengths that are stated."""
        return PlyStrength(
            **{name: getattr(self, symbol) for name, symbol in SYMBOLS.items()},
            inclination_tension=self.inclination_tension,
            inclination_compression=self.inclination_compression,
            source=self.source,
        )


class PointOfLifeTable(base.Table):
    """A point of an S-N line."""

    cycles: base.Cycles = Field(description="To failure")
    amplitude: base.Stress = Field(description="Half the stress range, without mean stress")


class FatigueTable(base.Table):
    """What an isotropic material bears again and again, at the reference temperature, dry."""

    tensile_strength: base.Stress = Field(
        description="Ultimate strength, which Goodman's line of mean stress needs"
    )
    endurance_limit: base.Stress | None = base.optional(
        "Stress amplitude without mean stress that is borne for endurance_cycles; it counts as "
        "borne for ever. Of the part as it is made: with its surface and size"
    )
    endurance_cycles: base.Cycles | None = base.optional("For how many endurance_limit was found")
    basquin_exponent: base.BasquinExponent | None = base.optional(
        "Of the S-N line through the endurance limit: amplitude over cycles to this power, such as "
        "-0.085"
    )
    sn_points: tuple[PointOfLifeTable, PointOfLifeTable] | None = base.optional(
        "In place of basquin_exponent: two points of the S-N line, the shorter life first; without "
        "endurance_limit, load factors are to the amplitude of the second"
    )
    source: str = base.optional("Publication or measurement of the numbers", "")

    # Read before anything else is made of it, so that what is wrong is reported of this table.
    @model_validator(mode="after")
    def _consistent(self) -> FatigueTable:
        _ = self.strength
        return self

    @property
    def strength(self) -> FatigueStrength:
        """The strengths that are stated."""
        points = self.sn_points
        return FatigueStrength(
            self.tensile_strength,
            self.endurance_limit,
            self.endurance_cycles,
            self.basquin_exponent,
            None
            if points is None
            else (
                (points[0].cycles, points[0].amplitude),
                (points[1].cycles, points[1].amplitude),
            ),
            self.source,
        )


class AnyPlyTable(base.Table):
    """What all plies have in common."""

    name: str | None = base.optional("That of its table if left out")
    thickness: base.Thickness | None = base.optional("Of one layer of this ply")


class FibrousPlyTable(AnyPlyTable):
    """What all plies with fibres have in common."""

    strength: StrengthTable | None = base.optional(
        "Strengths of the ply, of a woven one those of the fabric; results of strength need them"
    )


class ConstituentPlyTable(FibrousPlyTable, CompositionTable):
    """A ply computed from its fibre and its resin."""

    type: Literal["constituents"]


class OrthotropicPlyTable(FibrousPlyTable):
    """A ply by its measured constants."""

    type: Literal["orthotropic"]
    longitudinal_modulus: base.Stress = Field(description="E1, along the fibres")
    transverse_modulus: base.Stress = Field(description="E2, across them")
    in_plane_shear_modulus: base.Stress = Field(description="G12")
    longitudinal_shear_modulus: base.Stress | None = base.optional("G13; G12 if left out")
    transverse_shear_modulus: base.Stress | None = base.optional(
        "G23; E2 / (2 (1 + nu12)) if left out"
    )
    poisson_ratio: base.Ratio = Field(description="nu12: contraction across over stretch along")
    density: base.Density = Field(description="Density rho")
    longitudinal_damping: base.SpecificDamping = base.optional(
        "Energy lost in a cycle over its largest, along the fibres", 0.0
    )
    transverse_damping: base.SpecificDamping = base.optional("The same across them", 0.0)
    shear_damping: base.SpecificDamping = base.optional("The same in shear", 0.0)
    longitudinal_thermal_expansion: base.Expansion = base.optional(
        "Strain along the fibres per temperature; 0 if left out", 0.0, "0 1/K"
    )
    transverse_thermal_expansion: base.Expansion = base.optional(
        "The same across them", 0.0, "0 1/K"
    )
    longitudinal_moisture_expansion: base.PlyMoistureExpansion = base.optional(
        "Strain along the fibres per moisture of the resin; 0 if left out", 0.0, 0
    )
    transverse_moisture_expansion: base.PlyMoistureExpansion = base.optional(
        "The same across them", 0.0, 0
    )
    matrix: base.Text | None = base.optional(
        "Resin under [matrices] by which the ply takes up water and softens"
    )
    fibre_volume_fraction: base.Ratio | None = base.optional(
        "Volume of fibres over that of the ply, with matrix"
    )
    weave: Weave = base.optional(
        "'woven': the constants are those of the unidirectional ply of a fabric", "unidirectional"
    )
    resin: ResinTable | None = base.optional("In place of matrix: the resin that is in the ply")
    constituents: CompositionTable | None = base.optional(
        "In place of matrix: what the ply is composed of, where its constants are "
        "others than follow from it"
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
    material: base.Text = Field(description="Name of a table under [materials]")


PlyTable = Annotated[
    ConstituentPlyTable | OrthotropicPlyTable | IsotropicPlyTable, Field(discriminator="type")
]


def _one_or_each(value: Any) -> str:
    return "each" if isinstance(value, list) else "one"


# Told apart before they are read: what is wrong in a list is then reported of its entry.
OneOrEach = Annotated[
    Annotated[base.Thickness, Tag("one")] | Annotated[list[base.Thickness], Tag("each")],
    Discriminator(_one_or_each),
]


class LaminateTable(base.Table):
    """Plies stacked through the thickness of a link, in the plane of the linkage."""

    stacking: base.Text = Field(
        description="Plies from the lowest y of the link's frame up (from the right to the left "
        "when looking from its first joint along it), as in '[C/G/C]', '[C@0/C@45/C@-45]s' "
        "(angle in degrees; s mirrors the stack) or '[C@90*2/G]' (twice)"
    )
    angles: list[base.AngleOfTurn] | None = base.optional(
        "Of the fibres against the link's axis, instead of '@'"
    )
    ply_thickness: OneOrEach | None = base.optional(
        "Of every layer, or one for each; else that of the ply's table"
    )
    stress_free_temperature: base.Temperature | None = base.optional(
        "At which its dry plies do not strain each other, about that of its cure; without it "
        "stresses of cure are not counted"
    )
