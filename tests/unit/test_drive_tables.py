"""The table [drive] of model files: what it states, how it is written, and what is wrong in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech import ConstantSpeed, InputError, LawDrive, Mechanism, TableDrive, load_mechanism
from flexmech.cli import app
from flexmech.linkages import LockedCrank
from flexmech.modelfile import mechanism_from_toml, template
from flexmech.modelfile.quantities import StatedModel
from tests.support.strategies import fourbar

BASE = template("four-bar")
LAW = 'law = "cycloid"\ntravel = "120 deg"\ntime = "0.15 s"'
TIMES = np.linspace(0.0, 0.2, 21)
ANGLES = 90 * (1 - np.cos(5 * np.pi * TIMES))


def model(keys: str) -> str:
    return f"{BASE}\n[drive]\n{keys}\n"


def table(rows: np.ndarray, head: str) -> str:
    lines = (",".join(f"{value:.17g}" for value in row) for row in rows)
    return "\n".join([head, *lines]) + "\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    rows = np.column_stack([TIMES, ANGLES])
    in_ms = np.column_stack([1e3 * TIMES, np.radians(ANGLES)])
    master = np.column_stack([1800 * TIMES, ANGLES])
    (tmp_path / "cam.csv").write_text(table(rows, "time_s,crank_angle_deg"))
    (tmp_path / "ms.csv").write_text(table(in_ms, "Time (ms), crank angle [rad]"))
    (tmp_path / "master.csv").write_text(table(master, "master_angle_deg,crank_angle_deg"))
    (tmp_path / "same.csv").write_text(table(rows[[0, 1, 1, 2]], "time_s,crank_angle_deg"))
    (tmp_path / "nan.csv").write_text("time_s,crank_angle_deg\n0,0\n1,nan\n2,3\n3,4\n")
    (tmp_path / "kg.csv").write_text(table(rows, "time_kg,crank_angle_deg"))
    (tmp_path / "bare.csv").write_text(table(rows, "time,angle"))
    (tmp_path / "empty.csv").write_text("time_s,crank_angle_deg\n")
    turning = np.column_stack([TIMES, np.arange(21) * 40.0 % 360])
    (tmp_path / "turning.csv").write_text(table(turning, "time_s,crank_angle_deg"))
    return tmp_path


def stated(keys: str, folder: Path) -> Mechanism:
    file = folder / "model.toml"
    file.write_text(model(keys))
    return load_mechanism(file)


CAM = TableDrive(tuple(TIMES.tolist()), tuple(np.radians(ANGLES).tolist()))
DRIVES = {
    'speed = "-20 rad/s"\nrun_up_time = "0.2 s"\nstart_angle = "0.5 rad"': ConstantSpeed(
        -20.0, 0.2, 0.5
    ),
    LAW: LawDrive("cycloid", np.radians(120.0), 0.15),
    f'{LAW}\ndwell = "0.1 s"\nmoves = 4\nforth_and_back = true\nstart_angle = "0.1 rad"': LawDrive(
        "cycloid", np.radians(120.0), 0.15, 0.1, 4, True, 0.1
    ),
    'law = "modified sine"\ntravel = "1 rad"\nmaster_angle = "90 deg"\nmaster_dwell = "270 deg"\n'
    'master_speed = "60 rpm"': LawDrive("modified sine", 1.0, 0.25, 0.75),
    'table = "cam.csv"': CAM,
    'table = "ms.csv"': CAM,
    'table = "master.csv"\nmaster_speed = "300 rpm"': CAM,
    'table = [["0 s", "0 rad"], ["1 s", "1 rad"], ["2 s", "3 rad"], ["3 s", "4 rad"]]\n'
    'ends = "rest"\nsmoothing = "1e-3 rad"\nmoves = 2': TableDrive(
        (0.0, 1.0, 2.0, 3.0), (0.0, 1.0, 3.0, 4.0), 1e-3, "rest", 2
    ),
}


@pytest.mark.parametrize("keys", DRIVES, ids=range(len(DRIVES)))
def test_what_is_stated_is_read_and_written(keys: str, folder: Path) -> None:
    mechanism, wanted = stated(keys, folder), DRIVES[keys]
    time = np.linspace(0.0, 0.4, 101)
    assert type(mechanism.drive) is type(wanted)
    assert mechanism.drive is not None
    np.testing.assert_allclose(
        mechanism.drive.crank_angle(time), wanted.crank_angle(time), rtol=1e-12, atol=1e-12
    )
    again = mechanism_from_toml(mechanism.to_toml())
    assert again == mechanism
    assert again.drive == mechanism.drive
    # A file beside the model may be gone when its text is read again.
    assert mechanism_from_toml(mechanism.provenance.text) == mechanism
    assert any(line.startswith("drive: ") for line in mechanism.described())


def test_a_model_without_a_drive_has_none() -> None:
    mechanism = mechanism_from_toml(BASE)
    assert mechanism.drive is None
    assert "[drive]" not in mechanism.to_toml()


def test_its_quantities_are_those_of_studies() -> None:
    of_model = StatedModel.of(mechanism_from_toml(model(LAW)))
    assert {"drive.travel", "drive.time"} <= set(of_model.quantities)
    changed = of_model.with_values({"drive.time": 0.3})
    assert isinstance(changed.drive, LawDrive)
    assert (changed.drive.travel, changed.drive.time) == pytest.approx((np.radians(120.0), 0.3))


def test_drives_that_are_none_are_refused() -> None:
    with pytest.raises(InputError, match="drive: a locked crank does not turn"):
        fourbar(drive=LockedCrank(1.0))
    with pytest.raises(InputError, match="drive must be"):
        fourbar(drive=20.0)


WRONG = {
    LAW.replace("cycloid", "cyclod"): "drive.law: got 'cyclod'; did you mean 'cycloid'?",
    LAW.replace("120", "0"): "drive: travel must be an angle other than zero",
    LAW.replace("0.15 s", "0 s"): "drive.time: must be positive, got '0 s'",
    LAW.replace("0.15 s", "0.15 mm"): "drive.time: got '0.15 mm', whose unit 'mm'",
    LAW.replace('time = "0.15 s"', ""): "drive: give either time, or master_angle",
    LAW.replace('travel = "120 deg"', ""): "drive: travel is missing; add it",
    f'{LAW}\nspeed = "20 rad/s"': "drive: give either speed, or law with travel and time, or",
    f'{LAW}\nsmoothing = "1 deg"': "drive: smoothing belongs to table, and not to law",
    f'{LAW}\nmaster_speed = "20 rpm"': "drive: master_angle and master_speed go together",
    f'{LAW}\nmaster_dwell = "20 deg"': "drive: master_dwell does not go with time; give dwell",
    f"{LAW}\nmoves = 0": "drive: moves must be 1 or more",
    f"{LAW}\nmoves = 1.5": "drive.moves: got 1.5; write a whole number",
    f"{LAW}\nmove = 2": "drive.move: unknown key 'move'; did you mean 'moves'?",
    'speed = "0 rpm"': "drive: crank speed must be a number other than zero",
    'speed = "20 rad/s"\ndwell = "1 s"': "drive: dwell belongs to law or table, and not to speed",
    'table = "same.csv"': "drive: table: file same.csv: the table is not increasing in time: "
    "0.01 s follows 0.01 s in row 3; give each time once",
    'table = "nan.csv"': "drive: table: file nan.csv: line 3 has 'nan', which is no number",
    'table = "kg.csv"': "drive: table: file kg.csv: line 2: got '0 kg', whose unit 'kg'",
    'table = "bare.csv"': "drive: table: file bare.csv: its first line must be two columns with "
    "their units, as time_s,crank_angle_deg",
    'table = "empty.csv"': "drive: table: file empty.csv: there is no row below its first line",
    'table = "turning.csv"': "drive: table: file turning.csv: the angle jumps from 320 to 0 deg in "
    "row 10, from 0.08 to 0.09 s; count angles on beyond 360 deg",
    'table = "master.csv"': "its first line must be two columns with their units, as time_s,"
    "crank_angle_deg; state master_speed for angles of a master shaft",
    'table = "no.csv"': "drive: table: file no.csv: cannot be read: No such file",
    "table = 3": "drive.table: write the name of a CSV file, or rows as in",
    'table = [["0 s", "0 deg"], ["1 s"]]': "drive: table: [1]: got 1 values; give time and crank",
    'table = [["0 s", "0 deg"], ["1 s", "1 m"]]': "drive: table: [1]: got '1 m', whose unit 'm'",
    'table = "cam.csv"\nstart_angle = "1 deg"': "drive: start_angle is the first angle of the",
    'table = "cam.csv"\nends = "still"': "drive.ends: got 'still'",
}


@pytest.mark.parametrize("keys", WRONG, ids=range(len(WRONG)))
def test_what_is_wrong_is_told_in_one_line(keys: str, folder: Path) -> None:
    file = folder / "model.toml"
    file.write_text(model(keys))
    result = CliRunner().invoke(app, ["kinematics", str(file), "--out", str(folder / "out")])
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert WRONG[keys] in line
    assert str(file) in line
    assert not (folder / "out").exists()
