"""Wrong loads, springs, springs in joints and bodies of model files: one message each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.linkages import AttachmentPoint
from flexmech.modelfile import mechanism_from_toml, template

FORCE = 'force = ["1 N", "0 N"]'
HEAD = "crank_angle_deg,force_x_N,force_y_N\n"
BASES = {"planar": template("planar"), "four-bar": template("four-bar")}


def load(keys: str) -> str:
    return f"[loads.push]\n{keys}"


def table(rows: str, over: str = "crank_angle") -> str:
    return load(f'link = "crank"\nposition = "0 m"\nover = "{over}"\ntable = {rows}')


def file(name: str) -> str:
    return load(f'link = "crank"\nposition = "0 m"\nover = "crank_angle"\nfile = "{name}"')


def spring(points: str, keys: str = 'stiffness = "1 N/m"\nfree_length = "0 m"') -> str:
    return f"[springs.s]\npoints = {points}\n{keys}"


def joint(keys: str) -> str:
    return f"[joints.B]\n{keys}"


def body(keys: str, link: str = "crank") -> str:
    return f"[[links.{link}.bodies]]\n{keys}"


# What is added to a file, and what the message says after the name of the file.
WRONG = [
    # Loads: places.
    (load(f'link = "krank"\nposition = "0 m"\n{FORCE}'), "loads.push: there is no link 'krank'"),
    (load(f'point = "O4"\n{FORCE}'), "loads.push: O4 is a point of the ground, where a force"),
    (load(f'point = "O2"\n{FORCE}'), "loads.push: O2 is a point of the ground"),
    (load(f'link = "ground"\nposition = "0 m"\n{FORCE}'), "there is no link 'ground'; use one of"),
    (load(f'link = "crank"\nposition = "-1 mm"\n{FORCE}'), "loads.push.position: must be zero or"),
    (load(f'point = "A"\nlink = "crank"\nposition = "0 m"\n{FORCE}'), "give either point, or link"),
    # Loads: numbers.
    (load('point = "A"\nforce = ["1 m", "0 N"]'), r"push.force\[0\]: got '1 m', whose unit 'm'"),
    (load('point = "A"\nforce = ["nan N", "0 N"]'), r"push.force\[0\]: got 'nan N', which does"),
    (load('point = "A"\nforce = ["1 N"]'), r"push.force\[1\]: is missing; give one more value"),
    (load('point = "A"\nforce = "1 N"'), "push.force: got '1 N'; write a list in square brackets"),
    (load('point = "A"\nlink = "crank"\ntorque = "1 N"'), "push.torque: got '1 N', whose unit 'N'"),
    (load(f'point = "A"\naxes = "body"\n{FORCE}'), "push.axes: got 'body'; use one of ground, l"),
    # Loads: tables.
    (table("[]"), "loads.push: table is empty; give at least one row"),
    (table('[["0 deg", "0 N", "0 N"]]', "angle"), "push.over: got 'angle'; did you mean 'crank_an"),
    (table('[["9 deg", "0 N", "0 N"], ["5 deg", "0 N", "0 N"]]'), r"table\[1\]: its places mus"),
    (table('[["0 deg", "0 N", "0 N"], ["360 deg", "0 N", "0 N"]]'), "span a turn or more"),
    (table('[["0 deg", "nan N", "0 N"]]'), r"loads.push: table\[0\]: got 'nan N'"),
    (table("[[0, 1, 2]]"), r"table\[0\]: got the number 0.0, which has no unit; write an angle"),
    # Loads: files.
    (file("none.csv"), "loads.push: file none.csv: cannot be read: No such file or directory"),
    (file("columns.csv"), "file columns.csv: its first line must be crank_angle_deg,force_x_N"),
    (file("title.csv"), "file title.csv: there is no row below its first line; give at least one"),
    (file("nan.csv"), "loads.push: file nan.csv: line 2 has 'nan', which is no number"),
    (file("falling.csv"), "loads.push: file falling.csv: line 3: its places must increase"),
    (file("bytes.csv"), "file bytes.csv: is no text in UTF-8; save it as CSV in UTF-8"),
    # Springs.
    (spring('["A", "O4"]', 'stiffness = "-1 N/m"\nfree_length = "0 m"'), "s.stiffness: must be"),
    (spring('["A", "O4"]', 'stiffness = "1 N/m"\nfree_length = "-1 m"'), "s.free_length: must be"),
    (spring('["A", "O4"]', 'stiffness = "nan N/m"\nfree_length = "1 m"'), "s.stiffness: got 'nan"),
    (spring('["A", "O4"]', 'stiffness = "1 N/m"'), "springs.s.free_length: is missing; add it"),
    (spring('["O2", "O4"]'), "springs.s: spring s has both ends on ground; join two links"),
    (spring('["O4", ["0 m", "1 m"]]'), "springs.s: spring s has both ends on ground"),
    (spring('["A", "Z"]'), "springs.s: there is no point 'Z'; use one of O2, A, B"),
    (spring('[{ link = "krank", position = "0 m" }, "B"]'), "springs.s: there is no link 'krank'"),
    (spring('[{ link = "crank", position = "9 m" }, "B"]'), "springs.s: got 9 m, which is beyond"),
    (spring('["A", "O4", "B"]'), "springs.s.points: got 3 values; give 2"),
    ('[springs.""]\npoints = 3', "springs.*write text that is not empty"),
    # Springs in joints.
    (joint('torsional_stiffness = "-1 N m/rad"'), "joints.B.torsional_stiffness: must be zero or"),
    (joint('torsional_stiffness = "nan N m/rad"'), "joints.B.torsional_stiffness: got 'nan"),
    (joint('torsional_damping = "1 N m/rad"'), "joints.B.torsional_damping: got .*whose unit"),
    (joint('free_angle = "10 deg"'), "joints.B: free_angle belongs to a torsional_stiffness"),
    (joint('radial_stiffness = "0 N/m"'), "joints.B.radial_stiffness: must be positive"),
    (joint('radial_damping = "1 N s/m"'), "joints.B: .*radial_damping needs a radial_stiffness"),
    ('[joints.Q]\nmass = "1 kg"', "joints.Q: the linkage has no such joint; use one of"),
    # Bodies and the shaft.
    (body('position = "0 m"'), r"crank.bodies\[0\]: mass and inertia are missing; give one"),
    (body('mass = "1 kg"'), r"links.crank.bodies\[0\].position: is missing; add it"),
    (body('position = "0 m"\nmass = "-1 kg"'), r"bodies\[0\].mass: must be zero or positive"),
    (body('position = "0 m"\nmass = "1 kg"\noffset = ["1 mm"]'), r"bodies\[0\].offset\[1\]: is"),
    (body('position = "9 m"\nmass = "1 kg"'), r"bodies\[0\].position: got 9 m, which is beyond"),
    (body('position = "0 m"\nmass = "1 kg"\nbeam = 0'), r"bodies\[0\].beam: got 0; give 1 or more"),
    (body('position = "0 m"\nmass = "1 kg"\nbeam = "x"'), "beam: got 'x'; write a whole number"),
    ('[shaft]\ninertia = "-1 kg m^2"', "shaft.inertia: must be zero or positive"),
    ('[shaft]\ninertia = "1 kg"', "shaft.inertia: got '1 kg', whose unit 'kg'"),
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the files of loads are."""
    found = tmp_path_factory.mktemp("attachments")
    (found / "columns.csv").write_text("angle,force\n0,1\n")
    (found / "title.csv").write_text(HEAD)
    (found / "nan.csv").write_text(HEAD + "nan,1,0\n")
    (found / "falling.csv").write_text(HEAD + "9,1,0\n5,1,0\n")
    (found / "bytes.csv").write_bytes(bytes(range(256)))
    return found


@pytest.mark.parametrize("base", BASES)
def test_each_gets_its_message(base: str, folder: Path) -> None:
    """On standard error, in one line, with exit code 2."""
    model, runner = folder / f"{base}.toml", CliRunner()
    for added, message in WRONG:
        model.write_text(f"{BASES[base]}\n{added}\n")
        told = runner.invoke(app, ["frequencies", str(model), "--angles", "0"])
        assert told.exit_code == 2, (added, told.stderr)
        assert told.stdout == ""
        assert told.stderr.count("\n") == 1
        assert re.search(f"^error: [^ ]*{base}.toml: .*{message}", told.stderr), told.stderr


@pytest.mark.parametrize("base", BASES)
def test_a_torque_at_a_bearing_and_a_force_on_a_named_link_are_allowed(base: str) -> None:
    mechanism = mechanism_from_toml(
        BASES[base]
        + '\n[loads.torque]\npoint = "O4"\nlink = "rocker"\ntorque = "1 N m"\n'
        + f'[loads.bearing]\npoint = "O4"\nlink = "rocker"\n{FORCE}\n'
    )
    place = ("rocker", 0.0)
    assert [own.point for own in mechanism.loads] == [AttachmentPoint(*place)] * 2


def test_springs_of_a_four_bar_name_its_joints() -> None:
    """Ground pivots and the shaft's axis are places of the ground."""
    four_bar = BASES["four-bar"] + "\n"
    (spring_,) = mechanism_from_toml(four_bar + spring('["O4", "A"]')).springs
    assert spring_.first.is_ground
    assert (spring_.first.x, spring_.first.y) == pytest.approx((0.254, 0.0), abs=1e-12)
    assert spring_.second == AttachmentPoint("crank", 0.1)
    (spring_,) = mechanism_from_toml(four_bar + spring('["O2", "B"]')).springs
    assert spring_.first == AttachmentPoint("ground", 0.0)
