"""How fast water moves in a material, and how much of it there is in the end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.validation import POSITIVE, check_fields

# In J/(mol K); exact since the mole and the kelvin are defined by numbers (SI, 2019).
GAS_CONSTANT = 8.31446261815324


@dataclass(frozen=True)
class Diffusivity:
    """Diffusivity of water by Arrhenius' law: ``D_0 exp(-Q/R (1/T - 1/T_0))``.

    Parameters
    ----------
    value : float
        At the reference temperature in m^2/s.
    reference_temperature : float
        In K.
    activation_energy : float
        Q in J/mol; 0 for a diffusivity that does not change.

    Raises
    ------
    InputError
        If the value or the temperature is not positive, or the energy negative.
    """

    value: si.DiffusivityValue
    reference_temperature: si.Temperature = 293.15
    activation_energy: si.ActivationEnergy = 0.0

    def __post_init__(self) -> None:
        si.check(self, "{} of a diffusivity")

    def at(self, temperature: ArrayLike) -> FloatArray:
        """Diffusivity in m^2/s at temperatures.

        Parameters
        ----------
        temperature : array_like, shape (...)
            In K.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InputError
            If a temperature is not above 0 K.
        """
        absolute = np.asarray(temperature, dtype=float)
        if not np.all(np.isfinite(absolute) & (absolute > 0)):
            raise InputError(f"temperature of a diffusivity must be above 0 K, got {absolute}")
        inverse = 1 / absolute - 1 / self.reference_temperature
        return np.asarray(self.value * np.exp(-self.activation_energy / GAS_CONSTANT * inverse))


@dataclass(frozen=True)
class MoistureEquilibrium:
    """Moisture that a resin takes up in the end: ``saturation * humidity ** exponent``.

    Shen & Springer, *J. Compos. Mater.* 10 (1976) 2-20, who write it of composites.

    Parameters
    ----------
    saturation : float
        At 100 % relative humidity, mass of water over the dry mass of the resin.
    humidity_exponent : float

    Raises
    ------
    InputError
        If a value is not positive, or the saturation 1 or more.
    """

    saturation: float
    humidity_exponent: float = 1.0

    def __post_init__(self) -> None:
        if not 0 < self.saturation < 1:
            raise InputError(
                f"equilibrium_moisture must lie between 0 and 100 %, got "
                f"{100 * self.saturation:g} %"
            )
        check_fields(self, {"humidity_exponent": ""}, POSITIVE)

    def moisture(self, relative_humidity: ArrayLike) -> FloatArray:
        """Moisture in equilibrium with relative humidities.

        Parameters
        ----------
        relative_humidity : array_like, shape (...)
            From 0 to 1.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InputError
            If a humidity is not between 0 and 1.
        """
        humidity = np.asarray(relative_humidity, dtype=float)
        if not np.all((humidity >= 0) & (humidity <= 1)):
            raise InputError(f"relative_humidity must lie between 0 and 1 (100 %), got {humidity}")
        return np.asarray(self.saturation * humidity**self.humidity_exponent)


def composite_diffusivity_ratio(fibre_volume_fraction: float) -> tuple[float, float]:
    """Diffusivity of a ply along and across its fibres over that of its resin.

    Shen & Springer 1976, for fibres that take up no water: ``1 - V_f`` along them,
    ``1 - 2 sqrt(V_f / pi)`` across them.

    Parameters
    ----------
    fibre_volume_fraction : float

    Returns
    -------
    tuple of float

    Raises
    ------
    InputError
        If the fibres would touch (a fraction of pi/4 or more) or there are none.
    """
    if not 0 < fibre_volume_fraction < np.pi / 4:
        raise InputError(
            "the diffusivity of a ply needs a fibre_volume_fraction above 0 and below "
            f"{np.pi / 4:.4f}, where the fibres of its square array touch; got "
            f"{fibre_volume_fraction}"
        )
    across = 1 - 2 * float(np.sqrt(fibre_volume_fraction / np.pi))
    return 1 - fibre_volume_fraction, across
