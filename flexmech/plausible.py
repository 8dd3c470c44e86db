"""Between what sizes a quantity of a mechanism can lie, and what was probably meant by others.

A slip of a unit is a factor of a thousand or more. The ranges are wide enough for machines from
micrometres to hundreds of metres, and for links that are meant to be rigid.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from flexmech import units
from flexmech.errors import InputError
from flexmech.units import NUMBER, Dimension, parse_quantity


@dataclass(frozen=True)
class Plausible:
    """Sizes that a quantity can have; zero is left to other checks.

    Parameters
    ----------
    dimension : Dimension
    most : str
        Greatest size, with its unit.
    least : str
        Least size; empty where a quantity may be as small as it likes.
    what : str
        What messages call it; the dimension's name if empty.
    """

    dimension: Dimension
    most: str
    least: str = ""
    what: str = ""

    def holds(self, value: float) -> bool:
        """Whether a value in SI units has such a size."""
        size = abs(value)
        if self.least and size < parse_quantity(self.least, self.dimension):
            return size == 0
        return size <= parse_quantity(self.most, self.dimension)

    @property
    def words(self) -> str:
        """Sentence on the sizes between which the quantity lies."""
        what = self.what or self.dimension.name
        if self.least:
            return f"{what} here lies between {self.least} and {self.most}"
        return f"{what} here is at most {self.most}"


THICKNESS = Plausible(units.LENGTH, "1 m", "1 nm", "a thickness")
WIDTH = Plausible(units.LENGTH, "10 m", "1 nm", "a width")
LINK_LENGTH = Plausible(units.LENGTH, "1 km", "0.1 µm")
LOAD = Plausible(units.FORCE, "1e12 N")
TURN = Plausible(units.ANGLE, "360 deg")
LIFE = Plausible(units.RATIO, "1e15", "1", "a number of cycles")
RUN_UP = Plausible(units.TIME, "1e6 s", "1 µs", "a run-up")

_OF_DIMENSION = {
    plausible.dimension: plausible
    for plausible in (
        Plausible(units.LENGTH, "1 km"),
        Plausible(units.MASS, "1e6 kg"),
        Plausible(units.TIME, "1e12 s"),
        Plausible(units.FREQUENCY, "1e12 Hz", "1e-9 Hz"),
        Plausible(units.ANGLE, "1e6 rad"),
        Plausible(units.ANGULAR_SPEED, "1e6 rad/s"),
        Plausible(units.ANGULAR_ACCELERATION, "1e9 rad/s^2"),
        Plausible(units.ACCELERATION, "1e6 m/s^2"),
        Plausible(units.STRESS, "1e6 GPa", "1 kPa"),
        Plausible(units.DENSITY, "1e6 kg/m^3", "1e-3 kg/m^3"),
        Plausible(units.FORCE, "1e30 N", "1e-30 N"),
        Plausible(units.CURVATURE, "1e6 1/m"),
        Plausible(units.BENDING_STIFFNESS, "1e30 N m^2", "1e-30 N m^2"),
        Plausible(units.MASS_PER_LENGTH, "1e30 kg/m", "1e-30 kg/m"),
        Plausible(units.ROTARY_INERTIA, "1e30 kg m", "1e-40 kg m"),
        Plausible(units.INERTIA, "1e12 kg m^2"),
        Plausible(units.SPRING_STIFFNESS, "1e15 N/m"),
        Plausible(units.DAMPING, "1e15 N s/m"),
        Plausible(units.TORQUE, "1e12 N m"),
        Plausible(units.TORSIONAL_STIFFNESS, "1e15 N m/rad"),
        Plausible(units.TORSIONAL_DAMPING, "1e15 N m s/rad"),
        Plausible(units.TEMPERATURE, "1e4 K"),
        Plausible(units.TEMPERATURE_DIFFERENCE, "1e4 K"),
        Plausible(units.EXPANSION, "1 1/K"),
        Plausible(units.MOISTURE_EXPANSION, "1000"),
        Plausible(units.DIFFUSIVITY, "1 m^2/s", "1e-30 m^2/s"),
        Plausible(units.ACTIVATION_ENERGY, "1e7 J/mol"),
        Plausible(units.PRESSURE_VELOCITY, "1e6 MPa m/s", "1 Pa m/s"),
        Plausible(units.VOLTAGE, "1e6 V"),
        Plausible(units.RESISTANCE, "1e9 ohm", "1e-9 ohm"),
        Plausible(units.INDUCTANCE, "1e6 H"),
        Plausible(units.CURRENT, "1e6 A"),
        Plausible(units.TORQUE_CONSTANT, "1e6 N m/A", "1e-12 N m/A"),
        Plausible(units.VOLTAGE_GAIN, "1e12 V s/rad"),
        Plausible(units.VOLTAGE_INTEGRAL_GAIN, "1e12 V/rad"),
        Plausible(units.RATIO, "1e6"),
    )
}


def of_dimension(dimension: Dimension) -> Plausible | None:
    """Sizes of any quantity of a dimension; None where nothing is known of it."""
    return _OF_DIMENSION.get(dimension)


def check_plausible(value: float, text: object, plausible: Plausible) -> None:
    """Refuse a quantity of a size that none can have.

    Parameters
    ----------
    value : float
        In SI units.
    text : object
        As it was written.
    plausible : Plausible

    Raises
    ------
    InputError
        Says what was probably meant, if another unit of the dimension makes sense.
    """
    if plausible.holds(value):
        return
    meant = _meant(str(text), plausible)
    remedy = f"did you mean {meant!r}?" if meant else "check the number and its unit"
    raise InputError(f"got {text!r}, but {plausible.words}; {remedy}")


def _meant(text: str, plausible: Plausible) -> str:
    """The same number with the first unit of the dimension that makes sense; empty if none."""
    number = re.match(rf"\s*({NUMBER})", text)
    for example in plausible.dimension.examples if number else ():
        unit = example.partition(" ")[2]
        guess = f"{number[1]} {unit}" if number else ""
        try:
            if unit and plausible.holds(parse_quantity(guess, plausible.dimension)):
                return guess
        except InputError:
            continue  # with this unit it is too large for any number
    return ""
