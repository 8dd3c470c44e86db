"""Loads over time are left out of frozen positions and steady turns, and that is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech import InputError, ReferenceEngine, load_mechanism, moving_frequencies, stability
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.cli import app

MODELS = Path(__file__).parents[2] / "models"
LATE = """
[loads.late]
point = "B"
link = "coupler"
over = "time"
table = [["0 s", "0 N", "0 N"], ["1 s", "5 N", "0 N"]]
"""
ASKED = {
    "frequencies": "--angles 0,90 --speeds 0,10 --engine reference",
    "stability": "--speeds 20 --modes 2 --prestress axial",
    "campbell": "--speeds 5:6:1 --modes 2 --engine reference --prestress axial",
    "hammer": "--impact coupler:0.5 --averages 1 --duration 0.5s --damping-ratio 1%",
}


@pytest.mark.parametrize(
    "command",
    [
        pytest.param(command, marks=[pytest.mark.thorough] * (command in ("hammer", "stability")))
        for command in ASKED
    ],
)
def test_loads_over_time_that_are_left_out_are_told(command: str, tmp_path: Path) -> None:
    model = tmp_path / "late.toml"
    model.write_text((MODELS / "steel_fourbar.toml").read_text() + LATE)
    options = f"--elements 2 --no-plots --out {tmp_path / 'out'}"
    done = CliRunner().invoke(app, [command, str(model), *ASKED[command].split(), *options.split()])
    assert done.exit_code == 0, done.stderr
    told = [line for line in done.stderr.splitlines() if "left out here: late" in line]
    assert len(told) == 1
    (file,) = (tmp_path / "out").glob("*.nc")
    with xr.open_dataset(file) as dataset:
        assert dataset.attrs["loads_left_out"] == "late"


def test_the_shaft_is_an_argument() -> None:
    mechanism = load_mechanism(MODELS / "slider_crank_free_shaft.toml")
    made, free = (ReferenceEngine(mechanism, 2, shaft=shaft) for shaft in ("prescribed", "free"))
    asked = moving_frequencies(made, [0.5], [0.0], modes=2, shaft="free").dataset
    expected = moving_frequencies(free, [0.5], [0.0], modes=2).dataset
    xr.testing.assert_equal(asked["frequency"], expected["frequency"])
    held = moving_frequencies(free, [0.5], [0.0], modes=2, shaft="prescribed").dataset
    assert float(abs(held["frequency"] / expected["frequency"] - 1).max()) > 1e-3
    found = stability(made, [5.0], modes=1, prestress="axial", shaft="free").dataset
    assert "shaft_growth_rate" in found
    with pytest.raises(InputError, match="shaft must be"):
        moving_frequencies(made, [0.5], shaft="loose")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="shaft must be"):
        stability(made, [5.0], shaft="loose")  # type: ignore[arg-type]


def test_modes_that_creep_have_no_frequency_to_compare() -> None:
    engine = ReferenceEngine(
        load_mechanism(MODELS / "slider_crank_free_shaft.toml"), 2, shaft="free"
    )
    found = LinkageSolver(engine, "axial", 3).solved(5.0)
    assert (found.modes.exponent.imag == 0).any()
    assert np.isfinite(found.krein_signature).all()
