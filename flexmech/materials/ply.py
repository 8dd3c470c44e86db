"""One ply of a laminate: orthotropic, in plane stress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech import si
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.materials.composition import PlyComposition
from flexmech.materials.fatigue import FatigueStrength
from flexmech.materials.hygrothermal import Hygrothermal, ResinContent
from flexmech.materials.material import Material
from flexmech.materials.strength import PlyStrength
from flexmech.model_text import short_repr
from flexmech.validation import (
    check_instance,
)

MODULI = (
    "longitudinal_modulus",
    "transverse_modulus",
    "in_plane_shear_modulus",
    "longitudinal_shear_modulus",
    "transverse_shear_modulus",
)
"""Fields of a ply in Pa."""


@dataclass(frozen=True)
class PlyDamping:
    """Specific damping capacity of a ply by direction: energy lost in a cycle over its largest.

    Parameters
    ----------
    longitudinal, transverse, shear : float
        Capacity under stress along the fibres, under stress across them, and under shear.

    Raises
    ------
    InputError
        If a value is negative or not a number.
    """

    longitudinal: si.SpecificDamping = 0.0
    transverse: si.SpecificDamping = 0.0
    shear: si.SpecificDamping = 0.0

    def __post_init__(self) -> None:
        si.check(self, "{} specific damping")

    @property
    def any(self) -> bool:
        """Whether anything is lost."""
        return self.longitudinal > 0 or self.transverse > 0 or self.shear > 0

    @property
    def by_direction(self) -> tuple[float, float, float]:
        """Along the fibres, across them, and in shear."""
        return self.longitudinal, self.transverse, self.shear


@dataclass(frozen=True)
class Ply:
    """Orthotropic ply; direction 1 along the fibres, 2 across them in its plane, 3 normal.

    Parameters
    ----------
    longitudinal_modulus : float
        E1 in Pa, along the fibres.
    transverse_modulus : float
        E2 in Pa, across them.
    in_plane_shear_modulus : float
        G12 in Pa.
    longitudinal_shear_modulus : float
        G13 in Pa; G12 where a model file leaves it out.
    transverse_shear_modulus : float
        G23 in Pa; E2 / (2 (1 + nu12)) where a model file leaves it out.
    poisson_ratio : float
        nu12: contraction across over stretch along the fibres.
    density : float
        Density rho in kg/m^3.
    specific_damping : PlyDamping
    thermal_expansion : tuple of float
        Along and across the fibres in 1/K.
    moisture_expansion : tuple of float
        Along and across the fibres, strain per unit of moisture: mass over the dry mass of
        the resin.
    name : str
    origin : PlyComposition or ResinContent, optional
        Constituents that the ply was computed from, or the resin in it where only that is known: by
        it the ply takes up water and softens.
    yield_strength : float, optional
        Yield strength of an isotropic ply, in Pa.
    strength : PlyStrength, optional
        Strength of a ply with fibres.
    fatigue : FatigueStrength, optional
        Fatigue of an isotropic ply.

    Raises
    ------
    InputError
        If a modulus, the density or the yield strength is not positive, an expansion is not two
        numbers, or Poisson's ratio lets a stress do negative work.

    Examples
    --------
    >>> flexmech.Ply.isotropic(flexmech.Material(70e9, 2700.0, 0.33))
    <Ply: E1 70 GPa, E2 70 GPa, G12 26.3158 GPa, density 2700 kg/m^3>
    """

    longitudinal_modulus: si.Stress
    transverse_modulus: si.Stress
    in_plane_shear_modulus: si.Stress
    longitudinal_shear_modulus: si.Stress
    transverse_shear_modulus: si.Stress
    poisson_ratio: si.Ratio
    density: si.Density
    specific_damping: PlyDamping = PlyDamping()
    thermal_expansion: tuple[si.Expansion, si.Expansion] = (0.0, 0.0)
    moisture_expansion: tuple[si.PlyMoistureExpansion, si.PlyMoistureExpansion] = (0.0, 0.0)
    name: str = ""
    origin: PlyComposition | ResinContent | None = None
    yield_strength: si.Stress | None = None
    strength: PlyStrength | None = None
    fatigue: FatigueStrength | None = None

    def __post_init__(self) -> None:
        si.check(self, "{} of a ply")
        if self.strength is not None:
            remedy = "give flexmech.PlyStrength(Xt, Xc, Yt, Yc, S12) in Pa"
            check_instance(self.strength, PlyStrength, "strength of a ply", remedy)
        bound = float(np.sqrt(self.longitudinal_modulus / self.transverse_modulus))
        if not abs(self.poisson_ratio) < bound:
            raise InputError(
                f"poisson_ratio of a ply must lie between -{bound:.6g} and {bound:.6g} "
                "(the root of E1 / E2), or some stress would do negative work; got "
                f"{self.poisson_ratio}"
            )

    def __repr__(self) -> str:
        return short_repr(
            self,
            self.name,
            f"E1 {self.longitudinal_modulus / 1e9:.6g} GPa",
            f"E2 {self.transverse_modulus / 1e9:.6g} GPa",
            f"G12 {self.in_plane_shear_modulus / 1e9:.6g} GPa",
            f"density {self.density:.6g} kg/m^3",
        )

    @classmethod
    def isotropic(cls, material: Material) -> Self:
        """The ply of an isotropic material."""
        modulus, shear = material.youngs_modulus, material.shear_modulus
        hygrothermal = material.hygrothermal
        heat, water = hygrothermal.thermal_expansion, hygrothermal.moisture_expansion
        return cls(
            longitudinal_modulus=modulus,
            transverse_modulus=modulus,
            in_plane_shear_modulus=shear,
            longitudinal_shear_modulus=shear,
            transverse_shear_modulus=shear,
            poisson_ratio=material.poisson_ratio,
            density=material.density,
            thermal_expansion=(heat, heat),
            moisture_expansion=(water, water),
            origin=ResinContent(hygrothermal) if hygrothermal.is_known else None,
            yield_strength=material.yield_strength,
            fatigue=material.fatigue,
        )

    def stiffened(self, factor: float) -> Self:
        """The ply with all moduli times a factor, which follows from no constituents."""
        moduli = {name: factor * getattr(self, name) for name in MODULI}
        return replace(self, **moduli, origin=None)

    @property
    def isotropic_material(self) -> Material | None:
        """Material of which :meth:`isotropic` makes this ply; None where it is another one."""
        known = self.origin.hygrothermal if isinstance(self.origin, ResinContent) else None
        if not -1 < self.poisson_ratio < 0.5:
            return None
        material = Material(
            self.longitudinal_modulus,
            self.density,
            self.poisson_ratio,
            known or Hygrothermal(),
            self.yield_strength,
            self.fatigue,
        )
        return material if replace(Ply.isotropic(material), name=self.name) == self else None

    @property
    def resin(self) -> ResinContent | None:
        """The resin in the ply, where it is known."""
        return self.origin.resin if isinstance(self.origin, PlyComposition) else self.origin

    @property
    def reduced_stiffness(self) -> FloatArray:
        """Plane-stress stiffness by strains along, across and shear, (3, 3), in Pa.

        Elamy et al. 2023, eqs. 23-24; Jones, *Mechanics of Composite Materials*, eq. 2.66.
        """
        along, across = self.longitudinal_modulus, self.transverse_modulus
        nu = self.poisson_ratio
        rest = 1 - nu**2 * across / along
        return np.array(
            [
                [along / rest, nu * across / rest, 0.0],
                [nu * across / rest, across / rest, 0.0],
                [0.0, 0.0, self.in_plane_shear_modulus],
            ]
        )

    @property
    def transverse_shear_stiffness(self) -> FloatArray:
        """Stiffness against shear through the thickness, (2, 2), in Pa: planes 23, then 13."""
        return np.diag([self.transverse_shear_modulus, self.longitudinal_shear_modulus])
