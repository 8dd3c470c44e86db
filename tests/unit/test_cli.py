"""The command line: what it reads, prints and writes, and how it ends."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from flexmech.choices import TemplateKind
from flexmech.cli import app
from flexmech.cli.typed import ANGLES, SPEEDS, Speeds
from flexmech.errors import InputError
from flexmech.modelfile import json_schema, load_mechanism, template

pytestmark = pytest.mark.usefixtures("rough_pictures")

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
MODEL_FILES = sorted(MODELS.glob("*.toml"))
ALUMINIUM = str(MODELS / "aluminium_fourbar.toml")
STEEL = str(MODELS / "steel_fourbar.toml")
ARM = str(MODELS / "rotating_arm.toml")
COLUMNS = "engine,crank_speed_rad_s,crank_angle_deg,mode,branch,frequency_Hz,damping_ratio"
DATA = ["frequencies.csv", "frequencies.nc", "summary.txt"]
PICTURES = ["agreement.png", "frequencies.png", "mode_shapes.png", "speed_effect.png"]
QUICK = ["--engine", "reference", "--elements", "2", "--modes", "2", "--angles", "0,60,120"]


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, list(arguments))


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# --- the commands that need no engine -------------------------------------------------------


def named(text: str) -> str:
    """A template with the name of the file that it is written into."""
    return re.sub(r'^name = ".*"', 'name = "mine"', text, count=1, flags=re.MULTILINE)


@pytest.mark.parametrize("kind", get_args(TemplateKind))
def test_new_writes_a_file_that_loads(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    result = run("new", kind, str(file))
    assert result.exit_code == 0
    assert f"flexmech check {file}" in result.stdout
    assert file.read_text(encoding="utf-8") == named(template(kind))
    assert load_mechanism(file).provenance.name == "mine"
    assert names(tmp_path) == ["mine.toml"]


def test_new_replaces_a_file_when_forced(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("old")
    assert run("new", "four-bar", str(file), "--force").exit_code == 0
    assert file.read_text(encoding="utf-8") == named(template("four-bar"))


def test_a_new_study_runs_as_it_is_written(tmp_path: Path) -> None:
    file, model = tmp_path / "study.toml", tmp_path / "aluminium_fourbar.toml"
    written = run("new", "study", str(file)).stdout
    assert f"wrote {file} and {model}, its model; next: flexmech sweep {file}" in written
    assert run("sweep", str(file), "--no-plots", "--out", str(tmp_path / "out")).exit_code == 0
    # A model of the same name is the user's own.
    model.write_text("mine")
    again = run("new", "study", str(file), "--force").stdout
    assert f"wrote {file}; next" in again
    assert model.read_text() == "mine"


def test_schema_is_printed_or_written(tmp_path: Path) -> None:
    printed = run("schema")
    assert printed.exit_code == 0
    assert json.loads(printed.stdout) == json_schema()
    file = tmp_path / "schema.json"
    assert run("schema", "--out", str(file)).exit_code == 0
    assert file.read_text(encoding="utf-8") == printed.stdout


def test_version_and_help() -> None:
    assert run("--version").stdout.startswith("flexmech ")
    shown = run("--help")
    assert shown.exit_code == 0
    for command in ("frequencies", "response", "check", "new", "schema"):
        assert command in shown.stdout
    options = run("frequencies", "--help").stdout
    for option in (
        "--speeds",
        "--angles",
        "--modes",
        "--engine",
        "--element ",
        "--prestress",
        "--rotation-terms LIST",
        "--elements",
        "--out",
        "--no-plots",
    ):
        assert option in options


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys, flexmech.cli; print(sorted({'numpy', 'scipy', 'xarray', 'pint', 'pydantic', "
        "'matplotlib', 'exudyn'} & set(sys.modules)))"
    )
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert shown.stdout.strip() == "[]"


def test_python_m_flexmech_is_flexmech() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "flexmech", "check", "nothing.toml"],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )
    assert shown.returncode == 2
    assert shown.stderr.startswith("error: nothing.toml: there is no such file")
    assert shown.stdout == ""


# --- angles and speeds ----------------------------------------------------------------------


@given(
    start=st.integers(-720, 720),
    steps=st.integers(0, 300),
    step=st.sampled_from(["5", "0.1", "0.25", "1e-1", "2.5", "0.3", "7"]),
    beyond=st.floats(0, 0.9),
)
def test_angle_ranges_are_counted_without_drift(
    start: int, steps: int, step: str, beyond: float
) -> None:
    size = float(step)
    # A stop between two steps is not hit, and changes nothing.
    stop = start + (steps + (beyond if beyond > 1e-3 else 0)) * size
    angles = ANGLES(f"{start}:{stop!r}:{step}")
    assert len(angles) == steps + 1
    assert angles[0] == start
    for number in (steps // 2, steps):
        assert angles[number] == pytest.approx(start + number * size, rel=1e-12, abs=1e-12)


def test_the_default_angles_are_whole_numbers_and_close_the_circle() -> None:
    assert ANGLES("0:360:5") == [5.0 * number for number in range(73)]
    assert ANGLES("0:360:0.1")[-2:] == [359.9, 360.0]
    assert ANGLES("0:1:0.333333") == [0.0, 0.333333, 0.666666, 1.0]
    assert ANGLES("0:360:7")[-1] == 357.0
    assert ANGLES("30:30:5") == [30.0]
    assert ANGLES("0,60,120.5") == [0.0, 60.0, 120.5]
    assert ANGLES(" 45 ") == [45.0]
    assert ANGLES("0:360:0.1 deg") == ANGLES("0:360:0.1")
    assert ANGLES("0,1.5 rad") == [0.0, 85.94366926962348]


@given(st.lists(st.floats(-720, 720), min_size=1, max_size=8, unique=True).map(sorted))
def test_angle_lists_are_taken_as_they_are(angles: list[float]) -> None:
    assert ANGLES(",".join(map(repr, angles))) == angles


@given(st.lists(st.integers(-1000, 1000), min_size=1, max_size=6, unique=True))
def test_speeds_are_sorted(speeds: list[int]) -> None:
    found = SPEEDS(",".join(map(str, speeds)))
    assert (found.numbers, found.unit) == (tuple(sorted(speeds)), "rad/s")


def test_speeds_mix_units() -> None:
    found = SPEEDS("300 rpm, 10 rad/s ,0")
    assert found.numbers == pytest.approx([0.0, 10.0, 31.41592653589793])
    assert found.unit == "rad/s"


def test_one_unit_covers_all_speeds() -> None:
    assert SPEEDS("0,50,100 rpm") == SPEEDS("0:100:50 rpm")
    assert SPEEDS("0,60,30 rpm").numbers == (0.0, 30.0, 60.0)


@given(st.text(alphabet="0123456789.,:e+- rpmad/s", max_size=12))
def test_any_text_is_angles_and_speeds_or_an_input_error(text: str) -> None:
    for parse, option in ((ANGLES, "--angles"), (SPEEDS, "--speeds")):
        try:
            values = parse(text)
        except InputError as error:
            message = str(error)
        else:
            message = option
            numbers = list(values.numbers if isinstance(values, Speeds) else values)
            assert numbers == sorted(set(numbers))
        assert message.startswith(option)


# --- with the real engines ----------------------------------------------------------------------


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "frequencies.csv").open(encoding="utf-8", newline="") as file:
        assert file.readline().strip() == COLUMNS
        return list(csv.DictReader(file, fieldnames=COLUMNS.split(",")))


@pytest.mark.parametrize("model", [STEEL, ARM], ids=["four-bar", "arm"])
def test_frequencies_writes_tables_and_pictures(model: str, tmp_path: Path) -> None:
    more = ("--speeds", "0,60 rpm", "--details", "--out", str(tmp_path))
    result = run("frequencies", model, *QUICK, *more)
    assert result.exit_code == 0, result.output
    damped = ["damping_ratio.png"] if model == ARM else []
    assert names(tmp_path) == sorted(DATA + PICTURES[1:] + damped)
    rows = rows_of(tmp_path)
    assert len(rows) == 2 * 3 * 2
    assert {row["engine"] for row in rows} == {"reference"}
    assert {float(row["crank_angle_deg"]) for row in rows} == {0.0, 60.0, 120.0}
    assert sorted({float(row["crank_speed_rad_s"]) for row in rows}) == pytest.approx(
        [0.0, 2 * np.pi]
    )
    assert "discretisation error" in result.stdout
    assert result.stdout.strip().split("\n")[-2].startswith("engines: no comparison was made")


def test_lowest_and_highest_in_the_table_are_those_of_the_file(tmp_path: Path) -> None:
    result = run(
        *("frequencies", STEEL, *QUICK, "--speeds", "0", "--no-plots"),
        *("--out", str(tmp_path)),
    )
    first = [float(row["frequency_Hz"]) for row in rows_of(tmp_path) if row["mode"] == "1"]
    row = next(line for line in result.stdout.split("\n") if "reference" in line).split()
    speed, mode, lowest, _, highest, _ = (word for word in row if word[0].isdigit())
    assert (float(speed), mode) == (0.0, "1")
    for printed, expected in ((lowest, min(first)), (highest, max(first))):
        assert printed == f"{expected:.{len(printed.partition('.')[2])}f}"


def test_both_engines_agree_and_the_last_line_says_where(tmp_path: Path) -> None:
    result = run(
        *("frequencies", STEEL, "--elements", "4", "--modes", "2", "--angles", "0,120"),
        *("--speeds", "0", "--out", str(tmp_path), "--details"),
    )
    assert result.exit_code == 0, result.output
    last = result.stdout.strip().split("\n")[-2]
    assert last.startswith("engines: reference and exudyn differ by at most")
    assert float(last.split("at most ")[1].split()[0]) < 1e-5
    assert names(tmp_path) == sorted(DATA + [name for name in PICTURES if "effect" not in name])


def test_axial_prestress_is_not_for_geometrically_exact_beams(tmp_path: Path) -> None:
    result = run(
        *("frequencies", STEEL, "--engine", "exudyn", "--element", "geometrically-exact"),
        *("--prestress", "axial", "--angles", "0", "--elements", "2", "--out", str(tmp_path)),
    )
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert names(tmp_path) == []


def test_angles_that_the_linkage_cannot_reach_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "rocker.toml"
    text = template("four-bar").replace('crank = "100 mm"', 'crank = "400 mm"')
    file.write_text(text, encoding="utf-8")
    result = run("frequencies", str(file), *QUICK, "--angles", "0:360:5", "--out", str(tmp_path))
    assert result.exit_code == 2
    assert "cannot be assembled at crank angle" in result.stderr
    assert names(tmp_path) == ["rocker.toml"]
    checked = run("check", str(file))
    assert checked.exit_code == 0
    assert "the crank does not turn fully" in checked.stdout


@pytest.mark.parametrize("file", MODEL_FILES, ids=lambda file: file.stem)
def test_check_tells_what_was_understood(file: Path) -> None:
    result = run("check", str(file), "--details")
    assert result.exit_code == 0, result.output
    mechanism = load_mechanism(file)
    # Of tables with many columns the words of a row stand in several lines of its cell.
    rows = [line.split("│") for line in result.stdout.splitlines() if line.startswith("│")]
    told = f"{result.stdout} {' '.join(row[1].strip() for row in rows)}"
    for word in (
        mechanism.provenance.name,
        mechanism.provenance.source,
        mechanism.provenance.sha256,
        "EI about the neutral axis (N m^2)",
        "damping time",
        "total mass",
        "operating speeds",
        "natural frequencies at rest, crank angle 0 deg",
    ):
        assert word in told
    for link in mechanism.linkage.topology.link_names:
        assert link in result.stdout


def test_check_of_the_aluminium_mechanism() -> None:
    """Frequencies of V1 of the validation numbers, to 3e-4 with 8 elements a link."""
    shown = run("check", ALUMINIUM, "--details").stdout
    assert "Grashof class: crank-rocker; the crank turns fully" in shown
    assert "ground 254 mm, crank 102 mm, coupler 279.4 mm, rocker 266.7 mm" in shown
    line = next(row for row in shown.split("\n") if row.startswith("natural frequencies"))
    found = [float(word) for word in line.split(": ")[1].split(" Hz")[0].split(", ")]
    assert found == pytest.approx([44.3115, 48.0842, 114.4693, 187.3841], rel=3e-4)
