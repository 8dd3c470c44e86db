"""``flexmech moisture``: its tables against the series, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.errors import InputError
from flexmech.hygrothermal import link_uptake
from flexmech.materials.moisture import slab_uptake
from flexmech.modelfile import mechanism_from_toml
from tests.unit.test_cli_state import MODEL

pytestmark = pytest.mark.usefixtures("rough_pictures")

DAY = 86400.0
HUMID = ["--relative-humidity", "85", "--time", "20 day"]


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.fixture
def model(tmp_path: Path) -> Path:
    file = tmp_path / "wet.toml"
    file.write_text(MODEL)
    return file


def test_tables_and_picture(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, printed, errors = run("moisture", model, *HUMID, "--temperature", "40", "--out", out)
    assert (code, errors) == (0, "")
    assert "take up no water: crank\n" in printed
    assert (out / "moisture.png").is_file()
    uptake = pd.read_csv(out / "moisture_uptake.csv")
    assert uptake["link"].unique().tolist() == ["coupler", "rocker"]
    assert not uptake.duplicated(["link", "time_s"]).any()
    # Without an activation energy the diffusivity is that of the model file at 40 degC too.
    for link, faces in (("coupler", "lower"), ("rocker", "both")):
        rows = uptake[uptake["link"] == link]
        exact = slab_uptake(rows["time_s"].to_numpy(), 6e-3, 6e-13, faces=faces)
        assert rows["uptake"].to_numpy() == pytest.approx(exact, abs=1e-4)
        assert rows["moisture_percent"].to_numpy() == pytest.approx(7 * 0.85 * exact, abs=1e-3)
        assert rows["shen_springer_uptake"].to_numpy()[1:] == pytest.approx(exact[1:], abs=0.04)
    profile = pd.read_csv(out / "moisture_profile.csv")
    last = profile[(profile["link"] == "coupler") & (profile["time_s"] == 20 * DAY)]
    assert last["place_m"].abs().max() < 3e-3
    assert last["moisture_percent"].iloc[0] == pytest.approx(5.95, abs=0.03)
    assert np.all(np.diff(last["moisture_percent"]) < 1e-9)


def test_one_link_without_pictures(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    code, printed, _ = run(
        "moisture", model, *HUMID, "--link", "rocker", "--no-plots", "--out", out
    )
    assert code == 0
    # The coupler was not asked for; that is no reason to call it dry.
    assert "take up no water: crank\n" in printed
    assert sorted(file.name for file in out.iterdir()) == [
        "moisture_profile.csv",
        "moisture_uptake.csv",
    ]
    assert set(pd.read_csv(out / "moisture_uptake.csv")["link"]) == {"rocker"}


def test_times_to_saturation_of_a_bar_by_the_product() -> None:
    mechanism = mechanism_from_toml(
        MODEL.replace('exposed_faces = "lower"', "exposed_sides = true")
    )
    wide = link_uptake(mechanism, "coupler", 1.0, 293.15, np.array([0.0, DAY]))
    slab = link_uptake(mechanism, "rocker", 1.0, 293.15, np.array([0.0, DAY]))
    assert wide.laws() is None
    assert slab.laws() is not None
    from flexmech.materials.moisture import bar_uptake

    for share, time in zip((0.5, 0.9), wide.times_to((0.5, 0.9)), strict=True):
        found = bar_uptake(np.array([time]), 6e-3, 10e-3, 6e-13, 6e-13)[0]
        assert found == pytest.approx(share, abs=1e-3)
    assert wide.times_to((0.5,))[0] < slab.times_to((0.5,))[0]


def test_shares_must_be_fractions() -> None:
    mechanism = mechanism_from_toml(MODEL)
    uptake = link_uptake(mechanism, "coupler", 1.0, 293.15, np.array([0.0, DAY]))
    with pytest.raises(InputError, match="between 0 and 1"):
        uptake.times_to((1.0,))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--relative-humidity", "120", "--time", "1 day"], "--relative-humidity"),
        (["--relative-humidity", "500 ppm", "--time", "1 day"], "--relative-humidity: got '500 p"),
        (["--relative-humidity", "85 %%", "--time", "1 day"], "--relative-humidity: got '85 %'"),
        (["--relative-humidity", "0", "--time", "1 day"], "relative_humidity must lie above 0"),
        (["--relative-humidity", "85", "--time", "0 s"], "--time: must be positive"),
        ([*HUMID, "--temperature", "-300"], "--temperature"),
        ([*HUMID, "--temperature", "80 mm"], "--temperature"),
        ([*HUMID, "--link", "wheel"], "--link: there is no link 'wheel'"),
        ([*HUMID, "--link", "crank"], "takes up no water"),
    ],
)
def test_refusals(model: Path, tmp_path: Path, options: list[str], said: str) -> None:
    out = tmp_path / "none"
    code, printed, errors = run("moisture", model, *options, "--out", out)
    assert (code, printed) == (2, "")
    assert said in errors
    assert len(errors.strip().splitlines()) == 1
    assert not out.exists()


def test_metal_mechanisms_take_up_nothing(tmp_path: Path) -> None:
    steel = Path(__file__).parents[2] / "models" / "steel_fourbar.toml"
    code, _, errors = run("moisture", steel, *HUMID, "--out", tmp_path / "none")
    assert code == 2
    assert "no link takes up water; add equilibrium_moisture" in errors
