"""V16 of the validation numbers: the flexible slider-crank of Wu and Tiso, which stops with a blow.

The crank angle is ``3 pi t^2 / 50`` until 5 s, a table of six rows; then the crank is held, from
1.885 rad/s. Its tip is that of J. Sonneville's solution.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    ExudynEngine,
    InputError,
    ReferenceEngine,
    ResponseRequest,
    TableDrive,
    load_mechanism,
    response,
)
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine

MECHANISM = load_mechanism(Path(__file__).parents[1] / "data" / "wu_tiso_slider_crank.toml")
LENGTH = 10.0
TIPS = {2.5: (3.960155, 9.182256), 5.0: (-0.405688, -9.990354)}


def law() -> TableDrive:
    assert isinstance(MECHANISM.drive, TableDrive)
    return MECHANISM.drive


def run(engine: Engine, drive: TableDrive, step: float | None = None) -> xr.Dataset:
    return response(engine, ResponseRequest(drive, samples=600, step=step)).dataset.isel(engine=0)


def tip(data: xr.Dataset, time: float) -> FloatArray:
    """Where the crank's end is, (2,) in m."""
    place = data["rigid_position"] + data["displacement"]
    end = place.sel(link="crank").isel(station=-1)
    return np.asarray(end.sel(time=time, method="nearest").values)


def test_the_law_is_a_table() -> None:
    time = np.linspace(0.0, 5.0, 101)[:-1]
    np.testing.assert_allclose(law().crank_angle(time), 3 * np.pi * time**2 / 50, atol=1e-12)
    np.testing.assert_allclose(law().crank_acceleration(time), 3 * np.pi / 25, rtol=1e-10)
    assert law().crank_speed([5.0, 5.5]).tolist() == [0.0, 0.0]
    assert law().law.blow == pytest.approx((5.0, -0.6 * np.pi))


def test_exudyn_finds_the_tip() -> None:
    """To 1e-4 of the crank length, where 1e-3 is asked for."""
    found = run(ExudynEngine(MECHANISM, 8), law())
    for time, place in TIPS.items():
        assert np.linalg.norm(tip(found, time) - place) < 1e-4 * LENGTH


def test_the_reference_refuses_the_blow_and_is_near_until_it() -> None:
    """Its equations are linear in the bend but for the tension: off by 2e-4 of the length."""
    engine = ReferenceEngine(MECHANISM, 8)
    with pytest.raises(InputError, match=r"jumps by -1\.885 rad/s at 5 s"):
        run(engine, law())
    found = run(engine, replace(law(), ends="free", dwell=0.0))
    for time, place in TIPS.items():
        assert np.linalg.norm(tip(found, time) - place) < 3e-4 * LENGTH


@pytest.mark.thorough
def test_step_and_mesh_change_little_after_the_blow() -> None:
    """Within 1e-3 of the crank length also where all modes ring, by both of Exudyn's elements."""
    usual = run(ExudynEngine(MECHANISM, 8), law())
    others = [
        run(ExudynEngine(MECHANISM, 16), law(), 2.5e-3),
        run(ExudynEngine(MECHANISM, 16, "geometrically-exact"), law(), 2.5e-3),
    ]
    for time in (5.1, 5.25, 5.5, 5.75, 6.0):
        for other in others:
            assert np.linalg.norm(tip(other, time) - tip(usual, time)) < 1e-3 * LENGTH
