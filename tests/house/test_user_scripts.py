"""A script of a user for each question: ten lines, with public names alone, that print and draw."""

from __future__ import annotations

import ast
import os
import runpy
import shutil
from pathlib import Path

import pytest

import flexmech
from tests.support.command import MODELS

SCRIPTS = sorted((Path(__file__).parents[1] / "user_scripts").glob("*.py"))
MOST_LINES = 10
# Run by default; what the other scripts compute is tested elsewhere.
QUICK = {"check", "coupler_path", "kinematics", "laminate"}
# It prints plain numbers.
WITHOUT_A_PICTURE = {"laminate"}


def test_each_question_has_its_script() -> None:
    analyses = Path(flexmech.__file__).parent / "analyses"
    questions = {path.parent.name for path in analyses.glob("*/compute.py")}
    assert questions <= {path.stem for path in SCRIPTS}


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=[pytest.mark.thorough] * (p.stem not in QUICK)) for p in SCRIPTS],
    ids=lambda path: path.stem,
)
def test_a_script_answers_its_question(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = path.read_text()
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    assert len(lines) <= MOST_LINES
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import | ast.ImportFrom):
            assert isinstance(node, ast.Import)
            assert {alias.name for alias in node.names} <= {"numpy", "flexmech"}
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "flexmech":
            assert node.attr in flexmech.__all__
    shutil.copytree(MODELS, tmp_path / "models")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(os.environ, "MPLBACKEND", "Agg")
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out.strip()
    pictures = list(tmp_path.glob("*.png"))
    assert len(pictures) == (path.stem not in WITHOUT_A_PICTURE)
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
