"""From the stability maps of the engines to one labelled dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.datasets import provenance
from flexmech.analyses.stability.engine_map import LEAST_CLOSING_RATIO
from flexmech.analyses.stability.engine_stability import (
    Band,
    EngineStability,
    FollowedSpeed,
    NoEquilibrium,
)
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.types import FloatArray

YES, NO, NO_EQUILIBRIUM = "yes", "no", "no equilibrium"
NOT_COMPUTED = "not computed"
"""Of speeds that an interrupted map has not come to."""

OVER_SPEEDS = ("engine", "crank_speed")
OVER_MULTIPLIERS = (*OVER_SPEEDS, "multiplier")
# What a followed speed says of each multiplier, and of all of them.
OF_MULTIPLIERS: dict[str, Callable[[FollowedSpeed], FloatArray]] = {
    "log_modulus": lambda each: each.log_modulus,
    "angle": lambda each: each.angle,
    "damping_ratio": lambda each: each.damping_ratio,
    "frequency": lambda each: each.frequency,
    "step_error": lambda each: each.step_error,
    "likeness": lambda each: each.likeness,
    "krein_signature": lambda each: each.krein_signature,
}
OF_SPEEDS: dict[str, Callable[[FollowedSpeed], float | None]] = {
    "growth_rate": lambda each: each.growth_rate,
    "multiplier_modulus": lambda each: float(np.exp(each.log_modulus.max())),
    "liouville_defect": lambda each: each.liouville_defect,
    "steps": lambda each: float(each.steps),
    "buckled_angle": lambda each: each.buckled_angle,
    "orbit_distance": lambda each: each.orbit_distance,
    "orbit_residual": lambda each: each.orbit_residual,
}
OF_ENGINES = ("is_definite", "moving_modes", "closed_early", "interrupted")
OF_BANDS: dict[str, Callable[[Band], Any]] = {
    "lower": lambda band: band.lower.crank_speed,
    "upper": lambda band: band.upper.crank_speed,
    "lower_step_error": lambda band: band.lower.step_error,
    "lower_reduction_error": lambda band: band.lower.reduction_error,
    "lower_mesh_error": lambda band: band.lower.mesh_error,
    "upper_step_error": lambda band: band.upper.step_error,
    "upper_reduction_error": lambda band: band.upper.reduction_error,
    "upper_mesh_error": lambda band: band.upper.mesh_error,
    "lower_open": lambda band: band.lower.is_open,
    "upper_open": lambda band: band.upper.is_open,
    "kind": lambda band: band.kind,
    "branches": lambda band: " ".join(map(str, dict.fromkeys(band.branches))),
    "order": lambda band: band.order,
    "largest_growth_rate": lambda band: band.largest_growth_rate,
    "fastest_speed": lambda band: band.fastest_speed,
    "closing_damping_ratio": lambda band: band.closing_damping_ratio,
    "mismatch": lambda band: band.mismatch,
    "first_signature": lambda band: band.signatures[0],
    "second_signature": lambda band: band.signatures[1],
}
TYPES: dict[str, Any] = {
    "engine": str,
    "kind": str,
    "branches": str,
    "order": np.intp,
    "lower_open": bool,
    "upper_open": bool,
}


def dataset_of(maps: Sequence[EngineStability], request: StabilityRequest) -> xr.Dataset:
    """Join the maps of all engines, and label them.

    Parameters
    ----------
    maps : sequence of EngineStability
    request : StabilityRequest

    Returns
    -------
    xarray.Dataset
        Over (engine, crank_speed), (engine, crank_speed, multiplier) and so on, not a number
        where there is nothing; bands over ``band`` and checked errors over ``check``, each with
        the engine that it is of.
    """
    speeds = request.crank_speeds
    followed = [_followed(each, speeds) for each in maps]
    kept = max((len(each.exponent) for own in followed for each in own.values()), default=0)
    harmonics = max(
        (len(each.harmonic_share) for own in followed for each in own.values()), default=1
    )
    variables: dict[str, Any] = {
        "unstable": (OVER_SPEEDS, _by_speed(maps, speeds, state_of, NOT_COMPUTED)),
        "reason": (OVER_SPEEDS, _by_speed(maps, speeds, _reason, "")),
    }
    for name, value in OF_SPEEDS.items():
        table = np.full((len(maps), len(speeds)), np.nan)
        for engine, own in enumerate(followed):
            for place, each in own.items():
                number = value(each)
                table[engine, place] = np.nan if number is None else number
        variables[name] = (OVER_SPEEDS, table)
    for name, values in OF_MULTIPLIERS.items():
        variables[name] = (OVER_MULTIPLIERS, _padded(followed, len(speeds), kept, values))
    if all(each.engine.rigid_modes for each in maps):
        variables["shaft_growth_rate"] = (OVER_SPEEDS, _shaft(followed, len(speeds)))
    variables["harmonic_share"] = (
        (*OVER_MULTIPLIERS, "harmonic"),
        _shares(followed, len(speeds), kept, harmonics),
    )
    variables |= _bands(maps) | _checks(maps)
    for name in OF_ENGINES:
        variables[name] = ("engine", [getattr(each, name) for each in maps])
    engines = [each.engine for each in maps]
    dataset = xr.Dataset(
        variables,
        coords={
            "engine": [engine.name for engine in engines],
            "element": ("engine", [engine.element for engine in engines]),
            "elements": ("engine", [engine.elements for engine in engines]),
            "crank_speed": speeds,
            "multiplier": np.arange(1, kept + 1),
            "branch_of_multiplier": ("multiplier", np.arange(kept) // 2 + 1),
            "harmonic": np.arange(harmonics) - harmonics // 2,
        },
    )
    return dataset.assign_attrs(
        provenance(engines),
        prestress=request.prestress,
        frame=request.frame,
        modes=request.modes,
        damping=_damping(request),
        # Bands that it closes are left out.
        least_closing_ratio=max(LEAST_CLOSING_RATIO, request.damping_ratio or 0.0),
        speed_unit=request.speed_unit,
    )


def state_of(speed: FollowedSpeed | NoEquilibrium) -> str:
    """What column ``unstable`` says of a speed."""
    if isinstance(speed, NoEquilibrium) or speed.buckled_angle is not None:
        return NO_EQUILIBRIUM
    return YES if speed.is_unstable else NO


def _reason(speed: FollowedSpeed | NoEquilibrium) -> str:
    """Why there is no equilibrium; empty where there is one."""
    if isinstance(speed, NoEquilibrium):
        return speed.reason
    if speed.buckled_angle is None:
        return ""
    return (
        f"straight links buckle statically at crank angle {np.degrees(speed.buckled_angle):.6g} deg"
    )


def _damping(request: StabilityRequest) -> str:
    if request.damping_ratio is None:
        return "of the model"
    return f"damping ratio {100 * request.damping_ratio:.6g} % of the first frequency at rest"


def _followed(found: EngineStability, speeds: FloatArray) -> dict[int, FollowedSpeed]:
    """Speeds that have Floquet modes, by their places among all."""
    return {_place(each, speeds): each for each in found.speeds if isinstance(each, FollowedSpeed)}


def _place(speed: FollowedSpeed | NoEquilibrium, speeds: FloatArray) -> int:
    """Place of a speed among all; it may differ from the one asked for by round-off."""
    return int(np.abs(speeds - speed.crank_speed).argmin())


def _by_speed(
    maps: Sequence[EngineStability],
    speeds: FloatArray,
    told: Callable[[FollowedSpeed | NoEquilibrium], str],
    otherwise: str,
) -> NDArray[np.str_]:
    rows = [{_place(each, speeds): told(each) for each in own.speeds} for own in maps]
    return np.array(
        [[row.get(n, otherwise) for n in range(len(speeds))] for row in rows], dtype=str
    )


def _padded(
    followed: Sequence[dict[int, FollowedSpeed]],
    speeds: int,
    kept: int,
    values: Callable[[FollowedSpeed], FloatArray],
) -> FloatArray:
    """Values over (engine, crank_speed, multiplier); not a number where there are none."""
    table = np.full((len(followed), speeds, kept), np.nan)
    for engine, own in enumerate(followed):
        for place, each in own.items():
            found = values(each)
            table[engine, place, : len(found)] = found
    return table


def _shaft(followed: Sequence[dict[int, FollowedSpeed]], speeds: int) -> FloatArray:
    """Growth rate of the free shaft's own motion over (engine, crank_speed)."""
    table = np.full((len(followed), speeds), np.nan)
    for engine, own in enumerate(followed):
        for place, each in own.items():
            table[engine, place] = each.shaft_growth_rate
    return table


def _shares(
    followed: Sequence[dict[int, FollowedSpeed]], speeds: int, kept: int, harmonics: int
) -> FloatArray:
    table = np.full((len(followed), speeds, kept, harmonics), np.nan)
    for engine, own in enumerate(followed):
        for place, each in own.items():
            share = each.harmonic_share.T
            table[engine, place, : share.shape[0], : share.shape[1]] = share
    return table


def _bands(maps: Sequence[EngineStability]) -> dict[str, tuple[str, NDArray[Any]]]:
    """Bands of all engines, a variable for each property, named like ``band_kind``."""
    rows = [(each.engine.name, band) for each in maps for band in each.bands]
    columns: dict[str, list[Any]] = {"engine": [engine for engine, _ in rows]}
    for name, value in OF_BANDS.items():
        columns[name] = [value(band) for _, band in rows]
    return {
        f"band_{name}": ("band", np.array(values, dtype=TYPES.get(name, float)))
        for name, values in columns.items()
    }


def _checks(maps: Sequence[EngineStability]) -> dict[str, tuple[str, NDArray[Any]]]:
    """Errors of the multipliers at the speeds checked, of all engines."""
    names = [each.engine.name for each in maps for _ in each.errors.crank_speed]
    parts = {
        "check_speed": [each.errors.crank_speed for each in maps],
        "check_reduction": [each.errors.reduction for each in maps],
        "check_mesh": [each.errors.mesh for each in maps],
    }
    joined = {name: ("check", np.concatenate(values)) for name, values in parts.items()}
    return {"check_engine": ("check", np.array(names, dtype=str))} | joined
