"""What tables of a model file have in common: quantities with units, damping, known keys."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    StringConstraints,
    ValidationError,
    model_validator,
)
from pydantic_core import (
    CoreSchema,
    ErrorDetails,
    InitErrorDetails,
    PydanticCustomError,
    core_schema,
)

from flexmech import units
from flexmech.errors import InputError, suggestion
from flexmech.plausible import (
    LIFE,
    LINK_LENGTH,
    LOAD,
    THICKNESS,
    TURN,
    WIDTH,
    Plausible,
    check_plausible,
    of_dimension,
)
from flexmech.units import Dimension, parse_quantity, split_quantity
from flexmech.validation import FINITE, NOT_NEGATIVE, POSITIVE, Bounds


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
    infinite : str
        Word for a quantity without bound; empty where there is none.
    """

    dimension: Dimension
    bounds: Bounds = FINITE
    plausible: Plausible | None = None
    infinite: str = ""

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
        if self.infinite and value == self.infinite:
            return math.inf
        try:
            number = parse_quantity(value, self.dimension)
        except InputError as error:
            other = f', or "{self.infinite}"' if self.infinite else ""
            raise InputError(f"{error}{other}") from None
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
        return {"anyOf": [{"const": self.infinite}, text]} if self.infinite else text


class Written(NamedTuple):
    """A quantity in SI units, and the unit in which it was written."""

    value: float
    unit: str


class WrittenField(QuantityField):
    """Marks a field of quantities whose unit is kept.

    Parameters
    ----------
    dimension : Dimension
    bounds : Bounds
    plausible : Plausible, optional
    infinite : str
        As of :class:`QuantityField`.
    """

    def __get_pydantic_core_schema__(
        self, source: type[Any], handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self._written)

    def _written(self, value: object) -> Written:
        return Written(self.parse(value), split_quantity(str(value), self.dimension)[1])


Length = Annotated[float, QuantityField(units.LENGTH, POSITIVE, LINK_LENGTH)]
Thickness = Annotated[float, QuantityField(units.LENGTH, POSITIVE, THICKNESS)]
Width = Annotated[float, QuantityField(units.LENGTH, POSITIVE, WIDTH)]
LengthOrZero = Annotated[float, QuantityField(units.LENGTH, NOT_NEGATIVE)]
Distance = Annotated[float, QuantityField(units.LENGTH)]
Curvature = Annotated[float, QuantityField(units.CURVATURE)]
Mass = Annotated[float, QuantityField(units.MASS, NOT_NEGATIVE)]
TimeOrZero = Annotated[float, QuantityField(units.TIME, NOT_NEGATIVE)]
Frequency = Annotated[float, QuantityField(units.FREQUENCY, POSITIVE)]
WrittenSpeed = Annotated[Written, WrittenField(units.ANGULAR_SPEED)]
Acceleration = Annotated[float, QuantityField(units.ACCELERATION)]
Stress = Annotated[float, QuantityField(units.STRESS, POSITIVE)]
PressureVelocity = Annotated[float, QuantityField(units.PRESSURE_VELOCITY, POSITIVE)]
Density = Annotated[float, QuantityField(units.DENSITY, POSITIVE)]
Force = Annotated[float, QuantityField(units.FORCE, POSITIVE)]
ShearStiffness = Annotated[float, QuantityField(units.FORCE, POSITIVE, infinite="rigid")]
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
Cycles = Annotated[float, QuantityField(units.RATIO, POSITIVE, LIFE)]
BasquinExponent = Annotated[float, QuantityField(units.RATIO, Bounds(above=-1.0, below=0.0))]
PositiveRatio = Annotated[float, QuantityField(units.RATIO, POSITIVE)]
MoistureContent = Annotated[float, QuantityField(units.RATIO, Bounds(above=0.0, below=1.0))]
Temperature = Annotated[float, QuantityField(units.TEMPERATURE, POSITIVE)]
Expansion = Annotated[float, QuantityField(units.EXPANSION)]
MoistureExpansion = Annotated[float, QuantityField(units.MOISTURE_EXPANSION, NOT_NEGATIVE)]
PlyMoistureExpansion = Annotated[float, QuantityField(units.MOISTURE_EXPANSION)]
DiffusivityValue = Annotated[float, QuantityField(units.DIFFUSIVITY, POSITIVE)]
ActivationEnergy = Annotated[float, QuantityField(units.ACTIVATION_ENERGY, NOT_NEGATIVE)]


def optional(description: str, default: Any = None, shown: Any = None) -> Any:
    """Key that may be left out.

    Parameters
    ----------
    description : str
        What the key says.
    default : object
        What it is then, as tables hold it.
    shown : object
        The same as it would be written in a file, if that is another thing.

    Returns
    -------
    pydantic.Field
    """
    extra = None if shown is None else {"default": shown}
    return Field(default=default, description=description, json_schema_extra=extra)


Flag = Annotated[bool, Field(strict=True)]
"""true or false, and no text or number that may mean one of them."""
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class Table(BaseModel):
    """A table that refuses unknown keys and names the nearest known one."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    @model_validator(mode="wrap")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Find unknown keys along with all that is wrong of the known ones."""
        known = list(cls.model_fields)
        unknown = [key for key in data if key not in known] if isinstance(data, Mapping) else []
        if not unknown:
            return handler(data)
        findings = [
            InitErrorDetails(
                type=PydanticCustomError(
                    "unknown_key",
                    "unknown key '{key}'; {remedy}",
                    {"key": key, "remedy": suggestion(str(key), known)},
                ),
                input=data[key],
            )
            for key in unknown
        ]
        try:
            handler({key: value for key, value in data.items() if key in known})
        except ValidationError as error:
            findings += [_again(finding) for finding in error.errors(include_url=False)]
        raise ValidationError.from_exception_data(cls.__name__, findings)


def _again(finding: ErrorDetails) -> InitErrorDetails:
    """A finding of pydantic as one that can be raised with others."""
    kind: str | PydanticCustomError = finding["type"]
    context = finding.get("ctx", {})
    if kind == "unknown_key":
        kind = PydanticCustomError("unknown_key", "unknown key '{key}'; {remedy}", context)
    return InitErrorDetails(type=kind, loc=finding["loc"], input=finding["input"], ctx=context)


class DampedTable(Table):
    """Kelvin-Voigt damping, as a time or as a damping ratio at a frequency."""

    damping_time: TimeOrZero | None = optional(
        "Kelvin-Voigt time tau: stress = E (strain + tau d(strain)/dt)"
    )
    damping_ratio: DampingRatio | None = optional(
        "Fraction of critical damping at damping_frequency"
    )
    damping_frequency: Frequency | None = optional("Frequency at which damping_ratio holds")

    @model_validator(mode="after")
    def _one_kind_of_damping(self) -> DampedTable:
        has_ratio = self.damping_ratio is not None
        has_frequency = self.damping_frequency is not None
        if self.damping_time is not None and (has_ratio or has_frequency):
            raise InputError(
                "damping_time and damping_ratio or damping_frequency are both given; keep "
                "damping_time, or the others without it"
            )
        if has_ratio and not has_frequency:
            raise InputError(
                "damping_ratio is given without damping_frequency; give both, or damping_time"
            )
        if has_frequency and not has_ratio:
            self._check_frequency_alone()
        return self

    def _check_frequency_alone(self) -> None:
        """Refuse a damping frequency without a ratio where no specific damping can stand in."""
        raise InputError(
            "damping_frequency is given without damping_ratio; give both, or damping_time instead"
        )

    @property
    def has_damping(self) -> bool:
        """Whether any damping is stated here."""
        return self.damping_time is not None or self.damping_ratio is not None
