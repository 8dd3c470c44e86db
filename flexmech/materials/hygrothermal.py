"""How heat and water swell and soften a resin.

Moisture is the mass of the water over the dry mass of the resin: 0.07 is seven percent.
Swelling is linear in temperature and moisture (Singh & Sanyal 2022, eqs. 6 and 9); moduli and
strength fall with the root of the distance from the wet glass transition (Chamis).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech import si, units
from flexmech.arrays import ROUND_OFF
from flexmech.errors import InputError
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from flexmech.model_text import TomlTable, short_repr, stated

REFERENCE_TEMPERATURE = 293.15
"""Temperature in K at which dimensions and moduli are stated unless a model says otherwise."""

# Chamis' parabola of the wet glass transition turns upward from here on: no data lie beyond.
GREATEST_MOISTURE = 0.10


class UnknownStiffnessError(InputError):
    """A resin in a state whose stiffness does not follow from that at the reference."""


@dataclass(frozen=True)
class Hygrothermal:
    """Hygrothermal properties of a resin; zero or None where they are unknown.

    Parameters
    ----------
    thermal_expansion : float
        Strain per temperature in 1/K, dry.
    wet_thermal_expansion : float, optional
        Strain per temperature in 1/K at ``equilibrium_moisture``; the dry one if left out. Between
        the two it is linear in the moisture.
    moisture_expansion : float
        Strain per unit of moisture, as '3.02e-3 1/percent' in a model file.
    equilibrium : MoistureEquilibrium, optional
        Moisture that the resin takes up in the end. Without it the resin takes what it is
        given.
    diffusivity : Diffusivity, optional
        Diffusivity of water in the resin.
    glass_transition : float, optional
        Glass transition of the dry resin in K; without it heat and water do not soften it.

    Raises
    ------
    InputError
        If a value is not a number or outside its range, or a wet expansion has no moisture
        that it belongs to.
    """

    thermal_expansion: si.Expansion = 0.0
    wet_thermal_expansion: si.Expansion | None = None
    moisture_expansion: si.MoistureExpansion = 0.0
    equilibrium: MoistureEquilibrium | None = None
    diffusivity: Diffusivity | None = None
    glass_transition: si.Temperature | None = None

    def __post_init__(self) -> None:
        si.check(self)
        if self.wet_thermal_expansion is not None and self.equilibrium is None:
            raise InputError(
                "wet_thermal_expansion is that of the saturated resin; give its "
                "equilibrium_moisture too"
            )

    def __repr__(self) -> str:
        water, glass = self.equilibrium, self.glass_transition
        return short_repr(
            self,
            f"thermal expansion {self.thermal_expansion:.6g} 1/K",
            f"moisture expansion {self.moisture_expansion:.6g}",
            "" if water is None else f"takes up {100 * water.saturation:.4g} %",
            "" if glass is None else f"glass transition {glass:.6g} K",
        )

    def to_table(self) -> TomlTable:
        """Keys of a resin or a material in a model file; empty where nothing is known."""
        table = si.table(self)
        if self.equilibrium is not None:
            table |= stated(
                equilibrium_moisture=(self.equilibrium.saturation, units.RATIO),
                humidity_exponent=(self.equilibrium.humidity_exponent, units.RATIO),
            )
        if self.diffusivity is not None:
            table |= stated(
                diffusivity=(self.diffusivity.value, units.DIFFUSIVITY),
                diffusivity_temperature=(self.diffusivity.reference_temperature, units.TEMPERATURE),
                activation_energy=(self.diffusivity.activation_energy, units.ACTIVATION_ENERGY),
            )
        return table

    @property
    def is_known(self) -> bool:
        """Whether heat or water does anything to the resin here."""
        return self != Hygrothermal()

    @property
    def takes_water(self) -> bool:
        """Whether the resin takes up water."""
        return self.equilibrium is not None or self.moisture_expansion > 0

    def checked_moisture(self, moisture: float) -> float:
        """Moisture of this resin where the environment offers ``moisture``.

        Parameters
        ----------
        moisture : float

        Returns
        -------
        float
            Zero for a material that takes up no water.

        Raises
        ------
        InputError
            If it is negative or more than the resin takes up.
        """
        if not (np.isfinite(moisture) and moisture >= 0):
            raise InputError(f"moisture must be zero or positive, got {100 * moisture:g} %")
        if not self.takes_water:
            return 0.0
        most = np.inf if self.equilibrium is None else self.equilibrium.saturation
        if moisture > most * (1 + ROUND_OFF):
            raise UnknownStiffnessError(
                f"a moisture of {100 * moisture:g} % is more than the resin takes up: "
                f"{100 * most:g} % at 100 % relative humidity; give less, "
                "or another equilibrium_moisture"
            )
        return moisture

    def thermal_expansion_at(self, moisture: float) -> float:
        """Thermal expansion in 1/K of the moist resin: linear from dry to saturated."""
        if self.wet_thermal_expansion is None or self.equilibrium is None:
            return self.thermal_expansion
        share = moisture / self.equilibrium.saturation
        return self.thermal_expansion + share * (
            self.wet_thermal_expansion - self.thermal_expansion
        )

    def free_strain(self, temperature_rise: float, moisture: float) -> float:
        """Strain without stress: Singh & Sanyal 2022, eqs. 6 and 9.

        Parameters
        ----------
        temperature_rise : float
            Over the reference temperature in K.
        moisture : float

        Returns
        -------
        float
        """
        expansion = self.thermal_expansion_at(moisture)
        return expansion * temperature_rise + self.moisture_expansion * moisture

    def wet_glass_transition(self, moisture: float) -> float:
        """Glass transition of the moist resin in K.

        Chamis, NASA TM-83320 (1983): the dry one in degrees Fahrenheit times
        ``0.005 M^2 - 0.10 M + 1``, with M in percent, after data to ten percent.

        Parameters
        ----------
        moisture : float

        Returns
        -------
        float

        Raises
        ------
        InputError
            If no dry glass transition is known.
        UnknownStiffnessError
            If the moisture is beyond the rule's range.
        """
        if self.glass_transition is None:
            raise InputError(
                "the wet glass transition needs the dry one; give glass_transition of the resin"
            )
        if moisture > GREATEST_MOISTURE:
            raise UnknownStiffnessError(
                f"a moisture of {100 * moisture:g} % is beyond Chamis' rule of the wet glass "
                f"transition, which holds to {100 * GREATEST_MOISTURE:g} %; give less moisture, or "
                "leave glass_transition out to go without softening"
            )
        percent = 100 * moisture
        lowered = (0.005 * percent**2 - 0.10 * percent + 1.0) * _fahrenheit(self.glass_transition)
        return _kelvin(lowered)

    def retention(self, temperature: float, moisture: float, reference: float) -> float:
        """Part of its stiffness and strength that the resin keeps, by Chamis' rule.

        The root of ``(T_gw - T) / (T_gd - T_0)`` with the wet and dry glass transitions and
        the temperatures now and at the reference (Chamis, NASA TM-83320, 1983); one where no
        glass transition is known. Below the reference temperature it exceeds one.

        Parameters
        ----------
        temperature : float
            In K.
        moisture : float
        reference : float
            Temperature in K at which the dry moduli are stated.

        Returns
        -------
        float

        Raises
        ------
        InputError
            If the dry glass transition is not above the reference temperature.
        UnknownStiffnessError
            If the resin is at its wet glass transition or above it.
        """
        if self.glass_transition is None:
            return 1.0
        if self.glass_transition <= reference:
            raise InputError(
                f"the glass transition of {_celsius(self.glass_transition)} is not above the "
                f"reference temperature of {_celsius(reference)}; correct one of the two"
            )
        wet = self.wet_glass_transition(moisture) if moisture else self.glass_transition
        if temperature >= wet:
            raise UnknownStiffnessError(
                f"at {_celsius(temperature)} the resin is above its wet glass transition of "
                f"{_celsius(wet)} ({100 * moisture:.3g} % moisture, dry "
                f"{_celsius(self.glass_transition)}): rubber, for which the elastic moduli say "
                "nothing; lower the temperature or the moisture"
            )
        return float(np.sqrt((wet - temperature) / (self.glass_transition - reference)))


@dataclass(frozen=True)
class ResinContent:
    """The resin in a ply: what takes up water, swells and softens.

    Parameters
    ----------
    hygrothermal : Hygrothermal
    mass_fraction : float
        Mass fraction of the dry ply; 1 of a neat resin.
    volume_fraction : float
        Volume fraction of the ply.

    Raises
    ------
    InputError
        If a fraction is not above 0, or above 1.
    """

    hygrothermal: Hygrothermal
    mass_fraction: si.Fraction = 1.0
    volume_fraction: si.Fraction = 1.0

    def __post_init__(self) -> None:
        si.check(self, "{} of the resin")

    def __repr__(self) -> str:
        return short_repr(
            self,
            f"{100 * self.mass_fraction:.4g} % of the mass",
            f"{100 * self.volume_fraction:.4g} % of the volume",
        )

    def to_table(self) -> TomlTable:
        """Table ``resin`` of a ply in a model file."""
        return {**self.hygrothermal.to_table(), **si.table(self)}


def _fahrenheit(temperature: float) -> float:
    return (temperature - units.ZERO_CELSIUS) * 9 / 5 + 32


def _kelvin(fahrenheit: float) -> float:
    return (fahrenheit - 32) * 5 / 9 + units.ZERO_CELSIUS


def _celsius(temperature: float) -> str:
    return f"{temperature - units.ZERO_CELSIUS:.5g} degC"
