"""A homogeneous, isotropic, linearly elastic material."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech import si
from flexmech.materials.fatigue import FatigueStrength
from flexmech.materials.hygrothermal import Hygrothermal
from flexmech.model_text import TomlTable, quantity, short_repr
from flexmech.units import RATIO
from flexmech.validation import check_instance

UNKNOWN = Hygrothermal()


@dataclass(frozen=True)
class Material:
    """Isotropic material in SI units.

    Parameters
    ----------
    youngs_modulus : float
        Young's modulus E in Pa.
    density : float
        Density rho in kg/m^3.
    poisson_ratio : float
        Poisson's ratio nu, between -1 and 0.5.
    hygrothermal : Hygrothermal
        What heat and water do to it.
    yield_strength : float, optional
        Stress in Pa beyond which it stays deformed; results say where a link passes it.
    fatigue : FatigueStrength, optional
        What it bears again and again.

    Raises
    ------
    InputError
        If a value is not a number or outside its range.

    Examples
    --------
    >>> steel = flexmech.Material(youngs_modulus=200e9, density=7800.0, poisson_ratio=0.25)
    >>> steel.shear_modulus
    80000000000.0
    """

    youngs_modulus: si.Stress
    density: si.Density
    poisson_ratio: si.PoissonRatio = 0.3
    hygrothermal: Hygrothermal = UNKNOWN
    yield_strength: si.Stress | None = None
    fatigue: FatigueStrength | None = None

    def __post_init__(self) -> None:
        si.check(self)
        if self.fatigue is not None:
            remedy = "give flexmech.FatigueStrength(tensile_strength, endurance_limit, cycles)"
            check_instance(self.fatigue, FatigueStrength, "fatigue", remedy)

    def __repr__(self) -> str:
        return short_repr(
            self,
            f"E {self.youngs_modulus / 1e9:.6g} GPa",
            f"density {self.density:.6g} kg/m^3",
            f"Poisson's ratio {self.poisson_ratio:.6g}",
            "known in heat and water" if self.hygrothermal.is_known else "",
        )

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) in Pa."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    def to_table(self) -> TomlTable:
        """Table under ``[materials]`` of a model file."""
        return {
            # Stated even where it is the usual one, which a file has to state.
            "poisson_ratio": quantity(self.poisson_ratio, RATIO),
            **si.table(self),
            **self.hygrothermal.to_table(),
            **({} if self.fatigue is None else {"fatigue": self.fatigue.to_table()}),
        }
