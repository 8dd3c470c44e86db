"""Natural frequencies against crank angle, held to golden arrays.

Regenerate after an intended change with ``pytest tests/regression --force-regen``, look at
the difference, and say in the commit why it moved.
"""

import numpy as np
import pytest

from flexmech import (
    Exposure,
    ExudynEngine,
    HygrothermalState,
    ReferenceEngine,
    load_mechanism,
    mechanism_in_state,
    moving_frequencies,
)

ANGLES = np.radians(np.arange(0, 361, 15))


@pytest.mark.parametrize("name", ["aluminium", "steel"])
@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize(
    "prestress", ["none", pytest.param("axial", marks=pytest.mark.thorough), "equilibrium"]
)
def test_frequency_against_crank_angle(mechanisms, name, engine, prestress, num_regression):
    result = moving_frequencies(
        engine(mechanisms[name], 8), ANGLES, [0.0, 20.0], modes=4, prestress=prestress
    )
    num_regression.check(columns_of(result), default_tolerance={"rtol": 1e-6, "atol": 0.0})


@pytest.mark.parametrize("element", ["euler", "timoshenko", "reddy"])
def test_composite_frequency_against_crank_angle(models, element, num_regression):
    """Thick links, one of them unsymmetric; damping by modal strain energy besides."""
    engine = ReferenceEngine(load_mechanism(models / "composite_fourbar.toml"), 4, element)
    result = moving_frequencies(engine, ANGLES[::3], [100.0], modes=2)
    columns = columns_of(result) | columns_of(result, "strain_energy_damping")
    num_regression.check(columns, default_tolerance={"rtol": 1e-6, "atol": 0.0})


@pytest.mark.parametrize("state", ["uniform", "exposed"])
def test_moist_frequency_against_crank_angle(models, state, num_regression):
    """Carbon and epoxy, hot and moist; exposed, its rocker is wet from below and bent."""
    moist = {
        "uniform": HygrothermalState(60.0, 0.04),
        "exposed": Exposure(60.0, 0.85, 5 * 86400.0),
    }[state]
    dry = load_mechanism(models / "moist_composite_fourbar.toml")
    engine = ReferenceEngine(mechanism_in_state(dry, moist), 4, "timoshenko")
    result = moving_frequencies(engine, ANGLES[::3], [20.0], modes=3)
    num_regression.check(columns_of(result), default_tolerance={"rtol": 1e-5, "atol": 0.0})


def columns_of(result, variable="frequency"):
    values = result.dataset[variable].isel(engine=0)
    prefix = "" if variable == "frequency" else f"{variable} of "
    return {
        f"{prefix}mode {int(mode)} at {speed:g} rad_s": values.sel(
            crank_speed=speed, mode=mode
        ).values
        for speed in values["crank_speed"].values
        for mode in values["mode"].values
    }


@pytest.mark.parametrize("name", ["aluminium", "steel"])
def test_branches_against_crank_angle(mechanisms, name, num_regression):
    angles = np.radians(np.arange(0, 361, 5))
    dataset = moving_frequencies(ReferenceEngine(mechanisms[name], 8), angles, [20.0]).dataset
    columns = {
        f"{variable} {mode}": dataset[variable].isel(engine=0, crank_speed=0).sel(mode=mode).values
        for variable in ("branch_of_mode", "veering")
        for mode in dataset["mode"].values
    }
    num_regression.check({key: value.astype(float) for key, value in columns.items()})
