"""From the tables of fibres, plies and laminates to laminates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from flexmech.errors import InputError, suggestion
from flexmech.materials import (
    Fibre,
    Laminate,
    Layer,
    Matrix,
    Ply,
    PlyComposition,
    PlyDamping,
    ResinContent,
    published_constituents,
    woven_ply,
)
from flexmech.materials.laminate import parse_stacking
from flexmech.materials.micromechanics import ply_of
from flexmech.modelfile.document import MaterialTable, ModelFile
from flexmech.modelfile.material_tables import (
    CompositionTable,
    ConstituentTable,
    IsotropicPlyTable,
    LaminateTable,
    OrthotropicPlyTable,
    PlyTable,
)
from flexmech.modelfile.messages import Findings, known_name


def build_laminates(tables: ModelFile, findings: Findings) -> dict[str, Laminate]:
    """Laminates of a model file, by name.

    Parameters
    ----------
    tables : ModelFile
    findings : Findings
        Takes what is wrong: a constituent, ply or material that is unknown, a malformed stack,
        thicknesses or angles that do not fit it, or a ply that cannot be.

    Returns
    -------
    dict of str to Laminate
        Those in which nothing is wrong.
    """
    fibres, matrices = _constituents(tables, findings)
    plies = {}
    for name, table in tables.plies.items():
        with findings.at(f"plies.{name}"):
            # What is wrong with a constituent is told there.
            if _all_built(findings, name, table, tables, fibres, matrices):
                plies[name] = _ply(name, table, fibres, matrices, tables.materials)
    laminates = {}
    for name, laminate in tables.laminates.items():
        with findings.at(f"laminates.{name}"):
            built = _laminate(laminate, plies, tables.plies)
            if built is not None:
                laminates[name] = built
    return laminates


def _constituents(
    tables: ModelFile, findings: Findings
) -> tuple[dict[str, Fibre], dict[str, Matrix]]:
    """Published constituents and those of the file, without those in which something is wrong."""
    published = published_constituents()
    fibres = {name: c for name, c in published.items() if isinstance(c, Fibre)}
    matrices = {name: c for name, c in published.items() if isinstance(c, Matrix)}
    for name, fibre in tables.fibres.items():
        fibres.pop(name, None)
        with findings.at(f"fibres.{name}"):
            fibres[name] = fibre.made(Fibre, **_labels(name, fibre))
    for name, matrix in tables.matrices.items():
        matrices.pop(name, None)
        with findings.at(f"matrices.{name}"):
            heat_and_water = vars(matrix.hygrothermal)
            matrices[name] = matrix.made(Matrix, **_labels(name, matrix), **heat_and_water)
    return fibres, matrices


def _labels(name: str, table: ConstituentTable) -> dict[str, Any]:
    return {"name": name if table.name is None else table.name, "uncertainty": table.spreads}


def _all_built(
    findings: Findings,
    name: str,
    table: PlyTable,
    tables: ModelFile,
    fibres: Mapping[str, Fibre],
    matrices: Mapping[str, Matrix],
) -> bool:
    """Whether all that a ply names is known and could be built."""
    place = f"plies.{name}"
    if isinstance(table, IsotropicPlyTable):
        material, materials = table.material, list(tables.materials)
        return findings.none_at(
            f"{place}.material", lambda: known_name("materials", material, materials)
        )
    fibre, matrix = None, table.matrix
    if isinstance(table, CompositionTable):
        fibre = table.fibre
    elif table.constituents is not None:
        place = f"{place}.constituents"
        fibre, matrix = table.constituents.fibre, table.constituents.matrix
    for key, got, known, plural in (
        ("fibre", fibre, {**tables.fibres, **fibres}, "fibres"),
        ("matrix", matrix, {**tables.matrices, **matrices}, "matrices"),
    ):
        if got is not None and got not in known:
            findings.found.append(
                f"{place}.{key}: there is no {key} {got!r}; {suggestion(got, list(known))}, or "
                f"add a table [{plural}.{got}]"
            )
    return fibre in {None, *fibres} and matrix in {None, *matrices}


def _ply(
    name: str,
    table: PlyTable,
    fibres: Mapping[str, Fibre],
    matrices: Mapping[str, Matrix],
    materials: Mapping[str, MaterialTable],
) -> Ply:
    if isinstance(table, IsotropicPlyTable):
        ply = Ply.isotropic(materials[table.material].material)
    elif isinstance(table, OrthotropicPlyTable):
        ply = _orthotropic(table, _origin(table, fibres, matrices))
        ply = woven_ply(ply) if table.weave == "woven" else ply
    else:
        ply = ply_of(_composition(table, fibres, matrices))
    strength = None
    if not isinstance(table, IsotropicPlyTable) and table.strength is not None:
        strength = table.strength.strength
    return replace(ply, name=name if table.name is None else table.name, strength=strength)


def _composition(
    table: CompositionTable, fibres: Mapping[str, Fibre], matrices: Mapping[str, Matrix]
) -> PlyComposition:
    return PlyComposition(
        fibres[table.fibre],
        matrices[table.matrix],
        table.fibre_volume_fraction,
        table.rule,
        woven=table.weave == "woven",
    )


def _origin(
    table: OrthotropicPlyTable, fibres: Mapping[str, Fibre], matrices: Mapping[str, Matrix]
) -> PlyComposition | ResinContent | None:
    """What is in a ply that is given by its measured constants."""
    if table.constituents is not None:
        return _composition(table.constituents, fibres, matrices)
    if table.resin is not None:
        return table.resin.content
    if table.matrix is None or table.fibre_volume_fraction is None:
        return None
    matrix, share = matrices[table.matrix], 1 - table.fibre_volume_fraction
    return ResinContent(matrix.hygrothermal, share * matrix.density / table.density, share)


def _orthotropic(table: OrthotropicPlyTable, origin: PlyComposition | ResinContent | None) -> Ply:
    across = table.transverse_shear_modulus
    if across is None:
        if table.poisson_ratio <= -1:
            raise InputError(
                "transverse_shear_modulus is missing: with a poisson_ratio of "
                f"{table.poisson_ratio:g} it does not follow from the transverse modulus; add it"
            )
        across = table.transverse_modulus / (2 * (1 + table.poisson_ratio))
    in_plane = table.in_plane_shear_modulus
    return Ply(
        table.longitudinal_modulus,
        table.transverse_modulus,
        in_plane,
        table.longitudinal_shear_modulus or in_plane,
        across,
        table.poisson_ratio,
        table.density,
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
        origin=origin,
    )


def _laminate(
    table: LaminateTable, plies: Mapping[str, Ply], tables: Mapping[str, PlyTable]
) -> Laminate | None:
    """The laminate; None if something is wrong with one of its plies, which is told there."""
    stack = parse_stacking(table.stacking)
    for name, _ in stack:
        if name not in tables:
            remedy = suggestion(name, list(tables)) if tables else f"add a table [plies.{name}]"
            raise InputError(f"stacking {table.stacking!r} names the ply {name!r}; {remedy}")
    angles = _angles(table, stack)
    thicknesses = _thicknesses(table, [tables[name].thickness for name, _ in stack], stack)
    if any(name not in plies for name, _ in stack):
        return None
    return Laminate(
        tuple(
            Layer(plies[name], thickness, angle)
            for (name, _), thickness, angle in zip(stack, thicknesses, angles, strict=True)
        ),
        table.stress_free_temperature,
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
