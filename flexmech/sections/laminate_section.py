"""A rectangular section of a laminate whose plies are stacked in the linkage's plane.

Bending in the plane of the linkage bends the laminate through its thickness. The section
keeps the axial-bending coupling of an unsymmetric stack: it has a neutral axis off the
mid-plane, where the pins sit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.materials import Laminate
from flexmech.sections.damping import SpecificDamping
from flexmech.sections.third_order import ThirdOrder

__all__ = ["REDUCTIONS", "LaminateSection", "Reduction", "ThroughThickness"]

FloatArray = NDArray[np.float64]
Reduction = Literal["narrow", "wide"]
REDUCTIONS: tuple[Reduction, ...] = ("narrow", "wide")

# Exact for the squares of stresses that are quadratic in a layer.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class ThroughThickness:
    """Strain and stress at places through the thickness, all of one shape.

    Parameters
    ----------
    place : ndarray
        Distance y from the mid-plane in m.
    strain : ndarray
        Along the link.
    normal_stress, shear_stress : ndarray
        Along the link, and on its cross-section in the plane of the linkage, in Pa.
    """

    place: FloatArray
    strain: FloatArray
    normal_stress: FloatArray
    shear_stress: FloatArray


@dataclass(frozen=True)
class LaminateSection:
    """Laminate of a width along the joint axes.

    Parameters
    ----------
    laminate : Laminate
    width : float
        Along the joint axes, in m.
    reduction : {"narrow", "wide"}
        ``narrow``: no stress resultant across the link nor in-plane shear (plane stress);
        ``wide``: no strain across nor in-plane shear (plane strain, cylindrical bending).

    Raises
    ------
    InputError
        If the width is not positive or the reduction unknown.
    """

    laminate: Laminate
    width: float
    reduction: Reduction = "narrow"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.width) and self.width > 0):
            raise InputError(f"width of a laminate section must be positive, got {self.width} m")
        if self.reduction not in REDUCTIONS:
            raise InputError(
                f"reduction must be one of {', '.join(REDUCTIONS)}, got {self.reduction!r}"
            )

    @cached_property
    def axial_stiffness(self) -> float:
        """EA in N."""
        return float(self._classical[0, 0])

    @cached_property
    def coupling_stiffness(self) -> float:
        """B, the integral of E y, in N m: N = EA e - B kappa about the mid-plane."""
        return float(self._classical[0, 1])

    @cached_property
    def neutral_axis(self) -> float:
        """Distance of the neutral axis from the mid-plane in m; exactly 0 in a symmetric stack."""
        scale = np.sqrt(self._classical[0, 0] * self._classical[1, 1])
        if abs(self.coupling_stiffness) < 1e-12 * scale:
            return 0.0
        return self.coupling_stiffness / self.axial_stiffness

    @cached_property
    def bending_stiffness(self) -> float:
        """EI about the neutral axis in N m^2."""
        return float(self._classical[1, 1] - self._classical[0, 1] ** 2 / self._classical[0, 0])

    @cached_property
    def shear_stiffness(self) -> float:
        """Shear stiffness kGA in N, from the shear energy of the stack.

        The shear stress that balances the bending stress of a unit shear force has the
        complementary energy ``1 / (2 kGA)`` (Whitney 1973 for plates; for one homogeneous
        layer k = 5/6).
        """
        places, weights = self._gauss
        stress = self._equilibrium_shear(self._pure_bending, places)
        flexibility = 1 / self._shear_modulus[:, None]
        return float(1 / np.sum(self.width * weights * flexibility * stress**2))

    @cached_property
    def shear_correction(self) -> float:
        """Factor k: kGA over the integral of G."""
        heights = np.diff(self.laminate.boundaries)
        return float(self.shear_stiffness / (self.width * self._shear_modulus @ heights))

    @cached_property
    def mass_per_length(self) -> float:
        """Mass rho A in kg/m."""
        return self.width * self.laminate.mass_moment(0)

    @cached_property
    def mass_axis(self) -> float:
        """Distance of the centre of mass from the mid-plane in m; exactly 0 if symmetric."""
        moment = self.laminate.mass_moment(1) / self.laminate.mass_moment(0)
        return moment if abs(moment) > 1e-12 * self.laminate.thickness else 0.0

    @cached_property
    def rotary_inertia(self) -> float:
        """Mass moment rho I about the centre of mass in kg m."""
        return self.width * self.laminate.mass_moment(2) - self.mass_per_length * self.mass_axis**2

    @cached_property
    def third_order(self) -> ThirdOrder:
        """Integrals for Reddy's theory, reduced like the classical ones."""
        orders = np.array([[0, 1, 3], [1, 2, 4], [3, 4, 6]])
        moments = self._reduced(
            [[self.laminate.stiffness_moment(k) for k in row] for row in orders]
        )
        thickness = self.laminate.thickness
        shear = np.stack([self.laminate.shear_moment(k) for k in (0, 2, 4)])
        along = shear[:, 1, 1]
        if self.reduction == "narrow":
            # No shear force across the link: the parabola's energy is least without it.
            parabola = np.array([1.0, -8 / thickness**2, 16 / thickness**4])
            across, both = parabola @ shear[:, 0, 0], parabola @ shear[:, 0, 1]
            ratio = -both / across
            along = along + 2 * ratio * shear[:, 0, 1] + ratio**2 * shear[:, 0, 0]
        inertia = np.array([self.laminate.mass_moment(k) for k in range(7)])
        return ThirdOrder(
            thickness=thickness,
            stiffness=self.width * moments,
            shear_stiffness=self.width * along,
            inertia=self.width * inertia,
        )

    @cached_property
    def specific_damping(self) -> SpecificDamping:
        """Specific damping capacity of stretching, bending and shear.

        Strain energies by ply and direction in the material's axes, each with its own
        capacity (Adams & Bacon 1973; Ni & Adams 1984).
        """
        stretched = np.array([1 / self.axial_stiffness, 0.0])
        stretched = self._at_midplane(stretched)
        return SpecificDamping(
            axial=self._loss_of(stretched),
            bending=self._loss_of(self._pure_bending),
            shear=self._shear_loss,
        )

    def places(self, per_layer: int) -> FloatArray:
        """Places through each layer, faces included, (N, per_layer), in m."""
        faces = self.laminate.boundaries
        return np.linspace(faces[:-1], faces[1:], per_layer, axis=1)

    def stresses(
        self,
        place: FloatArray,
        axial_force: float = 0.0,
        bending_moment: float = 0.0,
        shear_force: float = 0.0,
        *,
        coupled: bool = True,
    ) -> ThroughThickness:
        """Strain and stress through the thickness under loads on the neutral axis.

        Normal stress by classical theory; shear stress from the equilibrium of the normal
        stress along the link.

        Parameters
        ----------
        place : ndarray, shape (N, m)
            Places in each layer in m: at an interface each layer has its own stress.
        axial_force : float
            In N, on the neutral axis (on the mid-plane if not ``coupled``).
        bending_moment : float
            In N m; positive stretches the side of lower y.
        shear_force : float
            In N.
        coupled : bool
            Off: the axial-bending coupling is left out, as if the stack were symmetric; the
            stresses then do not balance the loads.

        Returns
        -------
        ThroughThickness
        """
        loads = np.array([axial_force, bending_moment])
        unit_moment = np.array([0.0, 1.0])
        if coupled:
            strains = self._at_midplane(
                loads / np.array([self.axial_stiffness, self.bending_stiffness])
            )
            bending = self._pure_bending
        else:
            classical = np.diag(self._classical)
            strains, bending = loads / classical, unit_moment / classical
        return ThroughThickness(
            place=place,
            strain=strains[0] - place * strains[1],
            normal_stress=self._normal_stress(strains, place),
            shear_stress=shear_force * self._equilibrium_shear(bending, place),
        )

    @cached_property
    def _classical(self) -> FloatArray:
        """Stiffness by mid-plane strain and curvature, (2, 2), with a minus off the diagonal."""
        orders = np.array([[0, 1], [1, 2]])
        moments = [[self.laminate.stiffness_moment(k) for k in row] for row in orders]
        return self.width * self._reduced(moments)

    @property
    def _pure_bending(self) -> FloatArray:
        """Mid-plane strain and curvature of a unit moment without axial force, (2,)."""
        return self._at_midplane(np.array([0.0, 1 / self.bending_stiffness]))

    def _at_midplane(self, neutral: FloatArray) -> FloatArray:
        """Mid-plane strain and curvature from the strain at the neutral axis and curvature."""
        return np.array([neutral[0] + self.neutral_axis * neutral[1], neutral[1]])

    def _reduced(self, blocks: list[list[FloatArray]]) -> FloatArray:
        """Stiffness by the strains along the link from blocks of laminate matrices."""
        matrix = np.block(blocks)
        along = np.arange(0, len(matrix), 3)
        reduced = matrix[np.ix_(along, along)]
        if self.reduction == "narrow":
            others = np.setdiff1d(np.arange(len(matrix)), along)
            reduced = reduced - matrix[np.ix_(along, others)] @ np.linalg.solve(
                matrix[np.ix_(others, others)], matrix[np.ix_(others, along)]
            )
        return np.asarray(reduced)

    def _laminate_strains(self, strains: FloatArray) -> FloatArray:
        """In-plane strains and their gradients in y, (2, 3), of strain and curvature along."""
        along, gradient = strains[0], -strains[1]
        if self.reduction == "wide":
            return np.array([[along, 0.0, 0.0], [gradient, 0.0, 0.0]])
        moments = [[self.laminate.stiffness_moment(j + k) for j in (0, 1)] for k in (0, 1)]
        matrix = np.block(moments)
        others, given = np.array([1, 2, 4, 5]), np.array([0, 3])
        every = np.zeros(6)
        every[given] = along, gradient
        every[others] = -np.linalg.solve(
            matrix[np.ix_(others, others)], matrix[np.ix_(others, given)] @ every[given]
        )
        return every.reshape(2, 3)

    def _in_plane_strains(self, strains: FloatArray, place: FloatArray) -> FloatArray:
        """In-plane strains in laminate axes at places (N, m), (N, m, 3)."""
        constant, gradient = self._laminate_strains(strains)
        return np.asarray(constant + place[..., None] * gradient)

    def _normal_stress(self, strains: FloatArray, place: FloatArray) -> FloatArray:
        """Stress along the link at places (N, m) of each layer, in Pa."""
        first_rows = self.laminate.transformed_stiffness[:, 0]
        return np.asarray(
            np.einsum("nj,nmj->nm", first_rows, self._in_plane_strains(strains, place))
        )

    def _equilibrium_shear(self, bending: FloatArray, place: FloatArray) -> FloatArray:
        """Shear stress of a unit shear force at places (N, m), in Pa.

        ``bending`` is the state of a unit moment, whose stress grows along the link by the
        shear force; the stress on the cross-section balances what it pulls below y.
        """
        faces = self.laminate.boundaries
        lower = faces[:-1, None]
        start = self._normal_stress(bending, lower)
        slope = (self._normal_stress(bending, faces[1:, None]) - start) / np.diff(faces)[:, None]

        def pull(at: FloatArray) -> FloatArray:
            depth = at - lower
            return np.asarray(start * depth + slope * depth**2 / 2)

        whole = pull(faces[1:, None])[:, 0]
        below = np.concatenate([[0.0], np.cumsum(whole)[:-1]])
        return np.asarray(below[:, None] + pull(place))

    @cached_property
    def _shear_modulus(self) -> FloatArray:
        """Shear modulus of each layer along the link, (N,), in Pa."""
        stiffness = self.laminate.transformed_shear_stiffness
        along = stiffness[:, 1, 1]
        if self.reduction == "narrow":
            # No shear stress across the link either.
            return np.asarray(along - stiffness[:, 0, 1] ** 2 / stiffness[:, 0, 0])
        return np.asarray(along)

    @cached_property
    def _gauss(self) -> tuple[FloatArray, FloatArray]:
        """Gauss points of the layers and their weights, (N, 3), in m."""
        faces = self.laminate.boundaries
        half = np.diff(faces)[:, None] / 2
        middle = (faces[:-1] + faces[1:])[:, None] / 2
        return middle + half * _POINTS, half * _WEIGHTS

    def _loss_of(self, strains: FloatArray) -> float:
        """Specific damping capacity of a state of strain and curvature along the link."""
        places, weights = self._gauss
        in_plane = self._in_plane_strains(strains, places)
        turns = np.stack([layer.strain_turn for layer in self.laminate.layers])
        own = np.einsum("nij,nmj->nmi", turns, in_plane)
        stiffness = np.stack([layer.ply.reduced_stiffness for layer in self.laminate.layers])
        energy = np.einsum("nmi,nij,nmj,nm->ni", own, stiffness, own, weights)
        return float(np.sum(self._capacities * energy) / energy.sum())

    @cached_property
    def _shear_loss(self) -> float:
        """Specific damping capacity of shear through the thickness."""
        places, weights = self._gauss
        stress = self._equilibrium_shear(self._pure_bending, places)
        energy = np.sum(weights * stress**2, axis=1) / self._shear_modulus
        return float(self._capacities[:, 2] @ energy / energy.sum())

    @cached_property
    def _capacities(self) -> FloatArray:
        """Specific damping capacity of each layer along, across and in shear, (N, 3)."""
        own = [layer.ply.specific_damping for layer in self.laminate.layers]
        return np.array([[d.longitudinal, d.transverse, d.shear] for d in own])
