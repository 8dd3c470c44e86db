"""From the stability maps of the engines to one labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import Column, engine_coordinates, filled, provenance, records
from flexmech.analyses.stability.engine_map import LEAST_CLOSING_RATIO
from flexmech.analyses.stability.growth import (
    Band,
    EngineStability,
    ExponentErrors,
    NoEquilibrium,
    Sample,
    TrackedSpeed,
)
from flexmech.analyses.stability.request import StabilityRequest

YES, NO, NO_EQUILIBRIUM = "yes", "no", "no equilibrium"
# Of speeds that an interrupted map has not come to.
NOT_COMPUTED = "not computed"

OVER_SPEEDS = ("engine", "crank_speed")
OVER_MULTIPLIERS = (*OVER_SPEEDS, "multiplier")
# What a tracked speed says of all multipliers, and of each of them.
OF_SPEEDS = {
    OVER_SPEEDS: (
        "growth_rate",
        "multiplier_modulus",
        "liouville_defect",
        "steps",
        "buckled_angle",
        "orbit_distance",
        "orbit_residual",
    ),
    OVER_MULTIPLIERS: (
        "log_modulus",
        "angle",
        "damping_ratio",
        "frequency",
        "step_error",
        "likeness",
        "krein_signature",
    ),
}
OF_ENGINES = ("is_definite", "moving_modes", "closed_early", "interrupted")
EDGES, PARTS = ("lower", "upper"), ("step", "reduction", "mesh")
OF_BANDS: dict[str, Column[Band]] = {
    **{edge: (float, f"{edge}.crank_speed") for edge in EDGES},
    **{f"{e}_{part}_error": (float, f"{e}.{part}_error") for e in EDGES for part in PARTS},
    **{f"{edge}_open": (bool, f"{edge}.is_open") for edge in EDGES},
    "kind": (str, "kind"),
    "branches": (str, lambda band: " ".join(map(str, dict.fromkeys(band.branches)))),
    "order": (np.intp, "order"),
    "largest_growth_rate": (float, "largest_growth_rate"),
    "fastest_speed": (float, "fastest_speed"),
    "closing_damping_ratio": (float, "closing_damping_ratio"),
    "mismatch": (float, "mismatch"),
    "first_signature": (float, lambda band: band.signatures[0]),
    "second_signature": (float, lambda band: band.signatures[1]),
}
OF_CURVES: dict[str, Column[Sample]] = {
    "speed": (float, "crank_speed"),
    "growth_rate": (float, "growth_rate"),
}
OF_CHECKS: dict[str, Column[ExponentErrors]] = {
    "speed": (float, "crank_speed"),
    "reduction": (float, "reduction"),
    "mesh": (float, "mesh"),
    "theory": (float, "theory"),
    "growth": (float, "growth"),
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
    speeds, engines = request.crank_speeds, [each.engine for each in maps]
    solved = {
        # A speed may differ from the one asked for by round-off.
        (number, int(np.abs(speeds - each.crank_speed).argmin())): each
        for number, own in enumerate(maps)
        for each in own.speeds
    }
    tracked = {at: each for at, each in solved.items() if isinstance(each, TrackedSpeed)}
    shares = [each.harmonic_share for each in tracked.values()]
    harmonics = max((len(share) for share in shares), default=1)
    kept = max((share.shape[1] for share in shares), default=0)
    shape = len(maps), len(speeds), kept, harmonics
    variables: dict[str, Any] = {
        "unstable": (
            OVER_SPEEDS,
            filled(shape[:2], ((at, state_of(each)) for at, each in solved.items()), NOT_COMPUTED),
        ),
        "reason": (
            OVER_SPEEDS,
            filled(shape[:2], ((at, _reason(each)) for at, each in solved.items()), ""),
        ),
    }

    def add(name: str, over: tuple[str, ...]) -> None:
        values = ((at, np.transpose(getattr(each, name))) for at, each in tracked.items())
        variables[name] = over, filled(shape[: len(over)], values)

    for over, names in OF_SPEEDS.items():
        for name in names:
            add(name, over)
    if all(engine.rigid_modes for engine in engines):
        add("shaft_growth_rate", OVER_SPEEDS)
    add("harmonic_share", (*OVER_MULTIPLIERS, "harmonic"))
    bands = [(each.engine, band) for each in maps for band in each.bands]
    curve = [(each.engine, sample) for each in maps for sample in each.growth]
    checks = [(each.engine, errors) for each in maps for errors in each.errors]
    variables |= records("band", bands, OF_BANDS) | records("check", checks, OF_CHECKS)
    variables |= records("curve", curve, OF_CURVES)
    for name in OF_ENGINES:
        variables[name] = ("engine", [getattr(each, name) for each in maps])
    dataset = xr.Dataset(
        variables,
        coords={
            **engine_coordinates(engines),
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
        speed_unit=request.shown_unit,
    )


def state_of(speed: TrackedSpeed | NoEquilibrium) -> str:
    """What column ``unstable`` says of a speed."""
    if isinstance(speed, NoEquilibrium) or speed.buckled_angle is not None:
        return NO_EQUILIBRIUM
    return YES if speed.is_unstable else NO


def _reason(speed: TrackedSpeed | NoEquilibrium) -> str:
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
