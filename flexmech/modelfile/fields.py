"""Field types of model files: text with a unit in the file, SI floats in the tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from flexmech import units
from flexmech.errors import InputError
from flexmech.numbers import FINITE, NOT_NEGATIVE, POSITIVE, Bounds
from flexmech.plausible import (
    LINK_LENGTH,
    LOAD,
    THICKNESS,
    TURN,
    WIDTH,
    Plausible,
    check_plausible,
    of_dimension,
)
from flexmech.units import Dimension, parse_quantity


@dataclass(frozen=True)
class QuantityField:
    """Marks a float field as a quantity with a unit in the file.

    Parameters
    ----------
    dimension : Dimension
    bounds : Bounds
        In SI units.
    plausible : Plausible, optional
        What sizes it can have; those of its dimension if left out.
    """

    dimension: Dimension
    bounds: Bounds = FINITE
    plausible: Plausible | None = None

    def parse(self, value: object) -> float:
        """SI float of a value from a file.

        Parameters
        ----------
        value : object
            As TOML gives it: a string with a number and a unit.

        Returns
        -------
        float

        Raises
        ------
        InputError
            If it is no quantity of this dimension, out of bounds or of a size that none has.
        """
        number = parse_quantity(value, self.dimension)
        if not self.bounds.hold(number):
            raise InputError(f"must {self.bounds.words}, got {value!r}")
        plausible = self.plausible or of_dimension(self.dimension)
        if plausible is not None:
            check_plausible(number, value, plausible)
        return number

    def __get_pydantic_core_schema__(
        self, source: type[Any], handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.parse)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        text: dict[str, Any] = {
            "type": "string",
            "pattern": rf"^\s*{units.NUMBER}\s*(1\s*/\s*)?[A-Za-z\u00b5\u03bc%\u00b0]",
            "examples": list(self.dimension.examples),
        }
        if self.dimension in (units.RATIO, units.MOISTURE_EXPANSION):
            text["pattern"] = rf"^\s*{units.NUMBER}\s*(1/)?(%|percent)?\s*$"
            return {"anyOf": [{"type": "number"}, text]}
        return text


Length = Annotated[float, QuantityField(units.LENGTH, POSITIVE, LINK_LENGTH)]
Thickness = Annotated[float, QuantityField(units.LENGTH, POSITIVE, THICKNESS)]
Width = Annotated[float, QuantityField(units.LENGTH, POSITIVE, WIDTH)]
LengthOrZero = Annotated[float, QuantityField(units.LENGTH, NOT_NEGATIVE)]
Distance = Annotated[float, QuantityField(units.LENGTH)]
Curvature = Annotated[float, QuantityField(units.CURVATURE)]
Mass = Annotated[float, QuantityField(units.MASS, NOT_NEGATIVE)]
TimeOrZero = Annotated[float, QuantityField(units.TIME, NOT_NEGATIVE)]
Frequency = Annotated[float, QuantityField(units.FREQUENCY, POSITIVE)]
AngularSpeed = Annotated[float, QuantityField(units.ANGULAR_SPEED)]
Acceleration = Annotated[float, QuantityField(units.ACCELERATION)]
Stress = Annotated[float, QuantityField(units.STRESS, POSITIVE)]
Density = Annotated[float, QuantityField(units.DENSITY, POSITIVE)]
Force = Annotated[float, QuantityField(units.FORCE, POSITIVE)]
AnyForce = Annotated[float, QuantityField(units.FORCE, FINITE, LOAD)]
Torque = Annotated[float, QuantityField(units.TORQUE)]
Inertia = Annotated[float, QuantityField(units.INERTIA, NOT_NEGATIVE)]
SpringStiffness = Annotated[float, QuantityField(units.SPRING_STIFFNESS, NOT_NEGATIVE)]
RadialStiffness = Annotated[float, QuantityField(units.SPRING_STIFFNESS, POSITIVE)]
Damping = Annotated[float, QuantityField(units.DAMPING, NOT_NEGATIVE)]
TorsionalStiffness = Annotated[float, QuantityField(units.TORSIONAL_STIFFNESS, NOT_NEGATIVE)]
TorsionalDamping = Annotated[float, QuantityField(units.TORSIONAL_DAMPING, NOT_NEGATIVE)]
BendingStiffness = Annotated[float, QuantityField(units.BENDING_STIFFNESS, POSITIVE)]
MassPerLength = Annotated[float, QuantityField(units.MASS_PER_LENGTH, POSITIVE)]
RotaryInertia = Annotated[float, QuantityField(units.ROTARY_INERTIA, POSITIVE)]
PoissonRatio = Annotated[float, QuantityField(units.RATIO, Bounds(above=-1.0, below=0.5))]
Ratio = Annotated[float, QuantityField(units.RATIO)]
SpecificDamping = Annotated[float, QuantityField(units.RATIO, NOT_NEGATIVE)]
Angle = Annotated[float, QuantityField(units.ANGLE)]
AngleOfTurn = Annotated[float, QuantityField(units.ANGLE, FINITE, TURN)]
DampingRatio = Annotated[float, QuantityField(units.RATIO, Bounds(least=0.0, below=1.0))]
PositiveRatio = Annotated[float, QuantityField(units.RATIO, POSITIVE)]
MoistureContent = Annotated[float, QuantityField(units.RATIO, Bounds(above=0.0, below=1.0))]
Temperature = Annotated[float, QuantityField(units.TEMPERATURE, POSITIVE)]
Expansion = Annotated[float, QuantityField(units.EXPANSION)]
MoistureExpansion = Annotated[float, QuantityField(units.MOISTURE_EXPANSION, NOT_NEGATIVE)]
PlyMoistureExpansion = Annotated[float, QuantityField(units.MOISTURE_EXPANSION)]
DiffusivityValue = Annotated[float, QuantityField(units.DIFFUSIVITY, POSITIVE)]
ActivationEnergy = Annotated[float, QuantityField(units.ACTIVATION_ENERGY, NOT_NEGATIVE)]
