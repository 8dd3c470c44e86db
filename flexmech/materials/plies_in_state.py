"""Plies in heat and water: softer resin, free strains."""

from __future__ import annotations

from dataclasses import replace

from flexmech.errors import InputError
from flexmech.materials.composition import PlyComposition
from flexmech.materials.hygrothermal import ResinContent
from flexmech.materials.micromechanics import ply_of
from flexmech.materials.ply import Ply
from flexmech.materials.strength import PlyStrength


def moisture_of(ply: Ply, offered: float) -> float:
    """Moisture of the resin in a ply where the environment offers ``offered``.

    Parameters
    ----------
    ply : Ply
    offered : float
        Mass of water over the dry mass of the resin.

    Returns
    -------
    float
        Zero for a ply without resin, such as a metal sheet.

    Raises
    ------
    InputError
        If it is more than the resin takes up, or the ply swells and its resin is not known.
    """
    if ply.resin is not None:
        return ply.resin.hygrothermal.checked_moisture(offered)
    if offered and any(ply.moisture_expansion):
        raise InputError(
            f"ply {ply.name!r} has a moisture_expansion, but not how much resin is in it; give "
            "its matrix and fibre_volume_fraction too"
        )
    return 0.0


def ply_in_state(ply: Ply, temperature: float, moisture: float, reference: float) -> Ply:
    """The ply with its resin moist and hot.

    A ply of known composition is computed again from its fibre and the softer resin. All moduli of
    a neat resin fall alike; in a ply given by measured constants those that the resin dominates do
    (E2, G12, G13, G23), and E1, Poisson's ratio, the damping and the expansions stay. Strengths
    that are stated fall as the resin's does, but for that of fibres in tension.

    Parameters
    ----------
    ply : Ply
        Dry, at the reference temperature.
    temperature : float
        In K.
    moisture : float
        Moisture of its resin.
    reference : float
        Temperature in K at which the dry moduli are stated.

    Returns
    -------
    Ply
        Its thermal expansion is that of the moist resin. The density stays that of the dry
        ply.

    Raises
    ------
    InputError
        If the resin is above its wet glass transition.
    """
    origin = ply.origin
    if origin is None:
        return ply
    if isinstance(origin, PlyComposition):
        moist = origin.matrix.in_state(temperature, moisture, reference)
        strength = ply.strength
        if strength is not None:
            kept = origin.matrix.hygrothermal.retention(temperature, moisture, reference)
            strength = strength.in_state(kept)
        return replace(ply_of(replace(origin, matrix=moist)), name=ply.name, strength=strength)
    return _softened(ply, origin, temperature, moisture, reference)


def ply_diluted(ply: Ply, growth: float) -> Ply:
    """The ply after its volume has grown by that of its resin: as many fibres in more of it.

    A ply of known composition is computed again with a smaller fibre volume fraction; of one by
    its measured constants the modulus along the fibres falls, which is theirs. A neat resin stays.

    Parameters
    ----------
    ply : Ply
        In its state.
    growth : float
        New over old volume.

    Returns
    -------
    Ply
    """
    origin = ply.origin
    if isinstance(origin, PlyComposition):
        thinner = replace(origin, fibre_volume_fraction=origin.fibre_volume_fraction / growth)
        return replace(ply_of(thinner), name=ply.name, strength=_diluted(ply, growth))
    if origin is not None and origin.volume_fraction < 1:
        return replace(
            ply,
            longitudinal_modulus=ply.longitudinal_modulus / growth,
            strength=_diluted(ply, growth),
        )
    return ply


def through_thickness_strain(ply: Ply, temperature_rise: float, moisture: float) -> float:
    """Free strain of a ply through its thickness.

    It equals the transverse strain of a unidirectional or an isotropic ply. In a woven one the
    crossed fibres hold the plane and not the thickness, where the ply expands as its unidirectional
    half.

    Parameters
    ----------
    ply : Ply
        In its state.
    temperature_rise : float
        Over the reference temperature in K.
    moisture : float

    Returns
    -------
    float
    """
    if isinstance(ply.origin, PlyComposition) and ply.origin.woven:
        ply = ply_of(replace(ply.origin, woven=False))
    return ply.thermal_expansion[1] * temperature_rise + ply.moisture_expansion[1] * moisture


def _diluted(ply: Ply, growth: float) -> PlyStrength | None:
    return None if ply.strength is None else ply.strength.diluted(growth)


def _softened(
    ply: Ply, resin: ResinContent, temperature: float, moisture: float, reference: float
) -> Ply:
    kept = resin.hygrothermal.retention(temperature, moisture, reference)
    neat = resin.volume_fraction == 1
    expansion = resin.hygrothermal.thermal_expansion_at(moisture)
    return replace(
        ply,
        longitudinal_modulus=ply.longitudinal_modulus * (kept if neat else 1.0),
        transverse_modulus=ply.transverse_modulus * kept,
        in_plane_shear_modulus=ply.in_plane_shear_modulus * kept,
        longitudinal_shear_modulus=ply.longitudinal_shear_modulus * kept,
        transverse_shear_modulus=ply.transverse_shear_modulus * kept,
        thermal_expansion=(expansion, expansion) if neat else ply.thermal_expansion,
        yield_strength=None if ply.yield_strength is None else ply.yield_strength * kept,
        strength=None if ply.strength is None else ply.strength.in_state(kept),
        fatigue=None if ply.fatigue is None else ply.fatigue.in_state(kept),
    )
