"""The result of a frequency map: files, table, extremes and agreement."""

from __future__ import annotations

import csv
import errno
import signal
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech.analyses import (
    EngineAgreement,
    FrequencyRequest,
    MovingFrequencies,
    ResponseRequest,
    moving_frequencies,
)
from flexmech.analyses.speed_sweep.compute import speed_sweep
from flexmech.errors import InputError
from flexmech.files import moved_into
from flexmech.linkages import ConstantSpeed
from flexmech.reference import ReferenceEngine
from tests.support.plot_data import frequency_dataset
from tests.support.strategies import fourbar

ANGLES = np.radians([0.0, 10.0, 20.0, 30.0])
HEADER = "engine,crank_speed_rad_s,crank_angle_deg,mode,branch,frequency_Hz,damping_ratio"


@pytest.fixture(scope="module")
def result() -> MovingFrequencies:
    engine = ReferenceEngine(fourbar(damping_time=1e-5), 4)
    return moving_frequencies(engine, ANGLES, [0.0, 20.0], modes=3, speed_effect=True)


@pytest.fixture
def two_engines() -> MovingFrequencies:
    return MovingFrequencies(frequency_dataset(speeds=(0.0, 20.0), angles=ANGLES, modes=3))


def test_saved_results_load_back_identical(result: MovingFrequencies, tmp_path: Path) -> None:
    paths = result.save(tmp_path / "new" / "folder")
    assert [p.name for p in paths] == ["frequencies.csv", "frequencies.nc"]
    loaded = MovingFrequencies.load(paths[1])
    xr.testing.assert_identical(loaded.dataset, result.dataset)
    for name, variable in result.dataset.variables.items():
        assert loaded.dataset[name].dtype.kind == variable.dtype.kind, name
    assert sorted(p.name for p in paths[0].parent.iterdir()) == [p.name for p in paths]


def test_csv_has_the_agreed_columns_and_a_row_for_each_mode(
    result: MovingFrequencies, tmp_path: Path
) -> None:
    text = result.save(tmp_path)[0].read_text(encoding="utf-8")
    assert text.splitlines()[0] == HEADER
    rows = list(csv.DictReader(text.splitlines()))
    assert len(rows) == 2 * 4 * 3
    data = result.dataset
    for row, (s, a, m) in zip(rows, np.ndindex(2, 4, 3), strict=True):
        assert row["engine"] == "reference"
        assert float(row["crank_speed_rad_s"]) == (0.0, 20.0)[s]
        assert float(row["crank_angle_deg"]) == (0.0, 10.0, 20.0, 30.0)[a]
        assert int(row["mode"]) == m + 1
        assert int(row["branch"]) == data["branch_of_mode"].values[0, s, a, m]
        assert float(row["frequency_Hz"]) == pytest.approx(data["frequency"].values[0, s, a, m])
        damping = data["damping_ratio"].values[0, s, a, m]
        assert float(row["damping_ratio"]) == pytest.approx(damping, rel=1e-8)
        assert damping > 0


def test_rows_of_two_engines_follow_each_other(two_engines: MovingFrequencies) -> None:
    table = two_engines.tables()["frequencies"]
    assert len(table) == 2 * 2 * 4 * 3
    assert table["engine"].tolist() == ["reference"] * 24 + ["exudyn"] * 24
    assert ",".join(table.columns) == HEADER


def test_a_file_in_place_of_the_folder_is_refused(
    result: MovingFrequencies, tmp_path: Path
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("mine")
    for folder in (taken, taken / "below"):
        with pytest.raises(InputError, match=f"cannot write to {folder}.*choose a folder"):
            result.save(folder)
    assert taken.read_text() == "mine"
    assert list(tmp_path.iterdir()) == [taken]


def test_a_full_disk_leaves_the_old_files_as_they_were(
    result: MovingFrequencies, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "frequencies.csv").write_text("old")

    def fail(*args: object, **kwargs: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", fail)
    with pytest.raises(InputError, match="No space left on device"):
        result.save(tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["frequencies.csv"]
    assert (tmp_path / "frequencies.csv").read_text() == "old"


def test_a_signal_as_the_temporary_folder_is_made_leaves_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It waits until the folder is there, and is raised before anything is written."""
    make = tempfile.mkdtemp

    def interrupted(**options: Any) -> str:
        made = make(**options)
        signal.raise_signal(signal.SIGINT)
        return made

    monkeypatch.setattr(tempfile, "mkdtemp", interrupted)
    with pytest.raises(KeyboardInterrupt), moved_into(tmp_path):
        pass
    assert not list(tmp_path.iterdir())


def test_what_is_no_result_is_not_loaded(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing.nc: no such result file"):
        MovingFrequencies.load(tmp_path / "nothing.nc")
    wrong = tmp_path / "wrong.nc"
    wrong.write_bytes(b"not a NetCDF file")
    with pytest.raises(InputError, match=r"wrong.nc: not a NetCDF file"):
        MovingFrequencies.load(wrong)
    xr.Dataset({"other": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="no variable 'frequency'"):
        MovingFrequencies.load(tmp_path / "other.nc")


def test_agreement_finds_the_planted_difference(two_engines: MovingFrequencies) -> None:
    frequency = two_engines.dataset["frequency"]
    frequency[1] = frequency[0] * (1 + 1e-6)
    frequency[1, 0, 3, 0] = frequency[0, 0, 3, 0] * (1 + 2e-3)
    frequency[1, 1, 2, 1] = frequency[0, 1, 2, 1] * (1 - 3e-3)
    found = two_engines.agreement()
    assert isinstance(found, EngineAgreement)
    assert found.engines == ("reference", "exudyn")
    assert found.relative_difference == pytest.approx(3e-3)
    assert (found.crank_speed, found.crank_angle, found.mode) == (20.0, ANGLES[2], 2)


def test_one_engine_has_nothing_to_agree_with(result: MovingFrequencies) -> None:
    assert result.agreement() is None


def test_extremes_find_the_planted_values(two_engines: MovingFrequencies) -> None:
    frequency = two_engines.dataset["frequency"]
    frequency[:] = 50.0
    frequency[1, 0, 2, 1], frequency[1, 0, 3, 1] = 40.0, 60.0
    found = two_engines.extremes().sel(engine="exudyn", crank_speed=0.0, mode=2)
    assert float(found["lowest"]) == 40.0
    assert float(found["lowest_angle"]) == ANGLES[2]
    assert float(found["highest"]) == 60.0
    assert float(found["highest_angle"]) == ANGLES[3]
    assert (two_engines.extremes().sel(engine="reference")["highest"] == 50.0).all()


def test_dataset_tells_what_it_is(result: MovingFrequencies) -> None:
    data = result.dataset
    assert data["frequency"].dims == ("engine", "crank_speed", "crank_angle", "mode")
    for name in ("frequency", "damping_ratio", "mac", "mode_shape", "crank_speed", "speed_effect"):
        assert data[name].attrs["units"], name
        assert data[name].attrs["long_name"], name
    assert data.attrs["prestress"] == "equilibrium"
    assert data.attrs["rotation_terms"] == "on"
    assert data.attrs["elements"] == 4
    assert data.attrs["flexmech_version"]
    assert str(data["element"].values[0]) == "euler"


def test_speed_effects_add_up_to_the_whole_effect(result: MovingFrequencies) -> None:
    frequency = result.dataset["frequency"].sel(engine="reference")
    total = result.dataset["speed_effect"].sum("term")
    assert list(result.dataset["term"].values) == [
        "geometric", "configuration", "coriolis", "centripetal", "tangential",
    ]  # fmt: skip
    change = (frequency - frequency.sel(crank_speed=0.0)).values
    assert total.values == pytest.approx(change, abs=1e-5 * float(frequency.max()))
    assert np.abs(change[1]).max() > 0.1


def test_largest_displacement_of_a_mode_shape_is_one(result: MovingFrequencies) -> None:
    shape = result.dataset["mode_shape"]
    size = np.sqrt((shape**2).sum(["part", "component"]))
    assert size.max(["link", "station"]).values == pytest.approx(1.0)


def test_links_meet_in_the_rigid_positions(result: MovingFrequencies) -> None:
    place = result.dataset["rigid_position"]
    crank, coupler, rocker = (place.sel(link=name) for name in ("crank", "coupler", "rocker"))
    pairs = ((crank, 1.0, coupler, 0.0), (coupler, 1.0, rocker, 1.0))
    for a, x, b, y in pairs:
        assert a.sel(station=x).values == pytest.approx(b.sel(station=y).values, abs=1e-12)
    assert (rocker.sel(station=0.0).values == [0.254, 0.0]).all()


def test_progress_counts_up_to_all_positions() -> None:
    seen: list[tuple[str, int, int]] = []
    moving_frequencies(
        ReferenceEngine(fourbar(), 2),
        ANGLES,
        [0.0, 5.0],
        progress=lambda *step: seen.append(step),
    )
    counts = [done for label, done, total in seen if label == "reference"]
    assert counts == sorted(counts)
    assert counts[-1] == 8
    assert {total for _, _, total in seen} == {8}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"crank_angles": [0.0, 0.2, 0.1]}, "crank_angles must increase"),
        ({"crank_angles": [0.0, 0.0]}, "crank_angles must increase"),
        ({"crank_angles": []}, "crank_angles must be a list of one value or more"),
        ({"crank_angles": [[0.0, 1.0]]}, "crank_angles must be a list of one value or more"),
        ({"crank_angles": [0.0, np.nan]}, "crank_angles must be finite"),
        ({"crank_speeds": [np.inf]}, "crank_speeds must be finite"),
        ({"crank_speeds": [5.0, 5.0]}, "crank_speeds repeats a speed"),
        ({"modes": 0}, "modes must be 1 or more, got 0"),
        ({"prestress": "some"}, "prestress must be one of none, axial, equilibrium"),
        ({"crank_angles": [0.0, 90.0, 180.0]}, r"rad and reaches 180; .* np.radians\(crank_angles"),
        ({"crank_angles": [5.0, 10.0, 15.0]}, r"rad and reaches 15; .* np.radians\(crank_angles"),
        ({"crank_speeds": ["20 rpm"]}, "crank_speeds must be a number of rad/s"),
        ({"modes": 2.5}, "modes must be 1 or more, got 2.5"),
    ],
)
def test_a_senseless_request_is_refused(wrong: dict[str, object], message: str) -> None:
    request = {"crank_angles": [0.0, 1.0], "crank_speeds": [0.0], **wrong}
    with pytest.raises(InputError, match=message):
        moving_frequencies(ReferenceEngine(fourbar(), 2), **request)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"samples": "720"}, "samples must be 8 or more a revolution, got '720'"),
        ({"samples": 7}, "samples must be 8 or more a revolution, got 7"),
        ({"modes": "4"}, "modes must be 1 or more, got '4'"),
        ({"modes": 0}, "modes must be 1 or more, got 0"),
    ],
)
def test_a_senseless_count_of_a_run_is_refused(wrong: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ResponseRequest(ConstantSpeed(20.0), **wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("orders", [0, "24", 2.5, True])
def test_a_sweep_is_refused_before_it_computes(orders: object) -> None:
    with pytest.raises(InputError, match=f"orders must be 1 or more, got {orders!r}"):
        speed_sweep(ReferenceEngine(fourbar(), 2), [10.0], orders=orders)  # type: ignore[arg-type]


def test_a_map_needs_an_engine_or_a_mechanism() -> None:
    with pytest.raises(InputError, match="needs an engine, got an empty list"):
        moving_frequencies([], ANGLES, [0.0])
    for wrong in (fourbar().linkage, "model.toml", [ReferenceEngine(fourbar(), 2), None]):
        with pytest.raises(InputError, match=r"flexmech.ReferenceEngine\(mechanism\)"):
            moving_frequencies(wrong, ANGLES, [0.0])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("degrees", "full"),
    [
        (np.arange(0.0, 361.0, 5.0), True),
        (np.arange(0.0, 360.0, 5.0), True),
        (np.arange(-180.0, 181.0, 10.0), True),
        (np.arange(0.0, 350.0, 5.0), False),
        (np.arange(0.0, 375.0, 5.0), False),
        (np.array([0.0, 180.0]), False),
    ],
)
def test_a_full_turn_is_recognised(degrees: np.ndarray, full: bool) -> None:
    request = FrequencyRequest(np.radians(degrees), [0.0])
    assert request.full_turn is full


def test_the_split_of_one_speed_is_that_of_all() -> None:
    """What is asked for the picture's sake costs one speed and not all of them."""
    engine = ReferenceEngine(fourbar(damping_time=1e-4), 4)
    every, fastest = (
        moving_frequencies(
            engine, ANGLES[::4], [0.0, -20.0, 10.0], modes=2, speed_effect=which
        ).dataset["speed_effect"]
        for which in (True, "fastest")
    )
    assert not every.isnull().any()
    assert fastest.isel(crank_speed=[0, 2]).isnull().all()
    np.testing.assert_array_equal(fastest.isel(crank_speed=1), every.isel(crank_speed=1))
