"""What commands print: words that fit the terminal, JSON for scripts, or nothing."""

from __future__ import annotations

import json
from io import StringIO
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from flexmech.analyses import Summary, Table
from flexmech.cli import app
from flexmech.cli.deliver import say

STEEL = Path(__file__).parents[2] / "models" / "steel_fourbar.toml"


def test_quiet_prints_warnings_alone(tmp_path: Path) -> None:
    told = CliRunner().invoke(app, ["check", str(STEEL), "--quiet", "--out", str(tmp_path)])
    assert told.exit_code == 0
    assert told.stdout == ""
    assert told.stderr.startswith("warning: ")
    assert "check.csv" in {file.name for file in tmp_path.iterdir()}


def test_json_is_the_summary_for_scripts(tmp_path: Path) -> None:
    arguments = [str(STEEL), "--link", "crank", "--no-plots", "--out", str(tmp_path), "--json"]
    told = CliRunner().invoke(app, ["section", *arguments])
    said = json.loads(told.stdout)
    keys = {"answer", "numbers", "table", "trust", "warnings", "details", "files"}
    assert set(said) == keys
    names = [Path(file).name for file in said["files"]]
    assert names[-2:] == ["sections.nc", "summary.txt"]


def test_json_and_quiet_are_not_given_together() -> None:
    told = CliRunner().invoke(app, ["check", str(STEEL), "--quiet", "--json"])
    assert (told.exit_code, told.stdout) == (2, "")
    assert told.stderr == "error: --details, --quiet and --json: give one of them\n"


@pytest.mark.parametrize(("name", "numbers"), [("reference", 5), ("a" * 60, 3)])
def test_numbers_of_tables_are_whole_at_80_columns(
    name: str, numbers: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names and headings may break into lines."""
    monkeypatch.setenv("COLUMNS", "80")
    row = (name, *(f"-1{number}34.567" for number in range(numbers)))
    headings = ("engine", *(f"normal stress of {number} (MPa)" for number in range(numbers)))
    say(Summary((), Table("stresses", headings, ((row,),))))
    lines = capsys.readouterr().out.splitlines()
    assert all(any(cell in line for line in lines) for cell in row[1:])
    assert max(map(len, lines)) <= 80


def test_lines_wrap_at_words_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    terminal = StringIO()
    terminal.isatty = lambda: True  # type: ignore[method-assign]
    words = " ".join(f"word{n}" for n in range(40))
    monkeypatch.setattr("sys.stdout", terminal)
    say(Summary((words,)))
    lines = terminal.getvalue().splitlines()
    assert max(map(len, lines)) <= 60
    assert " ".join(line.strip() for line in lines) == words


def test_shells_complete_commands_and_options() -> None:
    asked = {"_FLEXMECH_COMPLETE": "complete_bash"}
    for words, expected in (("flexmech fre", "frequencies"), ("flexmech check --qu", "--quiet")):
        place = str(words.count(" "))
        environment = {**asked, "COMP_WORDS": words, "COMP_CWORD": place}
        told = CliRunner().invoke(app, env=environment, prog_name="flexmech")
        assert told.stdout.split() == [expected]


def test_help_lists_commands_without_building_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(command: object) -> None:
        raise AssertionError(f"{command} was built")

    monkeypatch.setattr("flexmech.cli.application.from_options", fail)
    with pytest.raises(SystemExit) as ended:
        typer.main.get_command(app)(["--help"])
    assert ended.value.code == 0
    printed = capsys.readouterr().out
    assert "Moving natural frequencies of a mechanism." in printed
    assert "Run a whole campaign" in printed


def test_a_wrong_command_is_compared_with_all(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        typer.main.get_command(app)(["frequencie"])
    assert ended.value.code == 2
    assert "Did you mean 'frequencies'" in capsys.readouterr().err
