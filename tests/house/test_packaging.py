"""The package as it is installed: its names, its version, its models, and a start that is quick."""

from __future__ import annotations

import ast
import doctest
import importlib
import subprocess
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
import yaml

import flexmech
from tests.support.command import MODELS, run_command

PACKAGE = Path(flexmech.__file__).parent
ROOT = MODELS.parent
HEAVY = ("numpy", "xarray", "exudyn", "pint", "matplotlib")


def test_names_of_the_facade_load_when_first_used_and_are_those_of_its_types() -> None:
    assert set(flexmech.__all__) <= set(dir(flexmech))
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    assert {alias.asname for node in imports for alias in node.names} == set(flexmech.__all__)
    assert (PACKAGE / "py.typed").is_file()
    loaded = f"print([name for name in {HEAVY} if name in sys.modules])"
    script = f"import sys, flexmech, flexmech.cli.application; dir(flexmech); {loaded}"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=300
    )
    assert done.stdout.strip() == "[]", done.stderr


def test_the_program_starts_and_names_its_commands() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "flexmech", "--help"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    for command in ("frequencies", "campbell", "response", "check", "report", "verify"):
        assert command in done.stdout


def test_the_citation_is_of_this_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == flexmech.__version__ == version("flexmech")
    assert citation["license"] == project["license"]
    assert citation["title"].startswith(f"{project['name']}: ")
    names = [[author["name"] for author in of["authors"]] for of in (citation, project)]
    assert names[0] == names[1]
    for work in (citation, *citation["references"]):
        assert work["title"]
        assert all("name" in author or "family-names" in author for author in work["authors"])


def test_model_files_are_examples_which_new_copies(tmp_path: Path) -> None:
    files = sorted(MODELS.glob("*.toml"))
    assert flexmech.example_names() == tuple(path.stem for path in files)
    assert flexmech.example_model("steel_fourbar") == MODELS / "steel_fourbar.toml"
    copy = tmp_path / "mine.toml"
    assert run_command(tmp_path, "new", "moist_composite_fourbar", copy).exit_code == 0
    assert copy.read_bytes() == (MODELS / "moist_composite_fourbar.toml").read_bytes()
    refused = run_command(tmp_path, "new", "threebar", tmp_path / "x.toml")
    assert refused.exit_code == 2
    assert "threebar" in refused.stderr
    assert all(name in refused.stderr for name in (*flexmech.example_names(), "four-bar"))
    with pytest.raises(flexmech.InputError, match="did you mean 'steel_fourbar'"):
        flexmech.example_model("stel_fourbar")


def test_things_say_in_a_line_what_they_are_and_show_themselves_in_a_notebook() -> None:
    mechanism = flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml")
    engine = flexmech.ReferenceEngine(mechanism, 2)
    result = flexmech.moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1)
    things = (
        mechanism,
        mechanism.linkage,
        mechanism.sections["coupler"],
        engine,
        result,
        flexmech.analyses.FrequencyRequest([0.0], [0.0]),
        flexmech.RotationTerms.parse("coriolis"),
        flexmech.HygrothermalState(60.0, 0.04),
    )
    for thing in things:
        assert len(repr(thing)) <= 200
        assert "\n" not in repr(thing)
        assert " at 0x" not in repr(thing)
    for thing in (mechanism, result):
        page = thing._repr_html_()
        assert "<table" in page
        assert "data:image/png;base64," in page


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: flexmech.FourBar("0.1", 0.2, 0.3, 0.3), "ground|length"),
        (lambda: flexmech.ConstantSpeed("300 rpm"), "rad/s"),
        (lambda: flexmech.ReferenceEngine("model.toml"), "load_mechanism"),
        (lambda: flexmech.moving_frequencies("model.toml", [0.0], [0.0]), "ReferenceEngine"),
        (lambda: flexmech.analyses.ResponseRequest("fast"), "speed must be a number of rad/s"),
        (lambda: flexmech.Formulation("axial", "coriolis"), "RotationTerms.parse"),
        (lambda: flexmech.crank_rocker_synthesis(30, 90), "rad"),
    ],
)
def test_what_is_given_for_something_else_is_refused_with_its_remedy(call, words: str) -> None:
    with pytest.raises(flexmech.InputError, match=words):
        call()


@pytest.mark.thorough
def test_examples_of_docstrings_say_what_is_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every example of the package, with numpy and the package at hand."""
    monkeypatch.chdir(ROOT)
    finder = doctest.DocTestFinder(exclude_empty=True)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE, verbose=False)
    failed: list[str] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        if ">>>" not in path.read_text():
            continue
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        module = importlib.import_module(".".join(p for p in parts if p != "__init__"))
        for test in finder.find(module, extraglobs={"np": np, "flexmech": flexmech}):
            runner.run(test, out=failed.append)
    assert not failed, "".join(failed)
