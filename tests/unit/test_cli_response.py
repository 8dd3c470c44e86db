"""The response command with its real analysis, and what it refuses."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech.analyses.response.result import Response
from flexmech.cli import app
from flexmech.cli.typed import REVOLUTIONS, RUN_UP, SPEED, STEP
from flexmech.modelfile import template

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = str(MODELS / "aluminium_fourbar.toml")
ARM = str(MODELS / "rotating_arm.toml")
FOUR_BAR = template("four-bar")
DATA = ["response.csv", "response.nc", "summary.txt"]
COLUMNS = (
    "engine,time_s,crank_angle_deg,coupler_mid_deflection_m,rocker_mid_deflection_m,"
    "crank_tip_deflection_m,coupler_mid_strain,rocker_mid_strain,driving_torque_Nm,"
    "pin_A_x_N,pin_A_y_N,pin_B_x_N,pin_B_y_N,shaking_force_x_N,shaking_force_y_N,shaking_moment_Nm"
)
QUICK = ["--engine", "reference", "--speed", "20", "--revolutions", "0.1", "--elements", "2"]
QUICK += ["--samples", "120"]
NO_COMPARISON = "engines: no comparison was made, only the reference engine ran"


def run(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["response", *arguments, "--details"])


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def table_rows(text: str) -> list[list[str]]:
    """Cells of the rows of the printed table, without its headings."""
    rows = [line for line in text.split("\n") if line.startswith("│")]
    return [[cell.strip() for cell in row.strip("│").split("│")] for row in rows]


# --- with the real engines ------------------------------------------------------------------


def test_a_run_is_saved_and_reported(tmp_path: Path) -> None:
    result = run(ALUMINIUM, *QUICK, "--no-plots", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    assert names(tmp_path) == DATA
    text = (tmp_path / "response.csv").read_text(encoding="utf-8")
    assert text.split("\n")[0] == COLUMNS
    samples = list(csv.DictReader(text.split("\n")))
    assert len(samples) == 13
    assert float(samples[-1]["crank_angle_deg"]) == pytest.approx(36)

    lines = result.stdout.strip().split("\n")
    rows = table_rows(result.stdout)
    assert [row[:3] for row in rows] == [
        ["reference", "crank", "tip"],
        ["reference", "coupler", "middle"],
        ["reference", "rocker", "middle"],
    ]
    coupler = [float(sample["coupler_mid_deflection_m"]) for sample in samples]
    strain = [float(sample["coupler_mid_strain"]) for sample in samples]
    peak = int(np.argmax(np.abs(coupler)))
    _, _, _, deflection, degrees, turn, peak_strain, stress, along, _ = rows[1]
    # Greatest somewhat off the middle, and with the normal force.
    in_middle = 68.9e3 * 1e-6 * float(peak_strain)
    assert in_middle < float(stress) < 1.1 * in_middle
    assert 0.4 < float(along) / 279.4 < 0.7
    # Peaks lie between samples that are 3 degrees apart.
    assert 1e3 * abs(coupler[peak]) < float(deflection) < 1.02e3 * abs(coupler[peak])
    assert float(degrees) == pytest.approx(float(samples[peak]["crank_angle_deg"]), abs=1.5)
    assert turn == "1"
    assert 1e6 * np.abs(strain).max() <= float(peak_strain) < 1.02e6 * np.abs(strain).max()
    assert rows[0][6] == "-"
    for words in (
        "energy balance: off by at most",
        "constraint drift: at most",
        "time step: ",
        "error by the time step (estimated), of the link's peak: ",
        "peak driving torque: ",
        "peak joint forces: O2 ",
        "spectrogram: none, the run is too short",
    ):
        assert sum(line.startswith(words) for line in lines) in (1, 2), words
    assert not any(line.startswith("mesh:") for line in lines)
    assert lines[-1] == "files: " + ", ".join(str(tmp_path / name) for name in DATA)
    assert lines[-2] == NO_COMPARISON


def test_options_reach_the_run(tmp_path: Path) -> None:
    result = run(
        *(ALUMINIUM, "--speed", "-60 rpm", "--revolutions", "0.01", "--elements", "2"),
        *("--engine", "reference", "--step", "0.1 ms", "--run-up", "2 ms", "--check-mesh"),
        *("--modes", "2", "--start", "equilibrium", "--prestress", "none", "--no-plots"),
        *("--integrator", "generalized-alpha", "--out", str(tmp_path)),
    )
    assert result.exit_code == 0, result.output
    data = Response.load(tmp_path / "response.nc").dataset
    assert data.attrs["crank_speed"] == pytest.approx(-2 * np.pi)
    assert data.attrs["run_up_time"] == 0.002
    assert data.attrs["start"] == "equilibrium"
    assert data.attrs["prestress"] == "none"
    assert data.attrs["integrator"] == "generalized-alpha"
    assert data.attrs["elements"] == 2
    assert data["step"].values.tolist() == [1e-4]
    mesh = float(data["mesh_error_of_deflection"].sel(engine="reference", link="crank"))
    told = f"mesh: twice the elements change deflections, of the link's peak: {mesh:.1e} (crank)"
    assert told in result.stdout
    assert "time step: 0.0001 s (reference)" in result.stdout


def test_a_clamped_link_alone_has_no_pins(tmp_path: Path) -> None:
    result = run(
        *(ARM, "--speed", "5", "--revolutions", "0.05", "--run-up", "0.1 s", "--step", "1 ms"),
        *("--engine", "reference", "--elements", "2", "--modes", "1", "--no-plots"),
        *("--out", str(tmp_path)),
    )
    assert result.exit_code == 0, result.output
    header = (tmp_path / "response.csv").read_text(encoding="utf-8").split("\n")[0]
    assert header == (
        "engine,time_s,crank_angle_deg,arm_tip_deflection_m,driving_torque_Nm,"
        "crank_speed_rad_s,crank_acceleration_rad_s2,driving_power_W,"
        "shaking_force_x_N,shaking_force_y_N,shaking_moment_Nm"
    )
    ((engine, link, place, *_, strain, stress, along, _),) = table_rows(result.stdout)
    assert (engine, link, place, strain, along) == ("reference", "arm", "tip", "-", "0")
    assert float(stress) > 0


def test_two_engines_run_and_agree(tmp_path: Path) -> None:
    result = run(
        *(ALUMINIUM, "--speed", "20", "--revolutions", "0.05", "--elements", "4"),
        *("--samples", "120", "--no-plots", "--out", str(tmp_path)),
    )
    assert result.exit_code == 0, result.output
    assert len(table_rows(result.stdout)) in (3, 6)  # of both together, or of each
    drift = Response.load(tmp_path / "response.nc").dataset["constraint_drift"].values
    assert f"{drift[0]:.1e} m (reference), {drift[1]:.1e} m (exudyn)" in result.stdout
    last = result.stdout.strip().split("\n")[-2]
    assert last.startswith("engines: deflections of reference and exudyn differ by at most ")
    differences = re.findall(r"([\d.e+-]+) \(", last.split(" of the link's peak")[0])
    differences = [float(number) for number in differences]
    assert len(differences) == 3
    assert max(differences) < 0.02


def test_help_lists_the_options() -> None:
    shown = run("--help").stdout
    for option in (
        *("--speed ", "--revolutions", "--engine ", "--element ", "--elements ", "--start "),
        *("--step ", "--samples", "--prestress", "--integrator", "--run-up", "--check-mesh"),
        *("--modes", "--out", "--no-plots", "--animate"),
    ):
        assert option in shown


# --- wrong command lines --------------------------------------------------------------------

# Arguments after "response MODEL", and what the message on stderr must say.
WRONG_COMMAND_LINES = [
    (["--speed", "0"], "--speed: got '0', at which nothing turns; give a crank speed other"),
    (["--speed", "0 rpm"], "--speed: got '0 rpm'"),
    (["--speed", "nan"], "--speed: got 'nan'"),
    (["--speed", "fast"], "--speed: got 'fast'.*\"20 rad/s\""),
    (["--speed", "10,20"], "--speed: got '10,20'"),
    (["--speed", "5 Hz"], '--speed: .*is a frequency.*"5 rps"'),
    (["--speed", "1e999"], "--speed: .*too large"),
    (["--speeds", "10"], "No such option.*--speed"),
    (["--revolutions", "0"], "--revolutions: got '0', which is not positive; write how many"),
    (["--revolutions", "-1"], "--revolutions: got '-1', which is not positive"),
    (["--revolutions", "nan"], "--revolutions: got 'nan'.*write a number"),
    (["--revolutions", "many"], "--revolutions: got 'many'"),
    (["--revolutions", "1e9"], "--revolutions.*take .* samples, more than 2000000; ask for fewer"),
    (["--revolutions", "1e-4"], "--revolutions, .*shorter than .* between two samples; ask"),
    (["--samples", "7"], "--samples.*greater than or equal to 8"),
    (["--samples", "many"], "--samples"),
    (["--step", "0"], "--step: got '0', which is not positive; write a time.* or auto"),
    (["--step", "-1 ms"], "--step: got '-1 ms', which is not positive"),
    (["--step", "fast"], "--step: got 'fast'.*write a time.*, or auto"),
    (["--step", "1 Hz"], "--step: .*not that of a time"),
    (["--step", "nan"], "--step: got 'nan'"),
    (["--step", "5"], "--step: .*5 s is longer than the run of 1.25664 s; choose a shorter"),
    (["--elements", "0"], "--elements"),
    (["--modes", "0"], "--modes"),
    (["--start", "resting"], "--start.*'rigid', 'equilibrium', 'periodic'"),
    (["--start", "periodic", "--run-up", "0.1"], "--start periodic needs.*leave --run-up out"),
    (["--run-up", "-0.1"], "--run-up: got '-0.1', which is negative"),
    (["--run-up", "slow"], "--run-up: got 'slow'.*write a time"),
    (["--run-up", "1e5"], "--run-up.*samples, more than"),
    (["--prestress", "some"], "--prestress.*'none', 'axial', 'equilibrium'"),
    (["--integrator", "euler"], "--integrator.*'trapezoidal', 'generalized-alpha'"),
    (["--engine", "ansys"], "--engine.*'reference', 'exudyn', 'both'"),
    (
        ["--engine", "reference", "--element", "ancf"],
        "--element ancf .*engine, which has euler, .*, reddy, zigzag; choose --engine exudyn",
    ),
    (["--engine", "exudyn", "--element", "euler"], "which has ancf, geometrically-exact"),
    (["another.toml"], "[Uu]nexpected extra argument"),
]


@pytest.mark.parametrize(("arguments", "message"), WRONG_COMMAND_LINES, ids=str)
def test_wrong_command_lines_are_refused(
    arguments: list[str], message: str, tmp_path: Path
) -> None:
    speed = [] if not arguments or arguments[0].startswith("--speed") else ["--speed", "20"]
    out = tmp_path / "out"
    result = run(ALUMINIUM, *speed, *arguments, "--out", str(out))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert re.search(message, " ".join(result.stderr.split())), result.stderr
    assert "Traceback" not in result.stderr
    assert not out.exists()


ROCKERS = {
    # Neither the shortest nor the longest link can turn round; it starts and then sticks.
    "triple-rocker": ("400 mm", "200 mm", "280 mm", "265 mm"),
    # A short coupler: the crank cannot even stand at zero.
    "double-rocker": ("300 mm", "250 mm", "100 mm", "260 mm"),
}


@pytest.mark.parametrize("kind", ROCKERS)
def test_a_crank_that_cannot_turn_round_is_refused(kind: str, tmp_path: Path) -> None:
    text = FOUR_BAR
    for link, length in zip(("ground", "crank", "coupler", "rocker"), ROCKERS[kind], strict=True):
        text = re.sub(rf'^{link} = ".*?"', f'{link} = "{length}"', text, flags=re.MULTILINE)
    file = tmp_path / "rocker.toml"
    file.write_text(text, encoding="utf-8")
    result = run(str(file), *QUICK, "--revolutions", "1", "--out", str(tmp_path / "out"))
    assert result.exit_code == 2
    assert re.match(r"error: .*rocker.toml: the linkage .* at crank angle -?\d", result.stderr), (
        result.stderr
    )
    assert kind in result.stderr
    assert result.stderr.count("\n") == 1
    assert names(tmp_path) == ["rocker.toml"]


def test_models_and_folders_that_are_not_right_are_refused_at_once(tmp_path: Path) -> None:
    result = run("nothing.toml", *QUICK)
    assert result.exit_code == 2
    assert result.stderr.startswith("error: nothing.toml: there is no such file")
    taken = tmp_path / "taken"
    (taken / "animation.gif").mkdir(parents=True)
    (taken / "forces.png").mkdir()
    for out, options, message in (
        (Path(ALUMINIUM), [], r"cannot write to .*\(Not a directory\); choose a folder"),
        (taken, [], r"forces\.png is a folder there; remove it"),
        (taken, ["--no-plots", "--animate"], r"animation\.gif is a folder there; remove it"),
    ):
        result = run(ALUMINIUM, *QUICK, *options, "--out", str(out))
        assert result.exit_code == 2
        assert re.search(rf"error: --out.*{message}", result.stderr), result.stderr
    assert names(taken) == ["animation.gif", "forces.png"]


# --- what is typed --------------------------------------------------------------------------


def test_what_is_typed_becomes_numbers_and_a_unit() -> None:
    backwards, forwards = SPEED("-300 rpm"), SPEED("20")
    assert (backwards.single, backwards.unit) == (-300.0, "rpm")
    assert (forwards.single, forwards.unit) == (20.0, "rad/s")
    assert REVOLUTIONS("0.25") == 0.25
    assert STEP("auto") is None
    assert STEP("1e-4") == 1e-4
    assert STEP("0.1 ms") == 1e-4
    assert RUN_UP("0") == 0.0
    assert RUN_UP("50 ms") == 0.05
