"""Modes that nobody asked for by number: as many are given as there are, and it is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app

MODELS = Path(__file__).parents[2] / "models"
# With two modes that oscillate, and one element whose arm has three.
OVERDAMPED = ("slider_crank_free_shaft", ["--engine", "reference"], 2, "(overdamped)")
COARSE = ("rotating_arm", ["--engine", "reference", "--elements", "1"], 3, "the model has 3")


def run(*arguments: object):
    return CliRunner().invoke(app, [*map(str, arguments), "--no-plots", "--details"])


@pytest.mark.parametrize(("model", "options", "modes", "reason"), [OVERDAMPED, COARSE])
@pytest.mark.parametrize(
    "command", [["frequencies", "--angles", "0,90"], ["campbell", "--angles", "0,90"]]
)
def test_a_default_run_gives_as_many_modes_as_there_are(
    command, model, options, modes, reason, tmp_path
):
    name, *more = [command[0], MODELS / f"{model}.toml", *command[1:], "--speeds", "0,6", *options]
    done = run(name, *more, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    line = next(line for line in done.stdout.splitlines() if line.startswith("modes: "))
    assert line.startswith(f"modes: {modes} in the place of the usual 4, since ")
    assert reason in line
    kind = {
        "frequencies": flexmech.analyses.MovingFrequencies,
        "campbell": flexmech.analyses.CampbellDiagram,
    }[name]
    stored = kind.load(tmp_path / f"{name}.nc")
    assert stored.dataset.sizes["mode" if name == "frequencies" else "branch"] == modes
    assert line in stored.summary().lines
    refused = run(name, *more, "--modes", 4)
    assert refused.exit_code in (1, 2)
    assert reason in refused.stderr


def test_a_model_with_the_usual_modes_says_nothing(tmp_path):
    model = MODELS / "steel_fourbar.toml"
    done = run("frequencies", model, "--angles", "0", "--elements", "2", "--out", tmp_path)
    assert done.exit_code == 0
    assert "modes: " not in done.stdout


def test_python_gives_as_many_as_there_are():
    mechanism = flexmech.load_mechanism(MODELS / "slider_crank_free_shaft.toml")
    engine = flexmech.ReferenceEngine(mechanism)
    found = flexmech.natural_frequencies(engine, [0.0, 1.0])
    assert found.shape == (2, 2)
    assert found == pytest.approx(flexmech.natural_frequencies(engine, [0.0, 1.0], modes=2))
    with pytest.raises(flexmech.ComputationError, match="ask for no more than 2"):
        flexmech.natural_frequencies(engine, [0.0, 1.0], modes=4)


@pytest.mark.parametrize("command", [["stability", "--speeds", "10"], ["hammer", "--angle", "0"]])
def test_commands_that_keep_more_modes_take_those_there_are(command, tmp_path):
    name, *more = command
    done = run(name, MODELS / "rotating_arm.toml", *more, *COARSE[1], "--out", tmp_path)
    assert done.exit_code == 0, done.output


def test_a_crank_that_is_far_too_fast_for_its_links_is_refused_before_the_work(tmp_path):
    """Steps of a fortieth of the lowest frequency would be a million: it ran for hours."""
    text = (MODELS / "rotating_arm.toml").read_text(encoding="utf-8")
    model = tmp_path / "model.toml"
    model.write_text(text.replace('in_plane_thickness = "3 mm"', 'in_plane_thickness = "1 um"'))
    assert "1 um" in model.read_text()
    done = run("stability", model, "--speeds", "10,20", "--elements", "1")
    assert done.exit_code == 2
    assert "times the lowest natural frequency" in done.stderr
    assert done.stderr.count("\n") == 1
