"""What is said of the package, and the model files that come with it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import get_args

import pytest
import yaml
from typer.testing import CliRunner

import flexmech
from flexmech import example_models
from flexmech.choices import TemplateKind
from flexmech.cli import app

ROOT = Path(__file__).parents[2]
MODEL_FILES = sorted((ROOT / "models").glob("*.toml"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_the_citation_is_of_this_package() -> None:
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["version"] == flexmech.__version__
    assert CITATION["license"] == PROJECT["license"]
    assert CITATION["title"].startswith(f"{PROJECT['name']}: ")
    assert [author["name"] for author in CITATION["authors"]] == [
        author["name"] for author in PROJECT["authors"]
    ]


@pytest.mark.parametrize("work", [CITATION, *CITATION["references"]], ids=lambda w: w["title"][:30])
def test_a_cited_work_has_what_the_format_requires(work: dict[str, object]) -> None:
    """Of Citation File Format 1.2: authors, each with a name, and a title."""
    authors = work["authors"]
    assert isinstance(authors, list)
    assert authors
    assert all("name" in author or "family-names" in author for author in authors)
    assert work["title"]
    assert {"cff-version", "message"} <= work.keys() if work is CITATION else "type" in work


def test_what_is_said_of_the_package_is_so() -> None:
    assert "urls" not in PROJECT, "this project has no address yet"
    said = [line.rpartition(" :: ")[2] for line in PROJECT["classifiers"]]
    assert PROJECT["requires-python"] == ">=3.11"
    assert "3.11" in said
    assert ("Typed" in said) == (ROOT / "flexmech" / "py.typed").is_file()


def test_every_model_file_is_an_example() -> None:
    assert flexmech.example_names() == tuple(path.stem for path in MODEL_FILES)
    for path in MODEL_FILES:
        assert flexmech.example_model(path.stem) == path


def test_models_inside_the_package_come_before_those_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a wheel lays them."""
    monkeypatch.setattr(example_models.resources, "files", lambda _: tmp_path)
    (tmp_path / "models").mkdir()
    assert example_models._folder.__wrapped__() == tmp_path / "models"
    (tmp_path / "models").rmdir()
    assert example_models._folder.__wrapped__() == tmp_path.parent / "models"


def test_an_unknown_example_is_told_with_the_known_ones() -> None:
    with pytest.raises(flexmech.InputError, match=r"did you mean 'steel_fourbar'\? Known here: al"):
        flexmech.example_model("stel_fourbar")


def test_new_copies_an_example_with_its_comments(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    result = CliRunner().invoke(app, ["new", "moist_composite_fourbar", str(file)])
    assert result.exit_code == 0
    assert "#" in file.read_text(encoding="utf-8")
    assert file.read_bytes() == (ROOT / "models" / "moist_composite_fourbar.toml").read_bytes()


def test_new_lists_all_kinds_and_examples(tmp_path: Path) -> None:
    names = (*get_args(TemplateKind), *flexmech.example_names())
    shown = CliRunner().invoke(app, ["new", "--help"], terminal_width=1000)
    assert all(name in "".join(shown.stdout.split()) for name in names)
    refused = CliRunner().invoke(app, ["new", "threebar", str(tmp_path / "x.toml")])
    assert refused.exit_code == 2
    assert refused.stderr.startswith("error: there is no kind of linkage and no example 'threebar'")
    assert all(name in refused.stderr for name in names)
    assert not list(tmp_path.iterdir())
