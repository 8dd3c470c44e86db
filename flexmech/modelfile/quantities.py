"""Field types of model files: text with a unit in the file, SI floats in the tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from flexmech import units
from flexmech.errors import InputError
from flexmech.units import Dimension, parse_quantity

__all__ = [
    "Acceleration",
    "ActivationEnergy",
    "Angle",
    "AngularSpeed",
    "BendingStiffness",
    "DampingRatio",
    "Density",
    "DiffusivityValue",
    "Expansion",
    "Force",
    "Frequency",
    "Length",
    "LengthOrZero",
    "Mass",
    "MassPerLength",
    "MoistureContent",
    "MoistureExpansion",
    "PoissonRatio",
    "PositiveRatio",
    "QuantityField",
    "Ratio",
    "RotaryInertia",
    "SpecificDamping",
    "Stress",
    "Temperature",
    "TimeOrZero",
]


@dataclass(frozen=True)
class QuantityField:
    """Marks a float field as a quantity with a unit in the file.

    Parameters
    ----------
    dimension : Dimension
    above, below : float, optional
        Bounds in SI units that the value must not reach.
    least : float, optional
        Bound in SI units that the value may reach.
    """

    dimension: Dimension
    above: float | None = None
    below: float | None = None
    least: float | None = None

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
            If it is no quantity of this dimension or out of bounds.
        """
        number = parse_quantity(value, self.dimension)
        too_low = (self.above is not None and number <= self.above) or (
            self.least is not None and number < self.least
        )
        if too_low or (self.below is not None and number >= self.below):
            raise InputError(f"must be {self.bounds}, got {value!r}")
        return number

    @property
    def bounds(self) -> str:
        """The bounds in words."""
        if self.below is not None and self.above is not None:
            return f"between {self.above:g} and {self.below:g}"
        if self.below is not None and self.least is not None:
            return f"at least {self.least:g} and less than {self.below:g}"
        return "zero or positive" if self.above is None else "positive"

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


Length = Annotated[float, QuantityField(units.LENGTH, above=0.0)]
LengthOrZero = Annotated[float, QuantityField(units.LENGTH, least=0.0)]
Mass = Annotated[float, QuantityField(units.MASS, least=0.0)]
TimeOrZero = Annotated[float, QuantityField(units.TIME, least=0.0)]
Frequency = Annotated[float, QuantityField(units.FREQUENCY, above=0.0)]
AngularSpeed = Annotated[float, QuantityField(units.ANGULAR_SPEED)]
Acceleration = Annotated[float, QuantityField(units.ACCELERATION)]
Stress = Annotated[float, QuantityField(units.STRESS, above=0.0)]
Density = Annotated[float, QuantityField(units.DENSITY, above=0.0)]
Force = Annotated[float, QuantityField(units.FORCE, above=0.0)]
BendingStiffness = Annotated[float, QuantityField(units.BENDING_STIFFNESS, above=0.0)]
MassPerLength = Annotated[float, QuantityField(units.MASS_PER_LENGTH, above=0.0)]
RotaryInertia = Annotated[float, QuantityField(units.ROTARY_INERTIA, above=0.0)]
PoissonRatio = Annotated[float, QuantityField(units.RATIO, above=-1.0, below=0.5)]
Ratio = Annotated[float, QuantityField(units.RATIO)]
SpecificDamping = Annotated[float, QuantityField(units.RATIO, least=0.0)]
Angle = Annotated[float, QuantityField(units.ANGLE)]
DampingRatio = Annotated[float, QuantityField(units.RATIO, least=0.0, below=1.0)]
PositiveRatio = Annotated[float, QuantityField(units.RATIO, above=0.0)]
MoistureContent = Annotated[float, QuantityField(units.RATIO, above=0.0, below=1.0)]
Temperature = Annotated[float, QuantityField(units.TEMPERATURE, above=0.0)]
Expansion = Annotated[float, QuantityField(units.EXPANSION)]
MoistureExpansion = Annotated[float, QuantityField(units.MOISTURE_EXPANSION, least=0.0)]
DiffusivityValue = Annotated[float, QuantityField(units.DIFFUSIVITY, above=0.0)]
ActivationEnergy = Annotated[float, QuantityField(units.ACTIVATION_ENERGY, least=0.0)]
