"""An empty path, as of a variable of the shell that is not set, is not the working folder."""

from __future__ import annotations

import pytest
import typer
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app

PATHS = {"DIR", "FILE", "MODEL", "RECORD", "MODEL|RESULTS"}
GROUP = typer.main.get_command(app)
COMMANDS = {name: GROUP.get_command(None, name) for name in GROUP.list_commands(None)}
COMMANDS |= {f"study {name}": each for name, each in COMMANDS.pop("study").commands.items()}
PLACES = [
    (name, number)
    for name, command in COMMANDS.items()
    for number, parameter in enumerate(command.params)
    if parameter.metavar in PATHS
]


def test_every_command_takes_a_path():
    assert {name for name, _ in PLACES} == set(COMMANDS)


@pytest.mark.parametrize(("name", "number"), PLACES)
def test_an_empty_path_is_refused(name, number):
    parameters = COMMANDS[name].params
    typed = ["" if each is parameters[number] else "x" for each in parameters]
    given = [
        text
        for each, text in zip(parameters, typed, strict=True)
        if each.param_type_name == "argument"
    ]
    if parameters[number].param_type_name == "option":
        given = [f"{parameters[number].opts[0]}=", *given]
    done = CliRunner().invoke(app, [*name.split(), *given])
    assert done.exit_code == 2
    assert "it is empty; name a file or folder, or write . for the working folder" in done.stderr
    assert done.stderr.count("\n") == 1


def test_an_empty_path_is_refused_in_python():
    with pytest.raises(flexmech.InputError, match="path is empty"):
        flexmech.load_mechanism("")
