"""Hand-made stability maps, without a linkage behind their numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech import ExudynEngine, ReferenceEngine, load_mechanism
from flexmech.analyses.stability.dataset import dataset_of
from flexmech.analyses.stability.engine_stability import (
    Band,
    BandEdge,
    EngineStability,
    ExponentErrors,
    NoEquilibrium,
    TrackedSpeed,
)
from flexmech.analyses.stability.growth import Sample
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.example_models import example_model
from flexmech.linear_system import Engine

SPEEDS = np.arange(80.0, 101.0, 1.0)
FREQUENCIES = (44.0, 49.0, 180.0, 205.0)
DECAY = 0.4
GROWTH = 3.7
HARMONICS = np.array([0.01, 0.02, 0.04, 0.1, 0.7, 0.08, 0.03, 0.015, 0.005])
# Speeds between those asked for at which growth is known: in a band, and beside one.
BETWEEN = (88.4, 92.5)
BUCKLED_FROM, REFUSED_FROM = 98.0, 100.0


def edge(speed: float, *, is_open: bool = False) -> BandEdge:
    errors = (np.nan, np.nan, np.nan) if is_open else (1e-4, 0.012, 0.003)
    return BandEdge(speed, *errors, is_open=is_open)


def band(**changed: Any) -> Band:
    known: dict[str, Any] = {
        "lower": edge(88.1),
        "upper": edge(89.3),
        "kind": "sum",
        "branches": (1, 3),
        "order": 11,
        "largest_growth_rate": GROWTH,
        "fastest_speed": 88.7,
        "closing_damping_ratio": 0.0034,
        "mismatch": 1e-3,
        "signatures": (0.9, -0.8),
    }
    return Band(**known | changed)


def bands() -> list[Band]:
    """A sum, a narrow principal one, and one without a name that goes on beyond the range."""
    narrow = {"lower": edge(84.0), "upper": edge(84.02), "fastest_speed": 84.01}
    beyond = {"lower": edge(97.0), "upper": edge(100.0, is_open=True), "fastest_speed": 99.0}
    return [
        band(kind="principal", branches=(2, 2), order=7, largest_growth_rate=0.3, **narrow),
        band(),
        band(
            kind="unnamed",
            branches=(),
            order=0,
            largest_growth_rate=8.0,
            closing_damping_ratio=np.nan,
            signatures=(np.nan, np.nan),
            **beyond,
        ),
    ]


def followed(speed: float, growth: float = -DECAY, **more: Any) -> TrackedSpeed:
    """Pairs of conjugate modes, of which the first grows or decays as said."""
    frequency = 2 * np.pi * np.repeat(FREQUENCIES, 2)
    decay = np.repeat(DECAY * np.arange(1.0, len(FREQUENCIES) + 1), 2)
    decay[:2] = -growth
    exponent = -decay + 1j * frequency * np.tile([1, -1], len(FREQUENCIES))
    count = len(exponent)
    known: dict[str, Any] = {
        "step_error": np.full(count, 3e-9),
        "likeness": np.ones(count),
        "harmonic_share": np.repeat(HARMONICS[:, None], count, axis=1),
        "krein_signature": 0.9 * np.tile([1.0, -1.0], len(FREQUENCIES)),
        "liouville_defect": 2e-13,
        "steps": 256,
    }
    return TrackedSpeed(speed, exponent, **known | more)


def growth_at(speed: float) -> float:
    """In the band of the sum, and towards the end."""
    if 88.1 < speed < 89.3:
        return GROWTH
    return 2.0 * (speed - 97.0) if speed > 97.0 else -DECAY


def solved(speed: float, **more: Any) -> TrackedSpeed | NoEquilibrium:
    if abs(speed) >= REFUSED_FROM:
        return NoEquilibrium(speed, f"no equilibrium at {speed:g} rad/s: the coupler buckles")
    buckled = np.radians(22.5) if abs(speed) >= BUCKLED_FROM else None
    return followed(speed, growth_at(abs(speed)), buckled_angle=buckled, **more)


def engine_stability(
    engine: Engine | None = None, speeds: np.ndarray = SPEEDS, **changed: Any
) -> EngineStability:
    if engine is None:
        engine = ReferenceEngine(load_mechanism(example_model("aluminium_fourbar")))
    known: dict[str, Any] = {
        "speeds": [solved(speed) for speed in speeds.tolist()],
        "bands": bands(),
        "growth": [Sample(w, growth_at(w), growth_at(w)) for w in BETWEEN],
        "errors": [
            ExponentErrors(20.0, 2e-5, 1e-4, 5e-5, 1e-6),
            ExponentErrors(90.0, 2e-5, 4e-4, 7e-4, 2e-6),
        ],
        "is_definite": True,
        "moving_modes": 9,
        "closed_early": 3,
        "interrupted": False,
    }
    return EngineStability(engine=engine, **known | changed)


def both_engines() -> list[EngineStability]:
    """Exudyn's bands are a little higher, and it has no principal one."""
    mechanism = load_mechanism(example_model("aluminium_fourbar"))
    moved = [
        band(lower=edge(88.13), upper=edge(89.32)),
        band(kind="difference", branches=(3, 4), order=2, lower=edge(94.0), upper=edge(95.0)),
    ]
    return [
        engine_stability(ReferenceEngine(mechanism)),
        engine_stability(ExudynEngine(mechanism), bands=moved, is_definite=False),
    ]


def request(**changed: Any) -> StabilityRequest:
    return StabilityRequest(**{"crank_speeds": SPEEDS, "modes": len(FREQUENCIES)} | changed)


def stability_dataset(
    *, engines: int = 1, against: bool = True, speed_unit: str = "rad/s"
) -> xr.Dataset:
    """As a map's, with moving frequencies and, on demand, a second parameter."""
    maps = both_engines()[:engines]
    dataset = dataset_of(maps, request(shown_unit=speed_unit))
    moving = np.linspace(SPEEDS[0], SPEEDS[-1], 5)
    mean = np.broadcast_to(FREQUENCIES, (5, len(FREQUENCIES)))
    over = ("moving_speed", "branch")
    dataset = dataset.assign(
        lowest_frequency=(over, 0.9 * mean),
        mean_frequency=(over, mean),
        highest_frequency=(over, 1.1 * mean),
    ).assign_coords(moving_speed=moving, branch=np.arange(1, len(FREQUENCIES) + 1))
    if not against:
        return dataset
    ratio = np.linspace(0.0, 0.02, 5)
    rate = dataset["growth_rate"].values[:, None] - 300.0 * ratio[:, None]
    state = np.where(rate > 0, "yes", "no").astype(object)
    without = (dataset["unstable"] == "no equilibrium").values[:, None]
    state[np.broadcast_to(without, rate.shape)] = "no equilibrium"
    over_both = ("engine", "parameter", "crank_speed")
    attributes = {"units": "1", "long_name": "damping ratio"}
    return (
        dataset.assign(
            against_growth_rate=(over_both, rate), against_unstable=(over_both, state.astype(str))
        )
        .assign_coords(parameter=("parameter", ratio, attributes))
        .assign_attrs(
            against="damping-ratio", against_column="damping_ratio", interrupted_against=0
        )
    )
