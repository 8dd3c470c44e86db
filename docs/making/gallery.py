"""The gallery: every scenario with what it prints and draws, and its numbers held.

Each runs in a folder, on coarser settings where it takes minutes; what it found is held against
``scenarios/expected_numbers.toml``. A campaign takes so long that a build runs it only when asked:
its page shows what it gave last, which stands in ``docs/kept/``.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from making.scenario_numbers import KEPT, SCENARIOS, expected_numbers
from making.state import REPOSITORY, cache_folder, environment

__all__ = [
    "CAMPAIGNS",
    "gallery_pages",
    "keep_campaign",
    "scenario_failures",
    "scenario_names",
    "scenario_results",
]

PRINTED = "printed.txt"
CAMPAIGNS = {
    "20_lightest_stable_fourbar": "six minutes of processor time",
    "21_least_mass_fourbar": "two minutes of processor time",
    "papers/elamy_best_stacking": "two minutes of processor time",
}
"""Scenarios that a build does not run, and what they take."""
LAST = REPOSITORY / "docs" / "kept"
"""Folder of what campaigns gave last."""

HEAD = """# Gallery

Each entry is a question, a script of public names that answers it (`scenarios/`), what it prints
and draws when these pages are built, and one number of it that each build holds. Every figure and
table of the three papers that this project starts from has its place beside ours in [figures and
tables of the papers](../../figures_of_the_papers.md).

"""


@dataclass(frozen=True)
class Scenario:
    """A script, its words and the number that is held."""

    name: str
    question: str
    text: str
    expected: dict[str, Any]

    @property
    def page(self) -> str:
        """Name of its page, and of the folder of its pictures."""
        return Path(self.name).name


def gallery_pages(folder: Path) -> dict[str, str]:
    """Put the pictures of the scenarios into a folder; Markdown by the name of the page."""
    scenarios = _scenarios()
    results = [scenario_results(scenario.name) for scenario in scenarios]
    pages = {"gallery/index.md": _index(scenarios)}
    for scenario, result in zip(scenarios, results, strict=True):
        shutil.copytree(result, folder / scenario.page, dirs_exist_ok=True)
        pages[f"gallery/{scenario.page}.md"] = _page(scenario, result)
    return pages


def scenario_names() -> list[str]:
    """Scripts by their place in ``scenarios`` without the ending, in the order of the gallery.

    Raises
    ------
    RuntimeError
        If a script that asks a question has no expected numbers, or numbers have no script.
    """
    names = list(expected_numbers())
    asking = {
        path.relative_to(SCENARIOS).with_suffix("").as_posix()
        for path in SCENARIOS.rglob("*.py")
        if _docstring(path).partition("\n")[0].endswith("?")
    }
    if odd := set(names) ^ asking:
        raise RuntimeError(f"scenarios without a script or without expected numbers: {odd}")
    return names


def _docstring(script: Path) -> str:
    return ast.get_docstring(ast.parse(script.read_text())) or ""


def _scenarios() -> list[Scenario]:
    found = []
    for name, expected in expected_numbers().items():
        question, _, rest = _docstring(SCENARIOS / f"{name}.py").partition("\n\n")
        text = "\n\n".join(part for part in rest.split("\n\n") if not part.startswith("    "))
        found.append(Scenario(name, question, text, expected))
    return found


def scenario_results(name: str) -> Path:
    """Folder of what a scenario printed and drew; it runs only if the folder is not there yet."""
    if name in CAMPAIGNS:
        return LAST / name
    expected = expected_numbers()[name]
    settings = json.dumps({key: expected.get(key) for key in ("number", "also", "coarser")})
    digest = hashlib.sha256(settings.encode()).hexdigest()[:8]
    folder = cache_folder() / f"gallery-{digest}" / name
    if not (folder / PRINTED).exists():
        _run(name, folder)
    return folder


def keep_campaign(name: str) -> None:
    """Run a campaign and keep what it gives in the repository."""
    _run(name, LAST / name)
    for left in (LAST / name).iterdir():
        if left.is_dir():
            shutil.rmtree(left)
        elif left.suffix not in (".png", ".json", ".txt"):
            left.unlink()


def _run(name: str, folder: Path) -> None:
    started = folder.with_name(f"{folder.name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    started.parent.mkdir(parents=True, exist_ok=True)
    folders = (SCENARIOS / "papers", REPOSITORY / "docs", REPOSITORY)
    run = subprocess.run(
        [sys.executable, "-m", "making.scenario_numbers", name, str(started)],
        capture_output=True,
        text=True,
        cwd=REPOSITORY,
        env=environment() | {"PYTHONPATH": os.pathsep.join(map(str, folders))},
    )
    if run.returncode:
        raise RuntimeError(f"scenarios/{name}.py failed: {run.stderr.strip()}")
    (started / PRINTED).write_text(run.stdout)
    shutil.rmtree(folder, ignore_errors=True)
    started.rename(folder)


def scenario_failures(name: str) -> list[str]:
    """Numbers of a scenario that are not the expected ones, or how it failed."""
    expected = expected_numbers()[name]
    wanted = {words: found for words, (_, *found) in expected.get("also", {}).items()}
    wanted["number"] = [expected["value"], expected["tolerance"]]
    try:
        numbers = json.loads((scenario_results(name) / KEPT).read_text())
    except RuntimeError as error:
        return [str(error)]
    failures = [f"no number {words!r}" for words in wanted.keys() - numbers.keys()]
    failures += [f"{words!r} is not expected" for words in numbers.keys() - wanted.keys()]
    for words in wanted.keys() & numbers.keys():
        if not _is_expected(numbers[words], wanted[words]):
            failures.append(f"{words}: {numbers[words]}, expected {wanted[words]}")
    return [f"scenarios/{name}.py: {failure}" for failure in sorted(failures)]


def _is_expected(found: Any, wanted: list[Any]) -> bool:
    """Whether numbers are within a tolerance (value, tolerance), or words are the same."""
    if len(wanted) == 1:
        return bool([found] == wanted)
    values, tolerance = wanted
    return bool(np.all(np.abs(np.subtract(found, values)) <= tolerance))


def _index(scenarios: list[Scenario]) -> str:
    cards = [
        f"## [{one.question}]({one.page}.md)\n\n"
        f"[![{one.question}]({one.page}/{one.expected['picture']}){{width=75%}}]({one.page}.md)\n"
        for one in scenarios
    ]
    entries = "\n".join(one.page for one in scenarios)
    toctree = f"```{{toctree}}\n:hidden:\n\n{entries}\n```\n"
    return HEAD + "\n".join(cards) + "\n" + toctree


def _page(scenario: Scenario, result: Path) -> str:
    expected = scenario.expected
    unit = "" if expected["unit"] == "1" else f" {expected['unit']}"
    script = f"scenarios/{scenario.name}.py"
    pictures = sorted(path.name for path in result.glob("*.png"))
    pictures.sort(key=lambda name: name != expected["picture"])
    drawn = "\n\n".join(
        f"![{name.removesuffix('.png').replace('_', ' ')}]({scenario.page}/{name})"
        for name in pictures
    )
    return (
        f"# {scenario.question}\n\n{scenario.text}\n\n"
        f"**Held by every build:** {expected['quantity']}: {expected['value']}{unit}, within "
        f"{expected['tolerance']}{unit}.\n\n{_how_it_ran(scenario)}"
        f"    python {script}\n\n{drawn}\n\n## What it prints\n\n"
        f"```text\n{(result / PRINTED).read_text()}```\n\n## The script\n\n"
        f"```{{literalinclude}} ../../../{script}\n:language: python\n```\n"
    )


def _how_it_ran(scenario: Scenario) -> str:
    if scenario.name in CAMPAIGNS:
        return (
            f"It takes {CAMPAIGNS[scenario.name]}: this page shows what it gave when it last ran, "
            "by `python docs/build.py --campaigns`.\n\n"
        )
    if coarser := scenario.expected.get("coarser"):
        settings = ", ".join(f"`{name} = {value}`" for name, value in coarser.items())
        return f"For this page it ran on coarser settings than it takes alone: {settings}.\n\n"
    return ""
