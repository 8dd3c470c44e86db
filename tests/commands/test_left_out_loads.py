"""Loads over time are left out of frozen positions and steady turns; the shaft is an argument."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
import xarray as xr

from flexmech import InputError, ReferenceEngine, load_mechanism, moving_frequencies, stability
from tests.support.command import MODELS, Ended

LATE = """
[loads.late]
point = "B"
link = "coupler"
over = "time"
table = [["0 s", "0 N", "0 N"], ["1 s", "5 N", "0 N"]]
"""
ASKED = {
    "frequencies": "--angles 0,90 --speeds 0,10 --engine reference",
    "campbell": "--speeds 5:6:1 --modes 2 --engine reference --prestress axial",
}


@pytest.mark.parametrize("name", ASKED)
def test_loads_over_time_that_are_left_out_are_told(name: str, tmp_path: Path, command) -> None:  # type: ignore[no-untyped-def]
    model = tmp_path / "late.toml"
    model.write_text((MODELS / "steel_fourbar.toml").read_text() + LATE)
    words = (*shlex.split(ASKED[name]), "--elements", "2", "--no-plots")
    ended: Ended = command(name, model, *words)
    assert ended.exit_code == 0, ended.stderr
    told = [line for line in ended.stderr.splitlines() if "left out here: late" in line]
    assert len(told) == 1
    (file,) = ended.folder.glob("*.nc")
    with xr.open_dataset(file) as dataset:
        assert dataset.attrs["loads_left_out"] == "late"


def test_the_shaft_is_an_argument() -> None:
    mechanism = load_mechanism(MODELS / "slider_crank_free_shaft.toml")
    made, free = (ReferenceEngine(mechanism, 2, shaft=shaft) for shaft in ("prescribed", "free"))
    asked = moving_frequencies(made, [0.5], [0.0], modes=2, shaft="free").dataset
    own = moving_frequencies(free, [0.5], [0.0], modes=2).dataset
    xr.testing.assert_equal(asked["frequency"], own["frequency"])
    held = moving_frequencies(free, [0.5], [0.0], modes=2, shaft="prescribed").dataset
    assert float(abs(held["frequency"] / own["frequency"] - 1).max()) > 1e-3
    found = stability(made, [5.0], modes=1, prestress="axial", shaft="free").dataset
    assert "shaft_growth_rate" in found
    with pytest.raises(InputError, match="shaft must be"):
        moving_frequencies(made, [0.5], shaft="loose")  # type: ignore[arg-type]
