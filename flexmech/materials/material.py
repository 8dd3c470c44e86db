"""A homogeneous, isotropic, linearly elastic material."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech.materials.fatigue import FatigueStrength
from flexmech.materials.hygrothermal import Hygrothermal
from flexmech.model_text import TomlTable, quantity, short_repr, stated
from flexmech.units import DENSITY, RATIO, STRESS
from flexmech.validation import POSITIVE, Bounds, check_fields, check_instance

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
    yield_strength : float, optional
        Stress in Pa beyond which it stays deformed.
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

    youngs_modulus: float
    density: float
    poisson_ratio: float = 0.3
    hygrothermal: Hygrothermal = UNKNOWN
    yield_strength: float | None = None
    fatigue: FatigueStrength | None = None

    def __post_init__(self) -> None:
        check_fields(self, {"youngs_modulus": "Pa", "density": "kg/m^3"}, POSITIVE)
        check_fields(self, {"yield_strength": "Pa"}, POSITIVE, optional=True)
        check_fields(self, {"poisson_ratio": ""}, Bounds(above=-1.0, below=0.5))
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
            "youngs_modulus": quantity(self.youngs_modulus, STRESS),
            "density": quantity(self.density, DENSITY),
            "poisson_ratio": quantity(self.poisson_ratio, RATIO),
            **stated(yield_strength=(self.yield_strength, STRESS)),
            **self.hygrothermal.to_table(),
            **({} if self.fatigue is None else {"fatigue": self.fatigue.to_table()}),
        }
