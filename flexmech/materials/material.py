"""A homogeneous, isotropic, linearly elastic material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.materials.hygrothermal import Hygrothermal

__all__ = ["Material"]

UNKNOWN = Hygrothermal()


@dataclass(frozen=True)
class Material:
    """Isotropic material in SI units.

    Parameters
    ----------
    youngs_modulus : float
        E in Pa.
    density : float
        rho in kg/m^3.
    poisson_ratio : float
        nu, between -1 and 0.5.
    hygrothermal : Hygrothermal
        What heat and water do to it.

    Raises
    ------
    InputError
        If a value is not a number or outside its range.
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float = 0.3
    hygrothermal: Hygrothermal = UNKNOWN

    def __post_init__(self) -> None:
        for name in ("youngs_modulus", "density"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"{name} must be positive, got {value}")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise InputError(f"poisson_ratio must lie between -1 and 0.5, got {self.poisson_ratio}")

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) in Pa."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))
