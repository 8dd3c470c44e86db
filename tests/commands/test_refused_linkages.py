"""Wrong drawings, attachments and drives of model files: the key named, a remedy, exit code 2."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from flexmech import load_mechanism
from flexmech.modelfile import KINDS, mechanism_from_toml, template
from tests.support.command import MODELS, run_command

TABLE = tomllib.loads((Path(__file__).parent / "refused_linkages.toml").read_text("utf-8"))
ROWS = [(model, *row) for model, rows in TABLE.items() for row in rows]


def text_of(model: str) -> str:
    """A template of ``flexmech new``, or a file among the data of the tests."""
    data = MODELS.parent / "tests" / "data" / f"{model}.toml"
    return template(model) if model in KINDS else data.read_text("utf-8")


def refused(text: str, folder: Path) -> str:
    """What ``flexmech check`` says of a model file, behind its name."""
    file = folder / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    ended = run_command(folder / "out", "check", file)
    assert (ended.exit_code, ended.stdout, ended.files) == (2, "", [])
    assert ended.stderr.startswith(f"error: {file}: ")
    assert ended.stderr.count("\n") == 1
    return ended.stderr.removeprefix(f"error: {file}: ")


@pytest.mark.parametrize(("model", "old", "new", "key", "remedy"), ROWS)
def test_a_wrong_linkage_is_refused_by_its_key(
    model: str, old: str, new: str, key: str, remedy: str, tmp_path: Path
) -> None:
    old, new = old.replace("\\n", "\n"), new.replace("\\n", "\n")
    text = text_of(model)
    assert old in text
    told = refused(text.replace(old, new, 1) if old else f"{text}\n{new}\n", tmp_path)
    assert told.startswith(f"{key}: ")
    assert remedy in told


def test_a_chain_with_a_length_whose_points_are_not_drawn_is_refused(tmp_path: Path) -> None:
    """Its end is where a link with a length would have been placed."""
    text = template("planar").replace('B = ["263.8 mm", "266.5 mm"]\n', "")
    for points, length in (('["A", "B", "C"]', "150 mm"), ('["O4", "B"]', "110 mm")):
        text = text.replace(f"points = {points}", f'points = {points}\nlength = "{length}"')
    told = refused(text, tmp_path)
    assert told.startswith("links.coupler: length and angle are of a link with two points; draw")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("angle,force\n0,1\n", "its first line must be crank_angle_deg,force_x_N,force_y_N"),
        ("HEAD0,1\n", "line 2 has 2 fields, the first line 3"),
        ("HEAD0,1_0,1\n", "line 2 has '1_0'"),
        ("HEAD0,nan,1\n", "line 2 has 'nan'"),
        ("HEAD0,1e25,1\n", "line 2: got '1e25 N'"),
        ("HEAD9,1,0\n5,2,0\n", "line 3: its places must increase"),
        ("HEAD0,1,0\n360,2,0\n", "give less than one"),
        ("HEAD", "give at least one"),
        ("\udcff", "UTF-8"),
    ],
)
def test_a_file_of_loads_is_refused_by_its_line(content: str, said: str, tmp_path: Path) -> None:
    rows = content.replace("HEAD", "crank_angle_deg,force_x_N,force_y_N\n")
    (tmp_path / "push.csv").write_bytes(rows.encode("utf-8", "surrogateescape"))
    load = '[loads.push]\npoint = "A"\nlink = "crank"\nover = "crank_angle"\nfile = "push.csv"'
    told = refused(f"{template('four-bar')}\n{load}\n", tmp_path)
    assert told.startswith("loads.push: ")
    assert "file push.csv: " in told or "load push" in told
    assert said in told


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ('[drive]\ntable = "FILE"', "drive: table: file"),
        (
            '[loads.push]\npoint = "A"\nlink = "crank"\nover = "time"\nfile = "FILE"',
            "loads.push: file",
        ),
    ],
)
def test_what_has_no_end_or_is_too_large_is_not_read_as_a_table(
    table: str, key: str, tmp_path: Path
) -> None:
    with (tmp_path / "large.csv").open("wb") as large:
        large.truncate(10_000_001)
    for file, said in (("/dev/zero", "device or pipe"), ("large.csv", "larger than")):
        stated = table.replace("FILE", file)
        told = refused(f"{template('four-bar')}\n{stated}\n", tmp_path)
        assert told.startswith(f"{key} {file}: is ")
        assert said in told


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("time_s,crank_angle_deg\n0,0\n1,9\n1,9\n2,30\n", "1 s follows 1 s in row 3"),
        ("time_s,crank_angle_deg\n0,0\n1,nan\n2,3\n3,4\n", "line 3 has 'nan'"),
        ("time_kg,crank_angle_deg\n0,0\n1,9\n", "line 2: got '0 kg', whose unit 'kg'"),
        ("time,angle\n0,0\n1,9\n", "time_s,crank_angle_deg"),
        ("time_s,crank_angle_deg\n", "no row below its first line"),
        ("master_angle_deg,crank_angle_deg\n0,0\n1,9\n", "state master_speed"),
        ("time_s,crank_angle_deg\n0,0\n1,160\n2,320\n3,0\n4,160\n", "count angles on beyond 360"),
    ],
)
def test_a_table_of_a_drive_is_refused_by_its_line(content: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "cam.csv").write_text(content)
    told = refused(f'{template("four-bar")}\n[drive]\ntable = "cam.csv"\n', tmp_path)
    assert told.startswith("drive: table: file cam.csv: ")
    assert said in told


def test_files_beside_a_model_end_up_in_its_text(tmp_path: Path) -> None:
    """So that a result says all of its model, wherever it is read again; columns have units."""
    times = np.linspace(0.0, 0.2, 21)
    angles = 90 * (1 - np.cos(5 * np.pi * times))
    columns = {
        "time_s,crank_angle_deg": (times, angles),
        "Time (ms), crank angle [rad]": (1e3 * times, np.radians(angles)),
        "master_angle_deg,crank_angle_deg": (1800 * times, angles),
    }
    loads = "crank_angle_deg,force_x_N,force_y_N,torque_Nm\n10,1,2,0.5\n200,3,4,0.25\n"
    (tmp_path / "push.csv").write_text(loads)
    push = '[loads.push]\npoint = "A"\nlink = "crank"\nover = "crank_angle"\nfile = "push.csv"\n'
    moved = []
    for head, rows in columns.items():
        lines = (",".join(f"{value:.17g}" for value in row) for row in zip(*rows, strict=True))
        (tmp_path / "cam.csv").write_text("\n".join([head, *lines]) + "\n")
        speed = 'master_speed = "300 rpm"\n' if head.startswith("master") else ""
        model = tmp_path / "model.toml"
        model.write_text(f'{template("four-bar")}\n{push}[drive]\ntable = "cam.csv"\n{speed}')
        mechanism = load_mechanism(model)
        assert mechanism_from_toml(mechanism.provenance.text) == mechanism
        assert mechanism.drive is not None
        moved.append(mechanism.drive.crank_angle(np.linspace(0.0, 0.2, 101)))
    np.testing.assert_allclose(moved, [moved[0]] * 3, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(moved[0][::5], np.radians(angles), atol=1e-12)
    (load,) = mechanism.loads
    assert (load.force, load.torque) == (((1.0, 2.0), (3.0, 4.0)), (0.5, 0.25))


@pytest.mark.parametrize("base", ["planar", "four-bar"])
def test_a_bearing_that_is_named_by_its_link_takes_loads(base: str) -> None:
    """Joints of the ground may be named as its places."""
    spring = '[springs.s]\npoints = ["O4", "A"]\nstiffness = "1 N/m"\nfree_length = "0 m"\n'
    text = f"{template(base)}\n{spring}" + "".join(
        f'[loads.{name}]\npoint = "O4"\nlink = "rocker"\n{acting}\n'
        for name, acting in (("twist", 'torque = "1 N m"'), ("bear", 'force = ["1 N", "0 N"]'))
    )
    mechanism = mechanism_from_toml(text)
    assert [(load.point.link, load.point.x) for load in mechanism.loads] == [("rocker", 0.0)] * 2
    first = mechanism.springs[0].first
    assert first.is_ground
    places = [float(x) for x in re.findall(r'O4 = \["([\d.]+) mm"', text)]
    assert first.x == pytest.approx(places[0] / 1e3 if places else 0.254)
