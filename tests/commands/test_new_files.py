"""``flexmech new``, ``schema`` and ``export``: files to start from, and a script for Exudyn."""

from __future__ import annotations

import json
import math
import re
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.modelfile import KINDS, json_schema, mechanism_from_toml, new_file, template
from tests.support.command import MODELS


def new(*words: object):
    return CliRunner().invoke(app, ["new", *map(str, words)])


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_file_is_its_template_but_for_the_name(kind, tmp_path):
    file = tmp_path / "mine.toml"
    ended = new(kind, file)
    assert ended.exit_code == 0
    assert f"flexmech check {file}" in ended.stdout
    written = file.read_text(encoding="utf-8").split("\n")
    lines = zip(written, template(kind).split("\n"), strict=True)
    assert [line for line, other in lines if line != other] == ['name = "mine"']
    mechanism = flexmech.load_mechanism(file)
    assert mechanism.provenance.name == "mine"
    measured = any(section.specific_damping for section in mechanism.sections.values())
    assert measured != any("An assumption where no damping is measured" in line for line in written)


@pytest.mark.parametrize("kind", ["four-bar", "rotating-arm", "slider-crank", "planar"])
def test_a_new_linkage_is_damped_and_runs_as_in_every_turn(kind, tmp_path):
    """By 0.5 % of critical damping at its first natural frequency."""
    file = tmp_path / "mine.toml"
    assert new(kind, file).exit_code == 0
    turn = ("--engine", "reference", "--elements", "2", "--modes", "2", "--revolutions", "1")
    asked = ["response", str(file), *turn, "--out", str(tmp_path), "--no-plots"]
    assert CliRunner().invoke(app, asked).exit_code == 0
    run = flexmech.Response.load(tmp_path / "response" / "response.nc")
    assert (run.dataset.attrs["start"], run.dataset.attrs["damped"]) == ("periodic", 1)
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(file), 4)
    first = flexmech.natural_frequencies(engine, np.radians([0, 90, 180, 270]), modes=1).mean()
    times = [section.damping.bending for section in engine.mechanism.sections.values()]
    assert np.pi * first * times[-1] == pytest.approx(0.005, rel=0.1)


def test_an_example_keeps_its_name(tmp_path):
    file = tmp_path / "mine.toml"
    assert new("steel_fourbar", file).exit_code == 0
    assert file.read_bytes() == (MODELS / "steel_fourbar.toml").read_bytes()


def test_a_file_is_replaced_when_forced_alone(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("precious")
    refused = new("four-bar", file)
    assert refused.exit_code == 2
    assert "--force" in refused.stderr
    assert file.read_text() == "precious"
    assert new("four-bar", file, "--force").exit_code == 0
    assert flexmech.load_mechanism(file).linkage.crank == 0.1


def test_sizes_of_a_slider_crank_become_lengths_of_its_links(tmp_path):
    file = tmp_path / "press.toml"
    sizes = "--crank 40mm --rod 16cm --offset -5mm --mass 200g --speed 1500rpm"
    assert new("slider-crank", file, *sizes.split()).exit_code == 0
    mechanism = flexmech.load_mechanism(file)
    lengths = [link.length for link in mechanism.linkage.topology.links]
    assert lengths == pytest.approx([0.04, 0.16], rel=1e-14)
    assert mechanism.linkage.points["B"][1] == pytest.approx(-0.005, abs=1e-17)
    assert mechanism.joint_masses == {"B": 0.2}
    assert mechanism.operating_speeds == pytest.approx((50 * math.pi,))
    assert mechanism.speed_unit == "rpm"
    # As it was typed, and the comments where they stood.
    assert 'length = "16cm"' in file.read_text(encoding="utf-8")
    usual = mechanism_from_toml(template("slider-crank")).linkage.topology.links
    assert new("slider-crank", file, "--force", "--rod", "250 mm").exit_code == 0
    crank, rod = flexmech.load_mechanism(file).linkage.topology.links
    assert (crank.length, rod.length) == (usual[0].length, pytest.approx(0.25))


def test_a_terminal_is_asked_for_the_sizes_that_are_left_out():
    """An answer without a unit is asked for again."""
    asked = []

    def answer(words: str, usual: str) -> str:
        asked.append(usual)
        return ("10" if asked.count("300 rpm") == 1 else "10 rps") if "speed" in words else usual

    text = new_file("slider-crank", 'a "press"', {"rod": "250 mm"}, answer)
    assert asked == ["60 mm", "0 mm", "0.15 kg", "300 rpm", "300 rpm"]
    mechanism = mechanism_from_toml(text)
    assert (mechanism.speed_unit, mechanism.provenance.name) == ("rps", 'a "press"')


def test_a_new_study_runs_as_it_is_written(tmp_path):
    file, model = tmp_path / "study.toml", tmp_path / "aluminium_fourbar.toml"
    assert f"flexmech sweep {file}" in new("study", file).stdout
    assert model.read_bytes() == (MODELS / model.name).read_bytes()
    words = ["sweep", str(file), "--no-plots", "--out", str(tmp_path / "out")]
    assert CliRunner().invoke(app, words).exit_code == 0
    # A model of the same name is the user's.
    model.write_text("mine")
    assert new("study", file, "--force").exit_code == 0
    assert model.read_text() == "mine"


def test_the_schema_is_printed_or_written(tmp_path):
    printed = CliRunner().invoke(app, ["schema"])
    assert json.loads(printed.stdout) == json_schema()
    file = tmp_path / "schema.json"
    assert CliRunner().invoke(app, ["schema", "--out", str(file)]).exit_code == 0
    assert file.read_text(encoding="utf-8") == printed.stdout


def test_an_exported_script_names_its_steps_and_what_makes_them(tmp_path):
    """The whole script is run beside the engine elsewhere."""
    out = tmp_path / "script"
    words = ["--speed", "100 rpm", "--revolutions", "0.05", "--elements", "2", "--step", "1 ms"]
    model = str(MODELS / "steel_fourbar.toml")
    ended = CliRunner().invoke(app, ["export", model, *words, "--out", str(out)])
    assert ended.exit_code == 0, ended.stderr
    assert [path.name for path in out.iterdir()] == ["linkage.py"]
    text = (out / "linkage.py").read_text(encoding="utf-8")
    compile(text, "linkage.py", "exec")
    imported = set(re.findall(r"(?m)^(?:import|from) (\w+)", text))
    assert imported - sys.stdlib_module_names == {"exudyn", "numpy"}
    # 0.05 turns at 100 rpm take 30 ms.
    assert re.search(r"\b30 steps of 0\.001 s", ended.stdout)
