"""Runs of linkages with sliders, welds and rigid links: Exudyn against the reference's equations.

The reference's run is linear about the equilibrium, so that what both differ by falls with the
square of the displacement.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import flexmech

MODELS = Path(__file__).parents[2] / "models"


def run(name: str, speed: float, step: float) -> list[pd.DataFrame]:
    """Both responses over a tenth of a turn; their energy balances are checked."""
    mechanism = flexmech.load_mechanism(MODELS / f"{name}.toml")
    request = flexmech.ResponseRequest(
        flexmech.ConstantSpeed(speed), 0.1, step=step, start="equilibrium"
    )
    tables = []
    for engine in (
        flexmech.ReferenceEngine(mechanism, 6, "euler"),
        flexmech.ExudynEngine(mechanism, 6, "ancf"),
    ):
        found = flexmech.response(engine, request)
        assert float(found.dataset["energy_error"].max()) < 1e-4
        tables.append(found.tables()["response"])
    return tables


def gap(tables: list[pd.DataFrame], column: str, scale: str | None = None) -> float:
    first, second = (table[column].to_numpy() for table in tables)
    size = np.abs(tables[0][scale or column]).max()
    return float(np.abs(second - first).max() / size)


@pytest.mark.thorough
def test_a_slider_crank() -> None:
    tables = run("slider_crank", 15.0, 2e-5)
    assert gap(tables, "rod_mid_deflection_m") < 1e-4
    assert gap(tables, "driving_torque_Nm") < 1e-4
    for column in ("pin_A_x_N", "pin_A_y_N"):
        assert gap(tables, column, "pin_A_x_N") < 1e-4


@pytest.mark.thorough
def test_a_welded_beam() -> None:
    deflection = "long_tip_deflection_m"
    fast, slow = (run("rotating_l_beam", speed, 5e-4 / speed) for speed in (1.0, 0.5))
    for table in (*fast, *slow):  # the start is the steady state, which neither run leaves
        values = table[deflection].to_numpy()
        assert np.ptp(values) < 3e-5 * np.abs(values).max()
    assert gap(slow, deflection) < 1e-4
    # What is left is not linear: it falls with the displacement, as the square of the speed; at
    # last what the static solver leaves out of balance at the start shows.
    assert gap(fast, deflection) / gap(slow, deflection) > 3.0
    ratio = np.abs(fast[0][deflection]).max() / np.abs(slow[0][deflection]).max()
    assert ratio == pytest.approx(4.0, rel=0.1)
