"""What NetCDF files say of themselves, and what the file of a response holds."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import flexmech
from flexmech.analyses.response.dataset import ENERGIES, MOST_FRAMES
from flexmech.cli import app
from flexmech.modelfile import mechanism_from_toml, template
from flexmech.plots.animation import MOST_FRAMES as MOST_PICTURES
from flexmech.plots.animation import EnlargedMotion

MODELS = Path(__file__).parents[2] / "models"
STEEL = MODELS / "steel_fourbar.toml"
STAMP = "%Y-%m-%dT%H:%M:%SZ"
# Of the whole: a turn and a half is two thirds last turn.
SIZE_OF_REST = 0.4


@pytest.fixture(scope="module")
def turns() -> flexmech.Response:
    """A turn and a half, at a number of samples that frames cannot divide."""
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(STEEL), 2)
    drive = flexmech.ConstantSpeed(20.0)
    request = flexmech.ResponseRequest(drive, 1.5, samples=500, modes=1, step=5e-4)
    return flexmech.response(engine, request)


@pytest.fixture(scope="module")
def frequencies() -> flexmech.MovingFrequencies:
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(STEEL), 2)
    return flexmech.moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1)


def attributes(file: Path) -> dict[str, Any]:
    with xr.open_dataset(file, engine="h5netcdf") as dataset:
        return dict(dataset.attrs)


def nc_of(files: list[Path]) -> Path:
    return next(file for file in files if file.suffix == ".nc")


# --- attributes -----------------------------------------------------------------------------


def test_files_say_what_they_are(frequencies: flexmech.MovingFrequencies, tmp_path: Path) -> None:
    before = datetime.now(UTC).replace(microsecond=0)
    found = attributes(nc_of(frequencies.save(tmp_path)))
    assert re.fullmatch(r"CF-1\.\d+", found["Conventions"])
    assert found["title"] == "moving natural frequencies of steel four-bar"
    date = datetime.strptime(found["date"], STAMP).replace(tzinfo=UTC)
    assert before <= date <= datetime.now(UTC) + timedelta(seconds=1)
    assert found["model_text"] == STEEL.read_text(encoding="utf-8")
    assert "command_line" not in found


def test_the_date_can_be_set_for_files_that_are_the_same(
    frequencies: flexmech.MovingFrequencies, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    one, other = (nc_of(frequencies.save(tmp_path / name)) for name in ("one", "other"))
    assert attributes(one)["date"] == "1970-01-02T00:00:00Z"
    assert attributes(one) == attributes(other)


def test_a_loaded_result_keeps_where_it_came_from(
    frequencies: flexmech.MovingFrequencies, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    first = nc_of(frequencies.save(tmp_path / "first", command_line="flexmech frequencies x"))
    loaded = flexmech.MovingFrequencies.load(first)
    xr.testing.assert_identical(loaded.dataset, frequencies.dataset)
    assert loaded.stored_as["command_line"] == "flexmech frequencies x"
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert attributes(nc_of(loaded.save(tmp_path / "again"))) == attributes(first)


def test_a_command_is_named_as_a_shell_takes_it(tmp_path: Path) -> None:
    out = tmp_path / "with blank"
    command = ["check", str(STEEL), "--no-plots", "--out", str(out)]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    found = attributes(out / "check.nc")
    assert found["command_line"] == f"flexmech check {STEEL} --no-plots --out '{out}'"
    assert found["title"] == "check of steel four-bar"


def test_long_model_files_are_kept_whole(tmp_path: Path) -> None:
    """An attribute of HDF5 by itself holds 64 KB."""
    text = template("four-bar") + "# Größe\n" * 20_000
    mechanism = mechanism_from_toml(text)
    engine = flexmech.ReferenceEngine(mechanism, 2)
    result = flexmech.moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1)
    assert attributes(nc_of(result.save(tmp_path)))["model_text"] == text
    assert mechanism == replace(mechanism, provenance=replace(mechanism.provenance, text=""))


# --- what a response's file holds -----------------------------------------------------------


@pytest.mark.thorough
def test_a_stored_run_holds_what_is_drawn(turns: flexmech.Response, tmp_path: Path) -> None:
    file, whole = (nc_of(turns.save(tmp_path / store, store=store)) for store in ("needed", "all"))
    assert file.stat().st_size < SIZE_OF_REST * whole.stat().st_size
    xr.testing.assert_identical(flexmech.Response.load(whole).dataset, turns.dataset)
    loaded = flexmech.Response.load(file)
    data = loaded.dataset
    assert not set(ENERGIES) & set(data)
    for name in set(data) - {"displacement", "rigid_position"}:
        xr.testing.assert_identical(data[name], turns.dataset[name])
    assert str(loaded.summary()) == str(turns.summary())
    assert set(loaded.figures()) == set(turns.figures())
    # Saved once more, it is the same again.
    again = flexmech.Response.load(nc_of(loaded.save(tmp_path / "again")))
    xr.testing.assert_identical(again.dataset, data)


def test_frames_are_samples_of_the_last_turn(turns: flexmech.Response, tmp_path: Path) -> None:
    data = flexmech.Response.load(nc_of(turns.save(tmp_path))).dataset
    time = data["frame_time"].values
    assert MOST_PICTURES <= len(time) <= MOST_FRAMES + 1
    assert np.ptp(np.diff(time)) < 1e-9
    assert abs(data["frame_angle"][-1] - data["frame_angle"][0]) == pytest.approx(2 * np.pi)
    there = turns.dataset.sel(time=time)
    for name in ("displacement", "rigid_position"):
        np.testing.assert_array_equal(
            data[name].transpose(..., "frame_time", "link", "station", "component").values,
            there[name].transpose(..., "time", "link", "station", "component").values,
        )
    assert data["frame_time"].attrs["units"] == "s"
    assert data["frame_angle"].attrs["units"] == "rad"


def test_a_loaded_run_moves(turns: flexmech.Response, tmp_path: Path) -> None:
    loaded = flexmech.Response.load(nc_of(turns.save(tmp_path)))
    motion, whole = (EnlargedMotion.of(each.dataset, None) for each in (loaded, turns))
    assert motion.title.split(", ")[:2] == whole.title.split(", ")[:2]
    assert motion.enlargement == whole.enlargement
    same = np.isin(whole.time, motion.time)
    assert same.sum() == motion.time.size
    np.testing.assert_array_equal(motion.deflected, whole.deflected[same])
    np.testing.assert_array_equal(motion.path, whole.path[same])


def test_the_command_stores_all_when_asked(tmp_path: Path) -> None:
    options = ["--speed", "20", "--revolutions", "0.05", "--elements", "2", "--no-plots"]
    command = ["response", str(STEEL), *options, "--engine", "reference", "--out", str(tmp_path)]
    for store, held in (("all", True), ("needed", False)):
        done = CliRunner().invoke(app, [*command, "--store", store])
        assert done.exit_code == 0, done.output
        data = flexmech.Response.load(tmp_path / "response.nc").dataset
        assert ("kinetic_energy" in data) == held
        assert ("time" in data["displacement"].dims) == held


def test_another_store_is_refused(turns: flexmech.Response, tmp_path: Path) -> None:
    wrong: Any = "some"
    with pytest.raises(flexmech.InputError, match="store"):
        turns.save(tmp_path, store=wrong)
