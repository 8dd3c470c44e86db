"""Records of a damped four-bar as if they were measured, for tests of comparisons."""

from __future__ import annotations

from functools import cache

import numpy as np

import flexmech
from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.linear_system import Engine
from flexmech.types import FloatArray

SPEED = 20.0
RATIO = 0.01


@cache
def undamped() -> Engine:
    """The model as its file says: no damping."""
    return flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"), 2)


@cache
def damped() -> Engine:
    return with_damping_ratio(undamped(), RATIO)


def damping_time() -> float:
    """Kelvin-Voigt time of the damped linkage in s."""
    return damped().mechanism.sections["coupler"].damping.bending


@cache
def history(turns: float = 3.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Time, crank angle and coupler strain of a run with 180 samples a turn."""
    request = flexmech.ResponseRequest(flexmech.CrankDrive(SPEED), revolutions=turns, samples=180)
    data = flexmech.response(damped(), request).dataset.isel(engine=0)
    strain = data["strain"].sel(link="coupler").values
    return data["time"].values, data["crank_angle"].values, strain


def noisy(seed: int, part: float = 0.02, first: int = 0) -> tuple[FloatArray, ...]:
    """The same from a sample on, with white noise of a part of its standard deviation."""
    time, angle, strain = (values[first:] for values in history())
    noise = part * strain.std() * np.random.default_rng(seed).standard_normal(len(time))
    return time - time[0], angle, strain + noise


def strain_record(
    seed: int = 1, part: float = 0.02, first: int = 0, *, with_angle: bool = True
) -> flexmech.MeasuredRecord:
    """A record of a strain gauge at the coupler's middle."""
    time, angle, strain = noisy(seed, part, first)
    column = flexmech.MeasuredQuantity("crank_angle", "rad", np.mod(angle, 2 * np.pi))
    return flexmech.MeasuredRecord(
        "time",
        time,
        (flexmech.MeasuredQuantity("strain", "", strain), *((column,) if with_angle else ())),
        "strain.csv",
    )
