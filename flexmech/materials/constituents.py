"""Fibres and resins that plies are made of, with the uncertainty that their sources print."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from importlib import resources
from typing import Any, ClassVar

from flexmech import si, units
from flexmech.errors import InputError
from flexmech.materials.hygrothermal import Hygrothermal
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr
from flexmech.validation import NOT_NEGATIVE, check_number

# Properties by the names of their fields.
DIMENSIONS = {
    "youngs_modulus": units.STRESS,
    "shear_modulus": units.STRESS,
    "density": units.DENSITY,
    "poisson_ratio": units.RATIO,
    "thermal_expansion": units.EXPANSION,
    "moisture_expansion": units.MOISTURE_EXPANSION,
    "specific_damping": units.RATIO,
    "transverse_modulus": units.STRESS,
    "transverse_shear_modulus": units.STRESS,
    "wet_thermal_expansion": units.EXPANSION,
    "glass_transition": units.TEMPERATURE,
    "tensile_strength": units.STRESS,
}


@dataclass(frozen=True)
class Constituent:
    """Common properties of fibres and resins.

    Parameters
    ----------
    name : str
    youngs_modulus : float
        Young's modulus E in Pa; of a fibre, along it.
    shear_modulus : float
        Shear modulus G in Pa.
    density : float
        Density rho in kg/m^3.
    poisson_ratio : float
        Poisson's ratio nu, between 0 and 0.5.
    thermal_expansion : float
        Strain per temperature in 1/K.
    moisture_expansion : float
        Strain per unit of moisture, mass over the constituent's dry mass.
    specific_damping : float
        Energy lost in a cycle over its largest; 0 where it is not known.
    source : str
        Where the numbers are from.
    uncertainty : mapping of str to float
        Uncertainty of properties whose source prints one, by their names, in the same units.

    Raises
    ------
    InputError
        If a value is not a number or outside its range, or an uncertainty is of no property
        that has a value.
    """

    name: str
    youngs_modulus: si.Stress
    shear_modulus: si.Stress
    density: si.Density
    poisson_ratio: si.PositivePoissonRatio
    thermal_expansion: si.Expansion = 0.0
    moisture_expansion: si.MoistureExpansion = 0.0
    specific_damping: si.SpecificDamping = 0.0
    source: str = ""
    uncertainty: Mapping[str, float] = field(default_factory=dict, hash=False)

    kind: ClassVar[str]
    """Name of the table of such constituents in a model file."""

    def __post_init__(self) -> None:
        of = f"of {self.name!r}"
        si.check(self, f"{{}} {of}")
        known = [name for name in DIMENSIONS if getattr(self, name, None) is not None]
        for name, value in self.uncertainty.items():
            if name not in known:
                raise InputError(
                    f"uncertainty of {self.name!r} is of {name!r}, which is no property with a "
                    f"value; those are {', '.join(known)}"
                )
            unit = DIMENSIONS[name].unit
            check_number(value, f"uncertainty of {name} {of}", unit, NOT_NEGATIVE)

    def __repr__(self) -> str:
        return short_repr(
            self,
            self.name,
            f"E {self.youngs_modulus / 1e9:.6g} GPa",
            f"G {self.shear_modulus / 1e9:.6g} GPa",
            f"density {self.density:.6g} kg/m^3",
        )

    def to_table(self) -> TomlTable:
        """Table of a model file, without the name."""
        table = si.table(self)
        if self.source:
            table["source"] = self.source
        spreads = {
            name: quantity(
                spread,
                units.TEMPERATURE_DIFFERENCE if name == "glass_transition" else DIMENSIONS[name],
            )
            for name, spread in self.uncertainty.items()
        }
        return {**table, "uncertainty": spreads} if spreads else table

    def name_in(self, shared: SharedTables) -> str:
        """Name by which plies refer to it in a model file; its table is added if it needs one."""
        if published_constituents().get(self.name) == self and shared.leave(self.kind, self.name):
            return self.name
        return shared.name_of(self.kind, self.to_table(), self.name, own_name=self.name)


@dataclass(frozen=True, repr=False)
class Fibre(Constituent):
    """A reinforcing fibre; transversely isotropic where its transverse moduli are given.

    Parameters
    ----------
    name : str
    youngs_modulus : float
        Young's modulus E1 in Pa along the fibre.
    shear_modulus : float
        Shear modulus G12 in Pa.
    density : float
        Density rho in kg/m^3.
    poisson_ratio : float
        Contraction across over stretch along the fibre, between 0 and 0.5.
    thermal_expansion : float
        Strain per temperature in 1/K, along and across alike.
    moisture_expansion : float
        Strain per unit of moisture, mass over the fibre's dry mass.
    specific_damping : float
        Energy lost in a cycle over its largest; 0 where it is not known.
    source : str
        Where the numbers are from.
    uncertainty : mapping of str to float
        Uncertainty of properties whose source prints one, by their names, in the same units.
    transverse_modulus : float, optional
        Young's modulus E2 in Pa across the fibre; that along it if left out.
    transverse_shear_modulus : float, optional
        Shear modulus G23 in Pa in the fibre's cross-section; G12 if left out.

    Raises
    ------
    InputError
        As for any constituent, or if a transverse modulus is not positive.
    """

    transverse_modulus: si.Stress | None = None
    transverse_shear_modulus: si.Stress | None = None

    kind: ClassVar[str] = "fibres"

    @property
    def modulus_across(self) -> float:
        """Young's modulus across the fibre in Pa."""
        return self.youngs_modulus if self.transverse_modulus is None else self.transverse_modulus

    @property
    def shear_modulus_across(self) -> float:
        """Shear modulus in the fibre's cross-section in Pa."""
        given = self.transverse_shear_modulus
        return self.shear_modulus if given is None else given


@dataclass(frozen=True, repr=False)
class Matrix(Constituent):
    """A resin.

    Parameters
    ----------
    name : str
    youngs_modulus : float
        Young's modulus E in Pa of the dry resin at the reference temperature.
    shear_modulus : float
        Shear modulus G in Pa of the dry resin at the reference temperature.
    density : float
        Density rho in kg/m^3 of the dry resin.
    poisson_ratio : float
        Poisson's ratio nu, between 0 and 0.5.
    thermal_expansion : float
        Strain per temperature in 1/K of the dry resin.
    moisture_expansion : float
        Strain per unit of moisture, mass of water over the resin's dry mass.
    specific_damping : float
        Energy lost in a cycle over its largest; 0 where it is not known.
    source : str
        Where the numbers are from.
    uncertainty : mapping of str to float
        Uncertainty of properties whose source prints one, by their names, in the same units.
    wet_thermal_expansion : float, optional
        Thermal expansion of the saturated resin in 1/K.
    equilibrium : MoistureEquilibrium, optional
    diffusivity : Diffusivity, optional
        Diffusivity of water in the resin.
    glass_transition : float, optional
        Glass transition of the dry resin in K.
    tensile_strength : float, optional
        Tensile strength of the dry resin at the reference temperature, in Pa.

    Raises
    ------
    InputError
        As for any constituent, or if a hygrothermal property or the strength cannot be.
    """

    wet_thermal_expansion: si.Expansion | None = None
    equilibrium: MoistureEquilibrium | None = None
    diffusivity: Diffusivity | None = None
    glass_transition: si.Temperature | None = None
    tensile_strength: si.Stress | None = None

    kind: ClassVar[str] = "matrices"

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.hygrothermal

    @property
    def hygrothermal(self) -> Hygrothermal:
        """Hygrothermal properties of the resin; omitted ones have no effect."""
        return Hygrothermal(**{own.name: getattr(self, own.name) for own in fields(Hygrothermal)})

    def to_table(self) -> TomlTable:
        """Table of a model file, without the name."""
        return {**super().to_table(), **self.hygrothermal.to_table()}

    def in_state(self, temperature: float, moisture: float, reference: float) -> Matrix:
        """The moist and hot resin: softer and weaker, with its expansion then.

        Parameters
        ----------
        temperature : float
            In K.
        moisture : float
        reference : float
            Temperature in K at which the dry moduli are stated.

        Returns
        -------
        Matrix
            Itself, with its wet expansion, where it is dry and at the reference temperature.

        Raises
        ------
        InputError
            If the resin is above its wet glass transition.
        """
        kept = self.hygrothermal.retention(temperature, moisture, reference)
        if moisture == 0.0 and temperature == reference:
            return self
        strength = self.tensile_strength
        return replace(
            self,
            youngs_modulus=self.youngs_modulus * kept,
            shear_modulus=self.shear_modulus * kept,
            tensile_strength=None if strength is None else strength * kept,
            thermal_expansion=self.hygrothermal.thermal_expansion_at(moisture),
            wet_thermal_expansion=None,
        )


def published_constituents() -> dict[str, Fibre | Matrix]:
    """Constituents that ship with the package, by name, each with its source.

    ``E-glass``, ``carbon`` and ``polyester`` are Table 1 of Elamy et al. 2023 as printed, with
    the printed uncertainties. The shear moduli printed there (2400, 1526.5 and 50.3 MPa) are
    far below those of isotropic materials with the Young's moduli and Poisson's ratios beside
    them (29, 83 and 0.90 GPa); rows whose names end in ``(isotropic shear)`` have the latter
    and differ in nothing else. No carbon fibre is isotropic in truth: its own shear and
    transverse moduli, where known, are better than either.

    The paper states neither damping nor expansion; both are zero here, which means unknown.

    Returns
    -------
    dict of str to Fibre or Matrix

    Examples
    --------
    >>> flexmech.published_constituents()["carbon"]
    <Fibre: carbon, E 201.5 GPa, G 1.5265 GPa, density 1740 kg/m^3>
    """
    return dict(_shipped())


@lru_cache
def _shipped() -> dict[str, Fibre | Matrix]:
    table = resources.files("flexmech.materials").joinpath("data", "constituents.csv")
    with table.open(encoding="utf-8") as stream:
        lines = (line for line in stream if not line.startswith("#"))
        rows = [_from_row(row) for row in csv.DictReader(lines)]
    found = {row.name: row for row in rows}
    for row in rows:
        shear = row.youngs_modulus / (2 * (1 + row.poisson_ratio))
        spread = {k: v for k, v in row.uncertainty.items() if k != "shear_modulus"}
        name = f"{row.name} (isotropic shear)"
        source = f"{row.source}; shear modulus of an isotropic material"
        found[name] = replace(
            row, name=name, shear_modulus=shear, source=source, uncertainty=spread
        )
    return found


def _from_row(row: dict[str, str]) -> Fibre | Matrix:
    columns = {
        "youngs_modulus": ("E_GPa", "E_pm_GPa", 1e9),
        "shear_modulus": ("G_MPa", "G_pm_MPa", 1e6),
        "density": ("density_g_cm3", "density_pm_g_cm3", 1e3),
    }
    values: dict[str, Any] = {
        name: float(row[column]) * unit for name, (column, _, unit) in columns.items()
    }
    uncertainty = {
        name: float(row[spread]) * unit
        for name, (_, spread, unit) in columns.items()
        if row[spread]
    }
    kind = Fibre if row["role"] == "fibre" else Matrix
    return kind(
        name=row["name"],
        poisson_ratio=float(row["poisson"]),
        source=row["source"],
        uncertainty=uncertainty,
        **values,
    )
