"""A ply as a table of a model file: by its material, its constituents, or its constants."""

from __future__ import annotations

from dataclasses import replace

from flexmech.materials.composition import PlyComposition
from flexmech.materials.micromechanics import ply_of
from flexmech.materials.ply import MODULI, Ply
from flexmech.model_text import SharedTables, TomlTable, stated
from flexmech.units import DENSITY, EXPANSION, MOISTURE_EXPANSION, RATIO, STRESS


def ply_table(ply: Ply, shared: SharedTables) -> TomlTable:
    """Table under ``[plies]`` of a model file, without the name.

    Parameters
    ----------
    ply : Ply
    shared : SharedTables
        Its material or its constituents are added.

    Returns
    -------
    dict
        By its material or its constituents where they give the same ply to the last bit, else
        by its constants.
    """
    material = ply.isotropic_material
    if material is not None:
        name = shared.name_of("materials", material.to_table(), ply.name or "material")
        return {"type": "isotropic", "material": name}
    origin = ply.origin
    if not isinstance(origin, PlyComposition):
        resin = {} if origin is None else {"resin": origin.to_table()}
        return {**_constants(ply), **resin, **_strength_table(ply)}
    constituents = origin.to_table(shared)
    # TOML wants a table's own tables after its values.
    strength = _strength_table(ply)
    if replace(ply_of(origin), name=ply.name, strength=ply.strength) == ply:
        return {"type": "constituents", **constituents, **strength}
    return {**_constants(ply), "constituents": constituents, **strength}


def _strength_table(ply: Ply) -> TomlTable:
    return {} if ply.strength is None else {"strength": ply.strength.to_table()}


def _constants(ply: Ply) -> TomlTable:
    damping = ply.specific_damping
    heat, water = ply.thermal_expansion, ply.moisture_expansion
    return {
        "type": "orthotropic",
        **stated(**{name: (getattr(ply, name), STRESS) for name in MODULI}),
        **stated(
            poisson_ratio=(ply.poisson_ratio, RATIO),
            density=(ply.density, DENSITY),
            longitudinal_damping=(damping.longitudinal or None, RATIO),
            transverse_damping=(damping.transverse or None, RATIO),
            shear_damping=(damping.shear or None, RATIO),
            longitudinal_thermal_expansion=(heat[0] or None, EXPANSION),
            transverse_thermal_expansion=(heat[1] or None, EXPANSION),
            longitudinal_moisture_expansion=(water[0] or None, MOISTURE_EXPANSION),
            transverse_moisture_expansion=(water[1] or None, MOISTURE_EXPANSION),
        ),
    }
