"""Moisture uptake, as a result and from ``flexmech moisture``; against series, and refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

from flexmech import InputError, Mechanism, MoistureUptake, load_mechanism, moisture_uptake
from flexmech.analyses.digits import percent
from flexmech.cli import app
from flexmech.materials.moisture import Faces
from flexmech.modelfile import mechanism_from_toml
from tests.support.slab_series import bar_uptake, slab_uptake
from tests.unit.test_cli_state import MODEL

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
DAY = 86400.0
HUMID = ["--relative-humidity", "85", "--time", "20 day"]


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def with_sides() -> Mechanism:
    """Water enters the coupler through its sides too."""
    return mechanism_from_toml(MODEL.replace('exposed_faces = "lower"', "exposed_sides = true"))


@pytest.fixture
def model(tmp_path: Path) -> Path:
    file = tmp_path / "wet.toml"
    file.write_text(MODEL)
    return file


def test_tables_and_picture(model: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    options = (*HUMID, "--temperature", "40", "--details", "--out", out)
    code, printed, errors = run("moisture", model, *options)
    assert (code, errors) == (0, "")
    lines = printed.splitlines()
    assert lines[0].startswith("After 20 d the rocker has ")
    assert lines[1].startswith("The coupler has 99 % of it after ")
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
    options = ("--link", "rocker", "--no-plots", "--details", "--out", out)
    code, printed, _ = run("moisture", model, *HUMID, *options)
    assert code == 0
    # The coupler was not asked for; that is no reason to call it dry.
    assert "take up no water: crank\n" in printed
    assert sorted(file.name for file in out.iterdir()) == [
        "moisture.nc",
        "moisture_profile.csv",
        "moisture_uptake.csv",
        "summary.txt",
    ]
    assert set(pd.read_csv(out / "moisture_uptake.csv")["link"]) == {"rocker"}


@pytest.fixture(scope="module")
def wet_sides() -> MoistureUptake:
    return moisture_uptake(with_sides(), 1.0, DAY, 293.15)


def test_times_to_saturation_of_a_bar_by_the_product(wet_sides: MoistureUptake) -> None:
    data = wet_sides.dataset
    wide, slab = (data.sel(link=link) for link in ("coupler", "rocker"))
    laws = ["short_time_uptake", "shen_springer_uptake"]
    assert wide[laws].to_array().isnull().all()
    assert slab[laws].to_array().notnull().all()
    for share in (0.5, 0.9):
        time = wide["time_to_share"].sel(share=share).item()
        found = bar_uptake(np.array([time]), 6e-3, 10e-3, 6e-13, 6e-13)[0]
        assert found == pytest.approx(share, abs=1e-3)
    assert (wide["time_to_share"] < slab["time_to_share"]).all()


def test_water_of_a_neat_resin_is_its_moisture(model: Path) -> None:
    data = moisture_uptake(load_mechanism(model), 0.85, 20 * DAY).dataset
    assert data["water"].values == pytest.approx(data["moisture"].values)
    assert data.attrs["temperature"] == load_mechanism(model).reference_temperature
    assert data["mass_balance_error"].values.max() < 1e-12


def test_a_user_s_script(tmp_path: Path) -> None:
    """Ten lines with public names alone."""
    script = f"""
import flexmech
mechanism = flexmech.load_mechanism({str(MODELS / "moist_composite_fourbar.toml")!r})
found = flexmech.moisture_uptake(mechanism, 0.85, 30 * 86400, temperature=353.15)
days = found.dataset["time_to_share"].sel(share=0.9) / 86400
figure = found.plot()
files = found.save({str(tmp_path)!r}, figures=True)
loaded = flexmech.MoistureUptake.load(files[2])
print(loaded.summary())
"""
    names: dict[str, object] = {}
    exec(script, names)
    assert names["days"].values.round(2).tolist() == [22.56, 22.56, 90.24]  # type: ignore[attr-defined]
    assert isinstance(names["figure"], Figure)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(MoistureUptake.files)


def test_a_loaded_result_says_the_same(wet_sides: MoistureUptake, tmp_path: Path) -> None:
    """Links with fewer cells than others are filled up with places that are not numbers."""
    result = wet_sides
    cells = result.dataset["place"].notnull().sum("cell").values
    assert cells[0] < cells[1]
    result.save(tmp_path)
    loaded = MoistureUptake.load(tmp_path / "moisture.nc")
    assert loaded.dataset.identical(result.dataset)
    for name, variable in result.dataset.variables.items():
        assert loaded.dataset[name].dtype.kind == variable.dtype.kind, name
    assert str(loaded.summary()) == str(result.summary())
    for name, table in result.tables().items():
        pd.testing.assert_frame_equal(loaded.tables()[name], table)
    profile = result.tables()["moisture_profile"]
    assert profile.groupby("link").size().tolist() == (5 * cells).tolist()


def test_plots_into_axes_of_the_user(model: Path) -> None:
    found = moisture_uptake(load_mechanism(model), 0.85, 20 * DAY)
    mine = Figure()
    axes = mine.subplots(2, 2)
    assert found.plot(ax=axes) is mine
    assert all(panel.lines for panel in axes.flat)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--relative-humidity", "120", "--time", "1 day"], "--relative-humidity"),
        (["--relative-humidity", "500 ppm", "--time", "1 day"], "--relative-humidity: got '500 p"),
        (["--relative-humidity", "85 %%", "--time", "1 day"], "--relative-humidity: got '85 %'"),
        (["--relative-humidity", "0", "--time", "1 day"], "relative_humidity must be above 0"),
        (["--relative-humidity", "85", "--time", "0 s"], "time must be positive"),
        ([*HUMID, "--temperature", "-300"], "--temperature"),
        ([*HUMID, "--temperature", "80 mm"], "--temperature"),
        ([*HUMID, "--link", "wheel"], "link: there is no link 'wheel'"),
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
    code, _, errors = run(
        "moisture", MODELS / "steel_fourbar.toml", *HUMID, "--out", tmp_path / "none"
    )
    assert code == 2
    assert "links: none takes up water; add equilibrium_moisture" in errors


def test_what_python_refuses(model: Path) -> None:
    mechanism = load_mechanism(model)
    for arguments, said in (
        ((mechanism, 85, DAY), "relative_humidity must be above 0 and at most 1, got 85"),
        ((mechanism, "85 %", DAY), "relative_humidity must be a number"),
        ((mechanism, 0.85, "20 day"), "time must be a number of s"),
        ((mechanism, 0.85, DAY, -5.0), "temperature must be positive"),
        ((str(model), 0.85, DAY), "read the file first: flexmech.load_mechanism"),
    ):
        with pytest.raises(InputError, match=said):
            moisture_uptake(*arguments)  # type: ignore[arg-type]


def test_the_answer_is_the_water_in_the_end_and_when_a_link_is_saturated(model: Path) -> None:
    found = moisture_uptake(load_mechanism(model), 0.85, 20 * DAY)
    numbers = {(one.name, one.of): one for one in found.summary().numbers}
    time = numbers["time_to_saturation", "coupler"]
    share = slab_uptake(np.array([time.value * DAY]), 6e-3, 6e-13, faces="lower")[0]
    assert share == pytest.approx(0.99, abs=1e-6)
    water = numbers["water", "rocker"].value
    assert (
        f"{found.dataset['uptake'].sel(link='rocker').values[-1] * 100:.2f} %"
        in (found.summary().answer[0])
    )
    assert water == pytest.approx(100 * found.dataset["water"].sel(link="rocker").values[-1])


@pytest.mark.parametrize(("faces", "width"), [("both", None), ("lower", None), ("both", 10e-3)])
def test_estimated_errors_of_uptake_are_those_against_the_series(
    faces: Faces, width: float | None
) -> None:
    """Never less than half of what the uptake is off by, and no more than ten times as much."""
    mechanism = with_sides() if width else mechanism_from_toml(MODEL)
    link = "coupler" if width or faces == "lower" else "rocker"
    own = moisture_uptake(mechanism, 1.0, 20 * DAY, 293.15, link).dataset.sel(link=link)
    times = own["time"].values
    exact = (
        bar_uptake(times, 6e-3, width, 6e-13, 6e-13)
        if width
        else slab_uptake(times, 6e-3, 6e-13, faces=faces)
    )
    actual = np.abs(own["uptake"].values - exact)[1:]
    estimated = own["uptake_error"].values[1:]
    assert np.all(actual < 2 * np.maximum(estimated, 1e-7))
    assert estimated.max() < 3 * actual.max()


def test_estimated_errors_of_times_to_shares_are_those_against_the_product() -> None:
    """By the volumes in a bar; by the series in a slab, where round-off is left alone."""
    data = moisture_uptake(with_sides(), 1.0, DAY, 293.15).dataset
    bar, slab = (data.sel(link=link) for link in ("coupler", "rocker"))
    assert (slab["time_to_share_error"] < 1e-11 * slab["time_to_share"]).all()
    times, errors = bar["time_to_share"].values, bar["time_to_share_error"].values
    for time, error, share in zip(times, errors, bar["share"].values, strict=True):
        around = bar_uptake(
            np.array([time - 2 * error, time + 2 * error]), 6e-3, 10e-3, *[6e-13] * 2
        )
        assert around[0] < share < around[1]
        assert error < 0.01 * time


def test_the_trust_line_is_the_greatest_error_of_what_is_printed(model: Path) -> None:
    data = moisture_uptake(load_mechanism(model), 0.85, 20 * DAY).dataset
    end = data.isel(time=-1)
    worst = float((end["uptake_error"] / end["uptake"]).max())
    said = MoistureUptake(data).summary()
    assert f"numbers are known to {percent(worst)}, estimated by cells" in said.trust
    for number in said.numbers:
        assert 0 < number.error < 1e-3 * number.value
    wrong = data.assign(uptake_error=data["uptake_error"] + 0.01)
    coarse = MoistureUptake(wrong).summary()
    assert coarse.table is not None
    assert said.table is not None
    for cells, before in zip(coarse.table.groups[0], said.table.groups[0], strict=True):
        assert all(
            len(cell) < len(known) for cell, known in zip(cells[1:4], before[1:4], strict=True)
        )
        assert cells[4:] == before[4:]
    assert percent(float(((wrong["uptake_error"] / wrong["uptake"]).isel(time=-1)).max())) in (
        coarse.trust
    )
    slow = data.assign(time_to_share_error=0.03 * data["time_to_share"])
    assert "known to 3 %" in MoistureUptake(slow).summary().trust


def test_a_result_of_before_errors_were_estimated_says_that_there_are_none(model: Path) -> None:
    data = moisture_uptake(load_mechanism(model), 0.85, 20 * DAY).dataset
    before = MoistureUptake(data.drop_vars(["uptake_error", "time_to_share_error"])).summary()
    assert before.trust == "errors of the numbers are not estimated"
    assert all(np.isnan(number.error) for number in before.numbers)
    assert before.answer == MoistureUptake(data).summary().answer
