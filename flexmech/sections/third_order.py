"""What a section is to Reddy's third-order beam theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ThirdOrder"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ThirdOrder:
    """Integrals over a section whose points move along by a cubic of their place y.

    With the section's rotation phi and the slope s of the axis, points move along by
    ``u0 - y phi - c y^3 (s - phi)`` with ``c = 4 / (3 h^2)``, so that the shear strain
    ``(1 - 4 y^2 / h^2) (s - phi)`` vanishes at the surfaces (Reddy 1984; Elamy et al. 2023,
    eqs. 18-22, corrected: the cubic term is negative).

    Parameters
    ----------
    thickness : float
        h in m, in the plane of the linkage.
    stiffness : ndarray, shape (3, 3)
        By the strains of ``e0 + y k1 + y^3 k3``: integrals of E times powers of y.
    shear_stiffness : ndarray, shape (3,)
        Integrals of G times 1, y^2 and y^4.
    inertia : ndarray, shape (7,)
        Integrals of rho times y to the power 0 to 6.
    """

    thickness: float
    stiffness: FloatArray
    shear_stiffness: FloatArray
    inertia: FloatArray

    @property
    def cubic_factor(self) -> float:
        """Factor c of the cube in 1/m^2."""
        return 4 / (3 * self.thickness**2)

    @property
    def shear_force_stiffness(self) -> float:
        """Stiffness against the shear angle of the axis in N."""
        c = self.cubic_factor
        return float(self.shear_stiffness @ np.array([1.0, -6 * c, 9 * c**2]))
