"""Fields of records in SI units: dimension, bounds and plausible sizes stand at the annotation.

``mass: si.Mass`` is a float to type checkers. What stands behind the name checks the field of a
record that is made in Python, writes it into a model file, and reads it from one::

    @dataclass(frozen=True)
    class PointMass:
        position: si.LengthOrZero
        mass: si.Mass

        def __post_init__(self) -> None:
            si.check(self, "point mass: {}")

        def to_table(self) -> TomlTable:
            return si.table(self)
"""

from __future__ import annotations

import math
import types
from collections.abc import Collection, Iterator
from dataclasses import dataclass, fields
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    NamedTuple,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from flexmech import units
from flexmech.errors import InputError
from flexmech.model_text import TomlTable, quantity
from flexmech.plausible import (
    LIFE,
    LINK_LENGTH,
    LOAD,
    RUN_UP,
    THICKNESS,
    TURN,
    WIDTH,
    Plausible,
    check_plausible,
    of_dimension,
)
from flexmech.units import Dimension, parse_quantity, split_quantity
from flexmech.validation import (
    FINITE,
    NOT_NEGATIVE,
    POSITIVE,
    Bounds,
    check_number,
    check_pair,
)

if TYPE_CHECKING:
    from pydantic_core import CoreSchema


@dataclass(frozen=True)
class QuantityField:
    """Marks a float field as a quantity in SI units, which has a unit in a file.

    Parameters
    ----------
    dimension : Dimension
    bounds : Bounds
        In SI units.
    plausible : Plausible, optional
        What sizes it can have in a file; those of its dimension if left out.
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

    def check(self, value: object, name: str) -> None:
        """Refuse what is no number in SI units, or out of bounds; ``name`` is for the message."""
        if not (self.infinite and isinstance(value, float) and value == math.inf):
            check_number(value, name, self.dimension.unit, self.bounds)

    def text(self, value: float) -> str | float:
        """The quantity as a file has it; it reads back to the last bit."""
        return self.infinite if math.isinf(value) else quantity(value, self.dimension)

    def stated_as(self, value: float) -> str | float:
        """The quantity as a person would write it, in its SI unit."""
        unit = self.dimension.unit
        return f"{value:g} {unit}" if unit and math.isfinite(value) else self.text(value)

    # Called by pydantic, which what is made in Python does without.
    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(self.parse)

    def __get_pydantic_json_schema__(self, schema: object, handler: object) -> dict[str, Any]:
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

    def __get_pydantic_core_schema__(self, source: object, handler: object) -> CoreSchema:
        from pydantic_core import core_schema

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
BodyMass = Annotated[float, QuantityField(units.MASS, POSITIVE)]
BodyInertia = Annotated[float, QuantityField(units.INERTIA, POSITIVE)]
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
RunTime = Annotated[float, QuantityField(units.TIME, POSITIVE, RUN_UP)]
Speed = Annotated[float, QuantityField(units.ANGULAR_SPEED)]
SpeedOneWay = Annotated[float, QuantityField(units.ANGULAR_SPEED, POSITIVE)]
AngleOneWay = Annotated[float, QuantityField(units.ANGLE, POSITIVE)]
Resistance = Annotated[float, QuantityField(units.RESISTANCE, POSITIVE)]
Inductance = Annotated[float, QuantityField(units.INDUCTANCE, NOT_NEGATIVE)]
Current = Annotated[float, QuantityField(units.CURRENT)]
TorqueConstant = Annotated[float, QuantityField(units.TORQUE_CONSTANT, POSITIVE)]
Voltage = Annotated[float, QuantityField(units.VOLTAGE)]
CouplingStiffness = Annotated[float, QuantityField(units.TORSIONAL_STIFFNESS, POSITIVE)]
Inclination = Annotated[float, QuantityField(units.RATIO, Bounds(above=0.0, below=1.0))]
Fraction = Annotated[float, QuantityField(units.RATIO, Bounds(above=0.0, most=1.0))]
PositivePoissonRatio = Annotated[float, QuantityField(units.RATIO, Bounds(least=0.0, below=0.5))]
ActivationEnergy = Annotated[float, QuantityField(units.ACTIVATION_ENERGY, NOT_NEGATIVE)]


def options(annotation: Any) -> Iterator[Any]:
    """An annotation, and those that are alternatives in it."""
    yield annotation
    if get_origin(annotation) in (Annotated, Union, types.UnionType):
        inner = get_args(annotation)
        for option in inner[:1] if get_origin(annotation) is Annotated else inner:
            yield from options(option)


def mark_of(annotation: Any) -> QuantityField | None:
    """Mark of an annotation, or of an alternative in it; None where it is no quantity."""
    for option in options(annotation):
        for mark in getattr(option, "__metadata__", ()):
            if isinstance(mark, QuantityField):
                return mark
    return None


class StatedField(NamedTuple):
    """A field of a record that holds one quantity, or a pair of them.

    Parameters
    ----------
    mark : QuantityField
    default : object
        ``dataclasses.MISSING`` of a field that has none.
    pair : bool
    optional : bool
        Whether it may be None.
    """

    mark: QuantityField
    default: Any
    pair: bool
    optional: bool

    def parts(self, value: Any) -> tuple[Any, ...]:
        """Quantities in a value of the field."""
        return tuple(value) if self.pair else (value,)

    @property
    def stated_default(self) -> Any:
        """Default as a person would write it in a file."""
        texts = [self.mark.stated_as(part) for part in self.parts(self.default)]
        return texts if self.pair else texts[0]


_HINTS: dict[type, dict[str, Any]] = {}
_STATED: dict[type, dict[str, StatedField]] = {}


def hints(kind: type) -> dict[str, Any]:
    """Annotations of a dataclass's fields with their marks, by their names."""
    if kind not in _HINTS:
        _HINTS[kind] = get_type_hints(kind, include_extras=True)
    return _HINTS[kind]


def quantities(kind: type) -> dict[str, StatedField]:
    """Fields of a dataclass that hold quantities, by their names."""
    if kind not in _STATED:
        given = {field.name: field.default for field in fields(kind)}
        stated = {name: _stated(hints(kind)[name], default) for name, default in given.items()}
        _STATED[kind] = {name: field for name, field in stated.items() if field is not None}
    return _STATED[kind]


def _stated(annotation: Any, default: Any) -> StatedField | None:
    alternatives = list(options(annotation))
    pair = next((get_args(one)[0] for one in alternatives if get_origin(one) is tuple), None)
    mark = mark_of(annotation if pair is None else pair)
    if mark is None:
        return None
    return StatedField(mark, default, pair is not None, type(None) in alternatives)


def check(record: Any, name: str = "{}") -> None:
    """Refuse quantities of a record that are no numbers or out of their bounds.

    Parameters
    ----------
    record : dataclass instance
    name : str
        What messages call a field, with braces in the place of its name, as ``"{} of a ply"``.

    Raises
    ------
    InputError
    """
    for key, field in quantities(type(record)).items():
        value = getattr(record, key)
        if field.optional and value is None:
            continue
        called = name.format(key)
        if field.pair:
            check_pair(value, called, field.mark.dimension.unit)
        for part in field.parts(value):
            field.mark.check(part, called)


def table(record: Any, *, without: Collection[str] = ()) -> TomlTable:
    """Table of a record's quantities by their names, without those that are as if left out.

    Parameters
    ----------
    record : dataclass instance
    without : collection of str
        Fields that are not written.

    Returns
    -------
    dict
    """
    written: TomlTable = {}
    for key, field in quantities(type(record)).items():
        value = getattr(record, key)
        if key not in without and value != field.default:
            texts = [field.mark.text(part) for part in field.parts(value)]
            written[key] = texts if field.pair else texts[0]
    return written
