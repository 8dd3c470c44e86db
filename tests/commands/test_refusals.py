"""Wrong model files and command lines: one line that names what is wrong and a remedy."""

from __future__ import annotations

import re
import shlex
import sys
import tomllib
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.modelfile import KINDS, mechanism_from_toml, template
from tests.support.command import MODELS

DATA = MODELS.parent / "tests" / "data"
TABLES = Path(__file__).parent


def text_of(model: str) -> str:
    """A template of ``flexmech new``, or a file among the data of the tests."""
    return template(model) if model in KINDS else (DATA / f"{model}.toml").read_text("utf-8")


def rows_of(table: str):
    return tomllib.loads((TABLES / table).read_text(encoding="utf-8"))


def refused(*words: str) -> str:
    """The message with which a command line is refused: a line, nothing printed beside it."""
    ended = CliRunner().invoke(app, list(words))
    assert ended.exit_code == 2, ended.output
    assert ended.stdout == ""
    assert ended.stderr.startswith("error: "), ended.stderr
    assert ended.stderr.count("\n") == 1
    assert "Traceback" not in ended.stderr
    return ended.stderr


MODEL_ROWS = [
    (model, *row) for model, rows in rows_of("refused_models.toml").items() for row in rows
]


@pytest.mark.parametrize(("model", "old", "new", "key", "remedy"), MODEL_ROWS)
def test_a_wrong_model_file_is_refused_by_its_key(model, old, new, key, remedy, tmp_path):
    text = text_of(model)
    old, new = old.replace("\\n", "\n"), new.replace("\\n", "\n")
    assert old in text
    file = tmp_path / "wrong.toml"
    changed = text.replace(old, new, 1) if old else f"{text}\n{new}\n"
    file.write_text(changed, encoding="utf-8")
    told = refused("check", str(file), "--out", str(tmp_path / "out"))
    assert told.startswith(f"error: {file}: ")
    where = told.removeprefix(f"error: {file}: ")
    # The key stands first, or first of one of several errors.
    if not key.startswith("line "):
        assert re.match(rf"(.* errors: )?(.* \| )?{re.escape(key)}[ :]", where), told
    assert key in where
    assert remedy in where.replace(key, "", 1)
    assert list(tmp_path.iterdir()) == [file]


COMMAND_ROWS = [
    (rows["common"], *row)
    for rows in rows_of("refused_commands.toml").values()
    for row in rows["rows"]
]


@pytest.mark.parametrize(("common", "words", "option", "remedy"), COMMAND_ROWS)
def test_a_wrong_command_line_is_refused_by_its_option(
    common, words, option, remedy, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    root = MODELS.parent
    typed = [
        str(root / word) if word.startswith(("models/", "tests/")) else word
        for word in shlex.split(f"{common} {words}")
    ]
    told = refused(*typed)
    assert option in told
    assert remedy in told.replace(option, "", 1)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("epoch", ["99999999999999", "1" * 40, "yesterday"])
def test_a_date_of_files_that_is_none_is_refused(epoch, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    words = ("section", str(MODELS / "steel_fourbar.toml"), "--out", str(tmp_path / "out"))
    assert refused(*words).startswith(f"error: SOURCE_DATE_EPOCH: got '{epoch}', which is no date")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["frequencies", "response"])
def test_without_exudyn_its_engine_is_refused(command, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    words = (command, str(MODELS / "steel_fourbar.toml"), "--out", str(tmp_path / "out"))
    told = refused(*words)
    assert "pip install exudyn" in told
    assert "--engine reference" in told


def test_a_command_that_left_names_its_successor():
    assert "scenarios/papers/elamy_2023.py" in refused("study", "composites")


def test_a_crank_that_cannot_turn_is_refused_with_the_angle(tmp_path):
    file = tmp_path / "rocker.toml"
    file.write_text(template("four-bar").replace('"100 mm"', '"400 mm"'), encoding="utf-8")
    for words in ("frequencies --speeds 1", "response --speed 1", "campbell --speeds 1,2,3"):
        command, *options = words.split()
        told = refused(command, str(file), *options, "--out", str(tmp_path / "out"))
        assert re.search(rf"{file}: .* crank angle -?\d+.* deg", told)
    assert list(tmp_path.iterdir()) == [file]
    assert CliRunner().invoke(app, ["check", str(file)]).exit_code == 0


@pytest.mark.parametrize("command", ["campbell", "stability", "response", "export"])
def test_a_model_without_a_speed_is_refused_with_the_option(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "model.toml"
    text = re.sub("crank_speeds = .*", "", template("four-bar"))
    file.write_text(text, encoding="utf-8")
    assert "--speed" in refused(command, str(file))
    assert list(tmp_path.iterdir()) == [file]


def test_files_that_are_no_model_are_refused(tmp_path):
    latin, empty = tmp_path / "latin.toml", tmp_path / "empty.toml"
    latin.write_bytes('name = "x"\nsource = "Müller"\n'.encode("latin-1"))
    assert "line 2" in refused("check", str(latin))
    empty.write_text("")
    told = refused("check", str(empty))
    assert told.startswith(f"error: {empty}: 2 errors: ")
    for key in ("linkage", "links"):
        assert f"{key}: " in told


def test_result_folders_that_cannot_be_written_are_refused_before_the_work(tmp_path):
    model, taken = tmp_path / "model.toml", tmp_path / "taken"
    model.write_text(template("four-bar"), encoding="utf-8")
    (taken / "frequencies" / "frequencies.csv").mkdir(parents=True)
    for out in (model, model / "below", tmp_path / ("x" * 300), taken):
        told = refused("frequencies", str(model), "--out", str(out))
        assert told.startswith("error: --out: ")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.toml", "taken"]


# --- empty paths --------------------------------------------------------------------------------

GROUP = typer.main.get_command(app)
COMMANDS = {name: GROUP.get_command(None, name) for name in GROUP.list_commands(None)}
PATHS = {"DIR", "FILE", "MODEL", "RECORD", "MODEL|RESULTS"}


@pytest.mark.parametrize("name", COMMANDS)
def test_an_empty_path_is_not_the_working_folder(name, tmp_path, monkeypatch):
    """As of a variable of the shell that is not set."""
    monkeypatch.chdir(tmp_path)
    parameters = COMMANDS[name].params
    paths = [number for number, one in enumerate(parameters) if one.metavar in PATHS]
    assert paths
    for number in paths:
        arguments = [
            "" if one is parameters[number] else "x"
            for one in parameters
            if one.param_type_name == "argument"
        ]
        if parameters[number].param_type_name == "option":
            arguments = [f"{parameters[number].opts[0]}=", *arguments]
        assert "empty" in refused(*name.split(), *arguments)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(flexmech.InputError, match="empty"):
        flexmech.load_mechanism("")


# --- rigid links --------------------------------------------------------------------------------


@pytest.fixture
def rigid(tmp_path):
    """A carton pusher of rigid links alone: its motion is known, and nothing vibrates."""
    elastic = r"(?m)^material = .*\nsection = .*\nin_plane_.*\nout_of_plane_.*\n"
    text = (MODELS / "carton_pusher.toml").read_text(encoding="utf-8")
    model = tmp_path / "rigid.toml"
    model.write_text(re.sub(elastic, 'rigid = true\nmass = "1 kg"\n', text), encoding="utf-8")
    return model


def test_vibrations_of_rigid_links_are_refused_and_their_motion_is_not(rigid, tmp_path):
    for words in (
        *("frequencies --engine both", "campbell --speeds 0,10", "response --speed 5", "hammer"),
        *("stability --speeds 10", "hammer --running 60", "export --speed 5"),
    ):
        command, *options = words.split()
        told = refused(command, str(rigid), *options)
        assert told.startswith(f"error: {rigid}: links: ")
        assert "flexmech kinematics" in told
    for command in ("check", "kinematics"):
        words = [command, str(rigid), "--no-plots", "--out", str(tmp_path / "out")]
        assert CliRunner().invoke(app, words).exit_code == 0
    mechanism = mechanism_from_toml(rigid.read_text(encoding="utf-8"))
    for engine in (flexmech.ReferenceEngine(mechanism, 2), flexmech.ExudynEngine(mechanism, 2)):
        with pytest.raises(flexmech.InputError, match="every link is rigid"):
            flexmech.natural_frequencies(engine, 0.0)
