"""From the tables of fibres, plies and laminates to laminates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from flexmech.errors import InputError
from flexmech.materials import (
    Fibre,
    Laminate,
    Layer,
    Material,
    Matrix,
    Ply,
    PlyDamping,
    ResinContent,
    ply_from_constituents,
    published_constituents,
    woven_ply,
)
from flexmech.modelfile.hygrothermal_tables import hygrothermal_of
from flexmech.modelfile.laminate_tables import (
    ConstituentPlyTable,
    ConstituentTable,
    IsotropicPlyTable,
    LaminateTable,
    MatrixTable,
    OrthotropicPlyTable,
    PlyTable,
)
from flexmech.modelfile.messages import known_name, located
from flexmech.materials.stacking import parse_stacking
from flexmech.modelfile.table import suggestion
from flexmech.modelfile.tables import MaterialTable, ModelFile

__all__ = ["build_laminates", "material_of"]

# Thickness of a layer over that of the stack, below which rounding takes over.
THINNEST = 1e-9


def build_laminates(tables: ModelFile, shown: str) -> dict[str, Laminate]:
    """Laminates of a model file, by name.

    Parameters
    ----------
    tables : ModelFile
    shown : str
        What messages call the file.

    Returns
    -------
    dict of str to Laminate

    Raises
    ------
    InputError
        If a constituent, ply or material is unknown, a stack is malformed, thicknesses or
        angles do not fit it, or a ply cannot be; names the dotted key.
    """
    fibres, matrices = _constituents(tables, shown)
    plies = {}
    for name, table in tables.plies.items():
        _check_names(shown, name, table, fibres, matrices, tables.materials)
        with located(shown, f"plies.{name}"):
            plies[name] = _ply(name, table, fibres, matrices, tables.materials)
    laminates = {}
    for name, laminate in tables.laminates.items():
        with located(shown, f"laminates.{name}"):
            laminates[name] = _laminate(laminate, plies, tables.plies)
    return laminates


def _constituents(tables: ModelFile, shown: str) -> tuple[dict[str, Fibre], dict[str, Matrix]]:
    published = published_constituents()
    fibres = {name: c for name, c in published.items() if isinstance(c, Fibre)}
    matrices = {name: c for name, c in published.items() if isinstance(c, Matrix)}
    for name, fibre in tables.fibres.items():
        with located(shown, f"fibres.{name}"):
            fibres[name] = Fibre(
                **_common(name, fibre),
                transverse_modulus=fibre.transverse_modulus,
                transverse_shear_modulus=fibre.transverse_shear_modulus,
                thermal_expansion=fibre.thermal_expansion,
            )
    for name, matrix in tables.matrices.items():
        with located(shown, f"matrices.{name}"):
            matrices[name] = _matrix(name, matrix)
    return fibres, matrices


def _matrix(name: str, table: MatrixTable) -> Matrix:
    stated = hygrothermal_of(table)
    return Matrix(
        **_common(name, table),
        thermal_expansion=stated.thermal_expansion,
        wet_thermal_expansion=stated.wet_thermal_expansion,
        moisture_expansion=stated.moisture_expansion,
        equilibrium=stated.equilibrium,
        diffusivity=stated.diffusivity,
        glass_transition=stated.glass_transition,
        tensile_strength=table.tensile_strength,
    )


def _common(name: str, table: ConstituentTable) -> dict[str, Any]:
    return {
        "name": name,
        "youngs_modulus": table.youngs_modulus,
        "shear_modulus": table.shear_modulus,
        "density": table.density,
        "poisson_ratio": table.poisson_ratio,
        "specific_damping": table.specific_damping,
    }


def _check_names(
    shown: str,
    name: str,
    table: PlyTable,
    fibres: Mapping[str, Fibre],
    matrices: Mapping[str, Matrix],
    materials: Mapping[str, MaterialTable],
) -> None:
    place = f"{shown}: plies.{name}"
    if isinstance(table, IsotropicPlyTable):
        known_name(f"{place}.material", "materials", table.material, materials)
    else:
        fibre = table.fibre if isinstance(table, ConstituentPlyTable) else None
        for key, got, known in (
            ("fibre", fibre, list(fibres)),
            ("matrix", table.matrix, list(matrices)),
        ):
            if got is not None and got not in known:
                plural = "fibres" if key == "fibre" else "matrices"
                raise InputError(
                    f"{place}.{key}: there is no {key} {got!r}; {suggestion(got, known)}, or add "
                    f"a table [{plural}.{got}]"
                )


def _ply(
    name: str,
    table: PlyTable,
    fibres: Mapping[str, Fibre],
    matrices: Mapping[str, Matrix],
    materials: Mapping[str, MaterialTable],
) -> Ply:
    if isinstance(table, IsotropicPlyTable):
        stated = materials[table.material]
        return _named(Ply.isotropic(material_of(stated)), name)
    if isinstance(table, OrthotropicPlyTable):
        ply = _orthotropic(table, matrices)
    else:
        ply = ply_from_constituents(
            fibres[table.fibre], matrices[table.matrix], table.fibre_volume_fraction, table.rule
        )
    return _named(woven_ply(ply) if table.weave == "woven" else ply, name)


def material_of(table: MaterialTable) -> Material:
    """Isotropic material that a table states."""
    return Material(
        table.youngs_modulus, table.density, table.poisson_ratio, hygrothermal_of(table)
    )


def _resin(table: OrthotropicPlyTable, matrices: Mapping[str, Matrix]) -> ResinContent | None:
    """The resin of a ply that is given by its measured constants."""
    if table.matrix is None or table.fibre_volume_fraction is None:
        return None
    matrix, share = matrices[table.matrix], 1 - table.fibre_volume_fraction
    return ResinContent(matrix.hygrothermal, share * matrix.density / table.density, share)


def _orthotropic(table: OrthotropicPlyTable, matrices: Mapping[str, Matrix]) -> Ply:
    in_plane = table.in_plane_shear_modulus
    across = table.transverse_shear_modulus
    if across is None:
        if table.poisson_ratio <= -1:
            raise InputError(
                "transverse_shear_modulus is missing: with a poisson_ratio of "
                f"{table.poisson_ratio:g} it does not follow from the transverse modulus; add it"
            )
        across = table.transverse_modulus / (2 * (1 + table.poisson_ratio))
    return Ply(
        longitudinal_modulus=table.longitudinal_modulus,
        transverse_modulus=table.transverse_modulus,
        in_plane_shear_modulus=in_plane,
        longitudinal_shear_modulus=table.longitudinal_shear_modulus or in_plane,
        transverse_shear_modulus=across,
        poisson_ratio=table.poisson_ratio,
        density=table.density,
        specific_damping=PlyDamping(
            table.longitudinal_damping, table.transverse_damping, table.shear_damping
        ),
        thermal_expansion=(
            table.longitudinal_thermal_expansion,
            table.transverse_thermal_expansion,
        ),
        moisture_expansion=(
            table.longitudinal_moisture_expansion,
            table.transverse_moisture_expansion,
        ),
        origin=_resin(table, matrices),
    )


def _laminate(
    table: LaminateTable, plies: Mapping[str, Ply], tables: Mapping[str, PlyTable]
) -> Laminate:
    stack = parse_stacking(table.stacking)
    for name, _ in stack:
        if name not in plies:
            remedy = suggestion(name, list(plies)) if plies else f"add a table [plies.{name}]"
            raise InputError(f"stacking {table.stacking!r} names the ply {name!r}; {remedy}")
    angles = _angles(table, stack)
    thicknesses = _thicknesses(table, [tables[name].thickness for name, _ in stack], stack)
    if min(thicknesses) < THINNEST * sum(thicknesses):
        raise InputError(
            f"the thinnest layer has {min(thicknesses):g} m of {sum(thicknesses):g} m, too little "
            "to compute with; check the units"
        )
    return Laminate(
        tuple(
            Layer(plies[name], thickness, angle)
            for (name, _), thickness, angle in zip(stack, thicknesses, angles, strict=True)
        )
    )


def _angles(table: LaminateTable, stack: list[tuple[str, float | None]]) -> list[float]:
    written = [angle for _, angle in stack]
    if table.angles is None:
        return [float(np.radians(angle or 0.0)) for angle in written]
    if any(angle is not None for angle in written):
        raise InputError("angles are given in the stacking and in the list; keep one of the two")
    if len(table.angles) != len(stack):
        raise InputError(
            f"angles has {len(table.angles)} values and the stack {len(stack)} layers; give one "
            "angle for each layer, from the lowest up"
        )
    return list(table.angles)


def _thicknesses(
    table: LaminateTable, of_plies: list[float | None], stack: list[tuple[str, float | None]]
) -> list[float]:
    given = table.ply_thickness
    if isinstance(given, list):
        if len(given) != len(stack):
            raise InputError(
                f"ply_thickness has {len(given)} values and the stack {len(stack)} layers; give "
                "one thickness, or one for each layer from the lowest up"
            )
        return given
    if given is not None:
        return [given] * len(stack)
    thicknesses = []
    for (name, _), thickness in zip(stack, of_plies, strict=True):
        if thickness is None:
            raise InputError(
                f"the thickness of ply {name!r} is not given; add ply_thickness here or "
                f"thickness in [plies.{name}]"
            )
        thicknesses.append(thickness)
    return thicknesses


def _named(ply: Ply, name: str) -> Ply:
    return replace(ply, name=name)
