"""What a section is to Reddy's third-order beam theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.materials import Laminate
from flexmech.sections.beam_reduction import Reduction, Strained, Strip, shear_across
from flexmech.sections.plane_state import gauss_points
from flexmech.short_repr import shapes, short_repr
from flexmech.types import FloatArray, IntArray


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

    def __repr__(self) -> str:
        return short_repr(self, f"{self.thickness * 1e3:.6g} mm thick", *shapes(self))

    @property
    def cubic_factor(self) -> float:
        """Factor c of the cube in 1/m^2."""
        return 4 / (3 * self.thickness**2)

    @property
    def shear_force_stiffness(self) -> float:
        """Stiffness against the shear angle of the axis in N."""
        c = self.cubic_factor
        return float(self.shear_stiffness @ np.array([1.0, -6 * c, 9 * c**2]))


def third_order_of(strip: Strip, width: float) -> ThirdOrder:
    """Integrals of a laminate, reduced as for the classical theory.

    Stretching and bending are those of that theory: slender links of all theories are alike.
    In a narrow link the shear strain across it is a parabola too, of the height at which
    its higher-order shear force (Elamy et al. 2023, eq. 29) vanishes.

    Parameters
    ----------
    strip : Strip
    width : float
        Along the joint axes, in m.

    Returns
    -------
    ThirdOrder
    """
    laminate, reduction = strip.laminate, strip.reduction
    tilt = _tilt(laminate, reduction)
    moments = [laminate.shear_moment(power) for power in (0, 2, 4)]
    shear = [m[1, 1] + 2 * tilt * m[0, 1] + tilt**2 * m[0, 0] for m in moments]
    return ThirdOrder(
        thickness=laminate.thickness,
        stiffness=width * _stiffness(strip),
        shear_stiffness=width * np.array(shear),
        inertia=width * np.array([laminate.mass_moment(power) for power in range(7)]),
    )


def _stiffness(strip: Strip) -> FloatArray:
    """By the strains of e0 + y k1 + y^3 k3, (3, 3), of each metre of width."""
    places, weights = gauss_points(strip.laminate, 4)
    strain = np.zeros((*places.shape, 3))
    strain[..., 0] = places**3
    return strip.warping_parts(Strained(places, weights, strain)).matrix


def parabolic_shear(
    laminate: Laminate, reduction: Reduction, place: FloatArray, layer: IntArray
) -> FloatArray:
    """Shear stress of a unit shear force on each metre of width, from the shear strain.

    It vanishes at the surfaces and jumps at interfaces of layers with different stiffness.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    place : ndarray, shape (...)
        In m.
    layer : ndarray of int
        Layers of the places.

    Returns
    -------
    ndarray, shape (...)
        In 1/m: times the shear force over the width it is Pa.
    """
    square = 4 / laminate.thickness**2
    row = np.array([_tilt(laminate, reduction), 1.0])
    resultant = (laminate.shear_moment(0) - square * laminate.shear_moment(2))[1] @ row
    along = laminate.transformed_shear_stiffness[:, 1] @ row
    return np.asarray(along[layer] * (1 - square * place**2) / resultant)


def _tilt(laminate: Laminate, reduction: Reduction) -> float:
    """Shear strain across the link over that along it, both parabolas with y."""
    square = 4 / laminate.thickness**2
    factors = ((0, 1.0), (2, -2 * square), (4, square**2))
    stiffness = sum(factor * laminate.shear_moment(power) for power, factor in factors)
    return shear_across(np.asarray(stiffness), reduction)
