"""Every block of code in the README and in the documentation runs, page by page.

Cells of notebooks are run when the pages are built, where an error ends the build; .ci/run builds
them afresh. All other blocks run here.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
import tomli_w

from flexmech.modelfile import mechanism_from_toml
from tests.documentation.pages import REPOSITORY, blocks_of, written_pages

RUN = ("python", "sh", "toml")
PAGES = [page for page in written_pages() if {b.language for b in blocks_of(page)} & set(RUN)]
# What is shown, not run here: cells, output of a program, formulas, and the commands and changes
# of sessions, which test_sessions runs.
SHOWN = ("cell", "text", "", "math", "console", "diff")
# Parts of a command line that set flexmech up; .ci/run does, in an environment of its own.
SETTING_UP = ("python3 -m venv", ".venv/bin/pip install", "python -m pip install", ". .venv/bin")
# What .ci/run itself runs, and what shows a window or serves pages.
RUN_BY_CI = ("-m pytest", "pytest", "ruff", "mypy", "python docs/build.py", "python -m build")


def test_pages_are_found() -> None:
    names = {page.name for page in PAGES}
    assert {"README.md", "CONTRIBUTING.md", "start.md", "own_linkage.md"} <= names


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_languages_are_known(page: Path) -> None:
    languages = {block.language for block in blocks_of(page)}
    directives = {language for language in languages if language.startswith("{")}
    assert languages - directives <= {*RUN, *SHOWN}


@pytest.mark.thorough
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("models", "scenarios", "docs", "tests"):
        (tmp_path / name).symlink_to(REPOSITORY / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    plt.switch_backend("Agg")
    names: dict[str, Any] = {"__name__": "__main__"}
    model = tomllib.loads((REPOSITORY / "models" / "aluminium_fourbar.toml").read_text())
    for block in blocks_of(page):
        if block.language == "sh":
            for line in command_lines(block.text):
                run_command_line(line)
        elif block.language == "toml":
            model = with_the_rest(model, block.text)
            mechanism_from_toml(tomli_w.dumps(model))
        elif block.language == "python":
            exec(compile(block.text, str(page), "exec"), names)
    plt.close("all")


def command_lines(text: str) -> list[str]:
    lines = text.replace("\\\n", " ").splitlines()
    return [line.strip() for line in lines if line.strip() and not line.startswith("#")]


def run_command_line(line: str) -> None:
    """Run the parts of a command line that are flexmech or Python."""
    for part in line.split("&&"):
        words = shlex.split(part, comments=True)
        command = " ".join(words)
        if command.startswith(SETTING_UP) or any(known in command for known in RUN_BY_CI):
            continue
        program = Path(words[0]).name
        assert program in ("flexmech", "python"), f"nothing runs {command!r}"
        module = ["-m", "flexmech"] if program == "flexmech" else []
        run = subprocess.run(
            [sys.executable, *module, *words[1:]],
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        )
        assert run.returncode == 0, f"{command}: {run.stderr}"


def with_the_rest(model: dict[str, Any], text: str) -> dict[str, Any]:
    """Model file with a part of a page in it; a drawn linkage begins a file of its own."""
    part = tomllib.loads(text)
    if part.get("linkage", {}).get("kind") == "planar":
        return {"name": "linkage of this page", "source": "this page", **part}
    return merged(model, part)


def merged(whole: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """Tables of both; where both state a value, that of the part.

    A link that states its section is stated whole: other sections have other keys.
    """
    result = dict(whole)
    for key, entry in part.items():
        both = isinstance(entry, dict) and isinstance(whole.get(key), dict)
        both = both and "section" not in entry
        result[key] = merged(whole[key], entry) if both else entry
    return result
