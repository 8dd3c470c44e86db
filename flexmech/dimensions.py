"""The kinds of physical quantities that users give, and messages on units that are not theirs."""

from __future__ import annotations

import difflib
import reprlib
from dataclasses import dataclass

__all__ = [
    "ACCELERATION",
    "ACTIVATION_ENERGY",
    "ANGLE",
    "ANGULAR_SPEED",
    "BENDING_STIFFNESS",
    "CURVATURE",
    "DAMPING",
    "DENSITY",
    "DIFFUSIVITY",
    "EXPANSION",
    "FORCE",
    "FREQUENCY",
    "INERTIA",
    "LENGTH",
    "MASS",
    "MASS_PER_LENGTH",
    "MOISTURE_EXPANSION",
    "RATIO",
    "ROTARY_INERTIA",
    "SPRING_STIFFNESS",
    "STRESS",
    "TEMPERATURE",
    "TEMPERATURE_DIFFERENCE",
    "TIME",
    "TORQUE",
    "TORSIONAL_DAMPING",
    "TORSIONAL_STIFFNESS",
    "Dimension",
    "shown",
    "unknown_unit",
    "wrong_dimension",
]


@dataclass(frozen=True)
class Dimension:
    """A kind of physical quantity.

    Parameters
    ----------
    name : str
        With its article, for messages: ``"a length"``.
    unit : str
        SI unit of the float that :func:`parse_quantity` returns; empty for a ratio.
    examples : tuple of str
        Well-formed values, the first one for messages.
    """

    name: str
    unit: str
    examples: tuple[str, ...]

    @property
    def example(self) -> str:
        """A well-formed value in quotes, as in a model file."""
        return f'"{self.examples[0]}"'


LENGTH = Dimension("a length", "m", ("279.4 mm", "0.2794 m", "28 cm", "11 inch"))
MASS = Dimension("a mass", "kg", ("25 g", "0.025 kg", "1 lb"))
TIME = Dimension("a time", "s", ("2e-5 s", "20 µs", "0.02 ms"))
FREQUENCY = Dimension("a frequency", "Hz", ("50 Hz", "1.2 kHz"))
ANGLE = Dimension("an angle", "rad", ("45 deg", "0.785 rad"))
ANGULAR_SPEED = Dimension("an angular speed", "rad/s", ("20 rad/s", "300 rpm", "5 rps", "90 deg/s"))
ACCELERATION = Dimension("an acceleration", "m/s^2", ("-9.81 m/s^2", "0 m/s^2"))
STRESS = Dimension("a stress", "Pa", ("68.9 GPa", "200000 MPa", "2e11 Pa", "1e7 psi"))
DENSITY = Dimension("a density", "kg/m^3", ("7800 kg/m^3", "2.7 g/cm^3"))
FORCE = Dimension("a force", "N", ("4900 N", "1.2 MN", "100 lbf"))
CURVATURE = Dimension("a curvature", "1/m", ("0.2 1/m",))
BENDING_STIFFNESS = Dimension("a bending stiffness", "N m^2", ("1.5 N m^2", "2e6 N mm^2"))
MASS_PER_LENGTH = Dimension("a mass per length", "kg/m", ("0.2 kg/m", "200 g/m"))
ROTARY_INERTIA = Dimension("a rotary inertia per length", "kg m", ("3e-7 kg m", "0.3 g mm"))
TEMPERATURE = Dimension("a temperature", "K", ("80 degC", "353.15 K", "176 degF"))
"""On a scale with its own zero: "20 degC" is 293.15 K."""
TEMPERATURE_DIFFERENCE = Dimension("a temperature difference", "K", ("80 K", "80 degC"))
"""Between two temperatures: "20 degC" is 20 K."""
EXPANSION = Dimension("a thermal expansion", "1/K", ("58.4e-6 1/K", "11.7e-6 1/degC"))
MOISTURE_EXPANSION = Dimension("a moisture expansion", "", ("3.02e-3 1/percent", "0.302"))
DIFFUSIVITY = Dimension("a diffusivity", "m^2/s", ("1.2e-12 m^2/s", "1.2e-6 mm^2/s"))
ACTIVATION_ENERGY = Dimension("an activation energy", "J/mol", ("45 kJ/mol", "45000 J/mol"))
DAMPING = Dimension("a damping", "N s/m", ("2 N s/m", "0.002 N s/mm"))
INERTIA = Dimension("a moment of inertia", "kg m^2", ("2e-4 kg m^2", "200 kg mm^2"))
SPRING_STIFFNESS = Dimension("a spring stiffness", "N/m", ("500 N/m", "0.5 N/mm"))
TORQUE = Dimension("a torque", "N m", ("1.5 N m", "200 N mm"))
TORSIONAL_DAMPING = Dimension("a torsional damping", "N m s/rad", ("1e-3 N m s/rad",))
TORSIONAL_STIFFNESS = Dimension("a torsional stiffness", "N m/rad", ("2 N m/rad", "0.03 N m/deg"))
RATIO = Dimension("a ratio", "", ("0.01", "1 %"))

# What files and options hold may be longer than anybody reads.
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 100


def shown(text: object) -> str:
    """What was given, as a message shows it."""
    return _REPR.repr(text)


def unknown_unit(text: str, unit: str, dimension: Dimension) -> str:
    """Message on a unit that there is not.

    Parameters
    ----------
    text : str
        As it was given.
    unit : str
        In it.
    dimension : Dimension
        What it must be.

    Returns
    -------
    str
    """
    known = {example.split(maxsplit=1)[-1]: example for example in dimension.examples}
    by_lower_case = {name.lower(): name for name in known}
    close = difflib.get_close_matches(unit.lower(), by_lower_case, n=1)
    remedy = f"did you mean {by_lower_case[close[0]]!r}?" if close else "write"
    example = known[by_lower_case[close[0]]] if close else dimension.examples[0]
    joint = " For example" if close else f" {dimension.name}, for example"
    return (
        f"got {shown(text)}, in which the unit {shown(unit)} is unknown; "
        f'{remedy}{joint} "{example}"'
    )


def wrong_dimension(text: str, unit: str, base: str, dimension: Dimension) -> str:
    """Message on a unit of another dimension.

    Parameters
    ----------
    text : str
        As it was given.
    unit, base : str
        Unit in it, and the same in base units.
    dimension : Dimension
        What it must be.

    Returns
    -------
    str
    """
    if dimension is ANGULAR_SPEED and base == "1 / second":
        number = text[: text.rfind(unit)].strip() or "5"
        return (
            f"got {shown(text)}, which is a frequency and not an angular speed; write turns per "
            f'second as "{number} rps", turns per minute as "300 rpm", or an angle per time '
            'as "20 rad/s"'
        )
    if dimension is FREQUENCY and base == "radian / second":
        return (
            f"got {shown(text)}, which is an angular speed and not a frequency; write cycles per "
            f"second, for example {dimension.example}"
        )
    return (
        f"got {shown(text)}, whose unit {shown(unit)} ({base}) is not that of {dimension.name}; "
        f"write {dimension.name}, for example {dimension.example}"
    )
