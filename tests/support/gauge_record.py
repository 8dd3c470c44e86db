"""A record of a strain gauge on a damped four-bar as if it were measured."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.signal import lfilter

from flexmech import (
    ConstantSpeed,
    MeasuredQuantity,
    MeasuredRecord,
    Mechanism,
    ReferenceEngine,
    example_model,
    load_mechanism,
    response,
)
from flexmech.analyses import ResponseRequest

ALUMINIUM = load_mechanism(example_model("aluminium_fourbar"))
ENGINE = ReferenceEngine(ALUMINIUM, 2)
"""Without damping, as its model file says."""
SPEED, DAMPING_TIME = 20.0, 7e-5


def damped(mechanism: Mechanism, **times: float) -> Mechanism:
    """Links with Kelvin-Voigt damping times in s; of all links that of ``every``."""
    sections = {
        name: section.with_damping_time(times.get(name, times.get("every", 0.0)))
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


@cache
def history() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, crank angle and coupler strain of three turns with 180 samples each."""
    engine = ENGINE.with_(mechanism=damped(ALUMINIUM, every=DAMPING_TIME))
    request = ResponseRequest(ConstantSpeed(SPEED), revolutions=3.0, samples=180, start="rigid")
    data = response(engine, request).dataset.isel(engine=0)
    strain = data["strain"].sel(link="coupler").values
    return data["time"].values, data["crank_angle"].values, strain


def gauge_record(
    seed: int,
    first: int = 0,
    *,
    angle: bool = True,
    noise: float = 0.02,
    memory: float = 0.0,
    factor: float = 1.0,
    offset: float = 0.0,
) -> MeasuredRecord:
    """Record of a strain gauge from a sample on; its noise is correlated over samples."""
    time, turned, strain = (values[first:] for values in history())
    white = np.random.default_rng(seed).standard_normal(len(strain))
    noisy = lfilter([np.sqrt(1 - memory**2)], [1.0, -memory], white) * noise * strain.std()
    quantities = [MeasuredQuantity("strain", "", factor * (strain + noisy) + offset)]
    if angle:
        quantities.append(MeasuredQuantity("crank_angle", "rad", np.mod(turned, 2 * np.pi)))
    return MeasuredRecord("time", time - time[0], tuple(quantities), "strain.csv")
