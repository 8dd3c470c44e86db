"""Printed answers and places of files: words, JSON, nothing; pictures by format and width."""

from __future__ import annotations

import contextlib
import csv
import json
import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.modelfile import template
from tests.support.command import MODELS, run_command

STEEL, ARM = "models/steel_fourbar.toml", "models/rotating_arm.toml"


def test_json_has_numbers_units_errors_and_files_and_quiet_has_warnings_alone(command):
    ended = command("check", STEEL, "--no-plots", "--json")
    said = json.loads(ended.stdout)
    assert set(said) == {"answer", "numbers", "table", "trust", "warnings", "details", "files"}
    assert set(said["numbers"][0]) == {"name", "of", "value", "unit", "error"}
    assert set(said["table"]) == {"title", "columns", "rows", "caption"}
    quiet = command("check", STEEL, "--no-plots", "--quiet")
    assert quiet.stdout == ""
    assert quiet.stderr == ended.stderr
    assert quiet.stderr == "".join(f"warning: {line}\n" for line in said["warnings"])
    assert quiet.files == ["check.csv", "check.nc", "summary.txt"]


def test_the_answer_comes_first_and_details_are_those_of_the_summary(command):
    said = json.loads(command("section", ARM, "--no-plots", "--json").stdout)
    plain = command("section", ARM, "--no-plots").stdout
    details = command("section", ARM, "--no-plots", "--details")
    lines = plain.splitlines()
    assert lines[: len(said["answer"])] == said["answer"]
    assert lines[-2] == said["trust"]
    assert lines[-1].startswith(f"files in {details.folder}: ")
    kept = (details.folder / "summary.txt").read_text(encoding="utf-8")
    assert kept.startswith("sections of rotating arm\n")
    for line in (*said["answer"], said["trust"], *said["details"]["lines"]):
        assert line in kept
        assert line in details.stdout
    for table in said["details"]["tables"]:
        assert table["title"] in kept
        assert table["title"] not in plain


def test_numbers_of_a_table_are_whole_at_80_columns(command, monkeypatch):
    """Names and headings may break into lines."""
    monkeypatch.setenv("COLUMNS", "80")
    words = ("check", STEEL, "--no-plots")
    said = json.loads(command(*words, "--json").stdout)
    printed = command(*words).stdout
    rows = [line for line in printed.splitlines() if line.startswith("│")]
    assert max(map(len, rows)) <= 80
    numbers = set()
    for cell in (cell for row in rows for cell in row.split("│")):
        with contextlib.suppress(ValueError):
            numbers.add(float(cell))
    expected = {one for row in said["table"]["rows"] for one in row if isinstance(one, float)}
    assert expected
    assert expected <= numbers


def test_a_second_command_keeps_what_the_first_has_found(tmp_path):
    """Both write a file of the same name; what lies there from an earlier run is named."""
    few = ("--angles", "0,90", "--elements", "2", "--modes", "2", "--engine", "reference")
    first = run_command(tmp_path, "kinematics", STEEL, *few[:2], "--no-plots")
    kept = {path: path.read_bytes() for path in first.folder.iterdir()}
    second = run_command(tmp_path, "response", STEEL, *few[2:], "--speed", "20", "--no-plots")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["kinematics", "response"]
    assert {path: path.read_bytes() for path in first.folder.iterdir()} == kept
    assert "sizing.csv" in {*first.files} & {*second.files}
    assert len(flexmech.stored_results(tmp_path).all) == 2
    listed_before = first.files
    old = first.folder / "motion.png"
    old.write_bytes(b"old")
    (first.folder / "notes.txt").write_text("mine")
    again = run_command(tmp_path, "kinematics", STEEL, *few[:2], "--no-plots").stdout
    named, stale = again.splitlines()[-2:]
    words, _, listed = named.partition(": ")
    assert words == f"files in {first.folder}"
    assert sorted(listed.split(", ")) == listed_before
    assert stale == "from an earlier run, not of this one: motion.png"
    assert old.read_bytes() == b"old"


def test_pictures_are_those_that_the_answer_needs_or_all(tmp_path, rough_pictures):
    """One to three of them; data are the same."""
    words = ("kinematics", STEEL, "--angles", "0:360:30")
    few, every = (
        {*run_command(tmp_path / str(len(more)), *words, *more).files} for more in ((), ("--all",))
    )
    assert {name for name in few if name.endswith(".png")} == {
        "kinematics.png",
        "joint_forces.png",
        "drive.png",
    }
    assert {name.rpartition(".")[2] for name in every - few} == {"png"}
    assert {"motor_plane.png", "shaking_force.png"} < every - few
    assert few < every


def test_a_file_names_the_command_line_as_a_shell_takes_it(tmp_path):
    out = tmp_path / "with blank"
    model = str(MODELS / "steel_fourbar.toml")
    ended = CliRunner().invoke(app, ["section", model, "--no-plots", "--out", str(out)])
    assert ended.exit_code == 0
    (found,) = flexmech.stored_results(out).all
    line = f"flexmech section {model} --no-plots --out '{out}'"
    assert found.stored_as["command_line"] == line


@pytest.mark.parametrize("name", ["=HYPERLINK(1)", "+rod", "-rod", "@SUM(A1)"])
def test_a_name_is_no_formula_in_a_table(name, tmp_path):
    """In cells and in the title of a column; numbers below zero stay numbers."""
    text = template("slider-crank").replace("[links.rod]", f'[links."{name}"]')
    model = tmp_path / "model.toml"
    model.write_text(text, encoding="utf-8")
    rigid = run_command(tmp_path / "rigid", "kinematics", model, "--angles", "0,90", "--no-plots")
    words = (f"--link={name}", "--point", "30 mm,0 deg", "--angles", "0,90", "--no-plots")
    path = run_command(tmp_path / "path", "coupler-curve", model, *words)
    assert (rigid.exit_code, path.exit_code) == (0, 0)
    for file in (*rigid.folder.glob("*.csv"), *path.folder.glob("*.csv")):
        for cell in (c for row in csv.reader(file.open(encoding="utf-8")) for c in row):
            assert cell[:1] not in ("=", "+", "-", "@") or np.isfinite(float(cell)), (file, cell)
    assert f"'{name}" in rigid.table("kinematics")["link"]
    assert f"'{name}_deg" in path.table("coupler_curve")


def test_pictures_have_the_formats_and_the_width_asked_for(command, rough_pictures):
    words = ("check", STEEL, "--format", "svg, .PDF,svg,png", "--width", "one-column")
    ended = command(*words)
    pictures = {"check.pdf", "check.png", "check.svg"}
    assert set(ended.files) == {"check.csv", "check.nc", "summary.txt", *pictures}
    # 88 mm at the resolution of rough pictures.
    with Image.open(ended.folder / "check.png") as picture:
        narrow = picture.width
    again = command("check", STEEL)
    assert {"check.pdf", "check.svg"} <= set(again.stdout.split("earlier run")[1].replace(
        ",", " ").split())  # fmt: skip
    with Image.open(ended.folder / "check.png") as picture:
        assert picture.width / narrow == pytest.approx(180 / 88, abs=0.03)
    for wrong in ({"formats": "png"}, {"formats": ("eps",)}, {"width": "80 mm"}):
        (result,) = flexmech.stored_results(ended.folder).all
        with pytest.raises(flexmech.InputError, match=next(iter(wrong))):
            result.save(ended.folder / "none", figures=True, **wrong)
    assert not (ended.folder / "none").exists()


def test_a_result_shows_itself_in_a_notebook():
    found = flexmech.section_profiles(flexmech.load_mechanism(MODELS / "rotating_arm.toml"))
    assert "rotating arm" in repr(found)
    assert "\n" not in repr(found)
    assert found.summary().answer[0] in found._repr_html_()


# --- the program --------------------------------------------------------------------------------


def test_version_and_help_and_the_commands_that_shells_complete():
    runner = CliRunner()
    assert runner.invoke(app, ["--version"]).stdout.split() == ["flexmech", flexmech.__version__]
    shown = runner.invoke(app, ["--help"]).stdout
    for command in ("frequencies", "response", "campbell", "stability", "check", "new", "schema"):
        assert command in shown
        options = runner.invoke(app, [command, "--help"]).stdout
        assert "Options:" in options
    for words, expected in (("flexmech fre", "frequencies"), ("flexmech check --qu", "--quiet")):
        environment = {
            "_FLEXMECH_COMPLETE": "complete_bash",
            "COMP_WORDS": words,
            "COMP_CWORD": str(words.count(" ")),
        }
        told = runner.invoke(app, env=environment, prog_name="flexmech")
        assert told.stdout.split() == [expected]


def test_help_imports_nothing_heavy():
    heavy = {"numpy", "scipy", "xarray", "pint", "pydantic", "matplotlib", "exudyn"}
    program = f"import sys, flexmech.cli; print({heavy} & set(sys.modules))"
    words = [sys.executable, "-c", program]
    shown = subprocess.run(words, capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "set()"


def test_the_module_is_the_command(tmp_path):
    words = [sys.executable, "-m", "flexmech", "check", "nothing.toml"]
    shown = subprocess.run(
        words, capture_output=True, text=True, cwd=tmp_path, env=dict(os.environ), check=False
    )
    assert (shown.returncode, shown.stdout) == (2, "")
    assert shown.stderr.startswith("error: nothing.toml: ")
