"""Tables of a model file that describe matter: heat and water, fibres, plies, laminates."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from flexmech import si
from flexmech.errors import InputError, suggestion
from flexmech.materials import (
    REFERENCE_TEMPERATURE,
    FatigueStrength,
    Fibre,
    Hygrothermal,
    Matrix,
    Ply,
    PlyStrength,
    ResinContent,
)
from flexmech.materials.constituents import DIMENSIONS
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from flexmech.materials.strength import SYMBOLS
from flexmech.modelfile import base_table as base
from flexmech.units import TEMPERATURE, TEMPERATURE_DIFFERENCE, parse_quantity
from flexmech.validation import NOT_NEGATIVE


class HygrothermalTable(base.RecordTable, of=Hygrothermal):
    """Hygrothermal properties of a resin; omitted ones have no effect."""

    equilibrium_moisture: si.MoistureContent | None = base.optional(
        "Mass of water over the resin's dry mass in the end at 100 % humidity"
    )
    humidity_exponent: si.PositiveRatio | None = base.optional(
        "Moisture goes with relative humidity to this power; 1 if left out"
    )
    diffusivity: si.DiffusivityValue | None = base.optional(
        "Diffusivity of water in the resin at diffusivity_temperature"
    )
    diffusivity_temperature: si.Temperature | None = base.optional(
        "At which diffusivity holds; 20 degC if left out"
    )
    activation_energy: si.ActivationEnergy | None = base.optional(
        "Activation energy of diffusion, by Arrhenius' law; 0 if left out"
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
        return self.made(Hygrothermal, equilibrium=equilibrium, diffusivity=diffusivity)


class ResinTable(HygrothermalTable, of=ResinContent):
    """The resin in a ply that is given by its constants."""

    @property
    def content(self) -> ResinContent:
        """The resin and its share of the ply."""
        return self.made(ResinContent, hygrothermal=self.hygrothermal)


class WettedTable(base.Table):
    """Where water enters a link."""

    exposed_faces: Literal["both", "lower", "upper"] = base.optional(
        "Faces towards the sides of the link in the linkage's plane; 'lower' is the "
        "one to the right when looking from its first joint along it",
        "both",
    )
    exposed_sides: base.Flag = base.optional("Whether water enters along the joint axes too", False)


Weave = Literal["unidirectional", "woven"]


class ConstituentTable(base.RecordTable):
    """What fibres and resins have in common."""

    name: str | None = base.optional("That of its table if left out")
    source: str = base.optional("Publication or measurement of the numbers", "")
    uncertainty: dict[str, str | float] = Field(
        default_factory=dict,
        description="Standard deviations of properties by their keys, in the units of these",
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


class FibreTable(ConstituentTable, of=Fibre):
    """A fibre; isotropic across it unless its transverse moduli are given."""


class MatrixTable(ConstituentTable, HygrothermalTable, of=Matrix):
    """A resin, with what heat and water do to it."""


class CompositionTable(base.Table):
    """What a ply is composed of."""

    fibre: base.Text = Field(description="Published fibre, or a table under [fibres]")
    matrix: base.Text = Field(description="Published resin, or a table under [matrices]")
    fibre_volume_fraction: si.Ratio = Field(description="Volume of fibres over that of the ply")
    rule: Literal["chamis", "halpin-tsai", "rule-of-mixtures"] = base.optional(
        "Rule of mixture for the moduli across the fibres", "chamis"
    )
    weave: Weave = base.optional(
        "'woven': balanced fabric, as crimp-free crossed layers", "unidirectional"
    )


class StrengthTable(base.RecordTable, of=PlyStrength, without=SYMBOLS):
    """Strengths of a ply at the reference temperature, dry; all positive."""

    Xt: si.Stress = Field(description="Tensile strength along the fibres")
    Xc: si.Stress = Field(description="Compressive strength along the fibres")
    Yt: si.Stress = Field(description="Tensile strength across the fibres")
    Yc: si.Stress = Field(description="Compressive strength across the fibres")
    S12: si.Stress = Field(description="Shear strength in the plane of the ply")
    S23: si.Stress | None = base.optional(
        "Shear strength in the plane across the fibres, for Hashin's criterion"
    )
    source: str = base.optional("Publication or measurement of the numbers", "")

    @property
    def strength(self) -> PlyStrength:
        """The strengths that are stated."""
        strengths = {name: getattr(self, symbol) for name, symbol in SYMBOLS.items()}
        return self.made(PlyStrength, **strengths)


class PointOfLifeTable(base.Table):
    """A point of an S-N line."""

    cycles: si.Cycles = Field(description="To failure")
    amplitude: si.Stress = Field(description="Half the stress range, without mean stress")


class FatigueTable(base.RecordTable, of=FatigueStrength):
    """What an isotropic material bears again and again, at the reference temperature, dry."""

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
        if self.sn_points is None:
            return self.made(FatigueStrength)
        first, second = ((point.cycles, point.amplitude) for point in self.sn_points)
        return self.made(FatigueStrength, sn_points=(first, second))


class AnyPlyTable(base.Table):
    """What all plies have in common."""

    name: str | None = base.optional("That of its table if left out")
    thickness: si.Thickness | None = base.optional("Thickness of one layer of this ply")


class FibrousPlyTable(AnyPlyTable):
    """What all plies with fibres have in common."""

    strength: StrengthTable | None = base.optional(
        "Strengths of the ply, of a woven one those of the fabric; results of strength need them"
    )


class ConstituentPlyTable(FibrousPlyTable, CompositionTable):
    """A ply computed from its fibre and its resin."""

    type: Literal["constituents"]


class OrthotropicPlyTable(
    FibrousPlyTable,
    base.RecordTable,
    of=Ply,
    without={"thermal_expansion", "moisture_expansion", "yield_strength"},
    required={
        "longitudinal_modulus",
        "transverse_modulus",
        "in_plane_shear_modulus",
        "poisson_ratio",
        "density",
    },
):
    """A ply by its measured constants."""

    type: Literal["orthotropic"]
    longitudinal_damping: si.SpecificDamping = base.optional(
        "Energy lost in a cycle over its largest, along the fibres", 0.0
    )
    transverse_damping: si.SpecificDamping = base.optional("The same across them", 0.0)
    shear_damping: si.SpecificDamping = base.optional("The same in shear", 0.0)
    longitudinal_thermal_expansion: si.Expansion = base.optional(
        "Strain along the fibres per temperature; 0 if left out", 0.0, "0 1/K"
    )
    transverse_thermal_expansion: si.Expansion = base.optional("The same across them", 0.0, "0 1/K")
    longitudinal_moisture_expansion: si.PlyMoistureExpansion = base.optional(
        "Strain along the fibres per moisture of the resin; 0 if left out", 0.0, 0
    )
    transverse_moisture_expansion: si.PlyMoistureExpansion = base.optional(
        "The same across them", 0.0, 0
    )
    matrix: base.Text | None = base.optional(
        "Resin under [matrices] by which the ply takes up water and softens"
    )
    fibre_volume_fraction: si.Ratio | None = base.optional(
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
    Annotated[si.Thickness, Tag("one")] | Annotated[list[si.Thickness], Tag("each")],
    Discriminator(_one_or_each),
]


class LaminateTable(base.Table):
    """Plies stacked through the thickness of a link, in the plane of the linkage."""

    stacking: base.Text = Field(
        description="Plies from the lowest y of the link's frame up (from the right to the left "
        "when looking from its first joint along it), as in '[C/G/C]', '[C@0/C@45/C@-45]s' "
        "(angle in degrees; s mirrors the stack) or '[C@90*2/G]' (twice)"
    )
    angles: list[si.AngleOfTurn] | None = base.optional(
        "Angle of the fibres to the link's axis, instead of '@'"
    )
    ply_thickness: OneOrEach | None = base.optional(
        "Thickness of every layer, or one value for each layer; the ply's own if left out"
    )
    stress_free_temperature: si.Temperature | None = base.optional(
        "At which its dry plies do not strain each other, about that of its cure; without it "
        "stresses of cure are not counted"
    )
