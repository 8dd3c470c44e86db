"""The gallery: every scenario with what it prints and draws, and its numbers held.

Each runs by its ``main``, on coarser settings where it takes minutes; what it found is held against
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
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from making.scenario_numbers import COARSER, KEPT, NUMBERS
from making.state import REPOSITORY, cache_folder, environment

__all__ = [
    "CAMPAIGNS",
    "gallery_pages",
    "keep_campaign",
    "scenario_failures",
    "scenario_names",
    "scenario_results",
]

SCENARIOS = REPOSITORY / "scenarios"
SETTINGS = Path(__file__).with_name("scenario_numbers.py")
PRINTED = "printed.txt"
CAMPAIGNS = {
    "best_stacking_under_scatter": "two minutes of processor time",
    "least_mass_fourbar": "two minutes of processor time",
    "lightest_stable_fourbar": "six minutes of processor time",
}
"""Scenarios that a build does not run, and what they take."""
LAST = REPOSITORY / "docs" / "kept"
"""Folder of what campaigns gave last."""

HEAD = """# Gallery

Each entry is a question, a script of public names that answers it (`scenarios/`), what it prints
and draws when these pages are built, and one number of it that each build holds. Every figure and
table of the three papers that this project starts from has its place beside ours in [figures and
tables of the papers](../figures_of_the_papers.md).

"""


@dataclass(frozen=True)
class Scenario:
    """A script, its words and the number that is held."""

    name: str
    question: str
    text: str
    expected: dict[str, Any]


def gallery_pages(folder: Path) -> dict[str, str]:
    """Put the pictures of the scenarios into a folder; Markdown by the name of the page."""
    scenarios = _scenarios()
    results = [scenario_results(scenario.name) for scenario in scenarios]
    pages = {"gallery/index.md": _index(scenarios)}
    for scenario, result in zip(scenarios, results, strict=True):
        shutil.copytree(result, folder / scenario.name, dirs_exist_ok=True)
        pages[f"gallery/{scenario.name}.md"] = _page(scenario, result)
    return pages


def scenario_names() -> list[str]:
    """Names of the scenarios, in the order of the gallery.

    Raises
    ------
    RuntimeError
        If a script has no expected number, or nothing takes its numbers.
    """
    names = list(_expected_numbers())
    for other in (NUMBERS, _scripts()):
        if odd := set(names) ^ set(other):
            raise RuntimeError(f"scenarios without a script, numbers or expected ones: {odd}")
    return names


def _scripts() -> dict[str, Path]:
    """Scripts by their names; those that put a paper to the test lie in a folder of their own."""
    return {path.stem: path for path in SCENARIOS.rglob("[!_]*.py")}


def _expected_numbers() -> dict[str, dict[str, Any]]:
    return tomllib.loads((SCENARIOS / "expected_numbers.toml").read_text())


def _scenarios() -> list[Scenario]:
    found = []
    for name, number in _expected_numbers().items():
        docstring = ast.get_docstring(ast.parse(_scripts()[name].read_text())) or ""
        question, _, rest = docstring.partition("\n\n")
        text = "\n\n".join(part for part in rest.split("\n\n") if not part.startswith("    "))
        found.append(Scenario(name, question, text, number))
    return found


def scenario_results(name: str) -> Path:
    """Folder of what a scenario printed and drew; it runs only if the folder is not there yet."""
    if name in CAMPAIGNS:
        return LAST / name
    settings = hashlib.sha256(SETTINGS.read_bytes()).hexdigest()[:8]
    folder = cache_folder() / f"gallery-{settings}" / name
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
    started = folder.with_name(f"{name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    started.parent.mkdir(parents=True, exist_ok=True)
    folders = (SCENARIOS, SCENARIOS / "papers", REPOSITORY / "docs", REPOSITORY)
    run = subprocess.run(
        [sys.executable, "-m", "making.scenario_numbers", name, str(started)],
        capture_output=True,
        text=True,
        cwd=REPOSITORY,
        env=environment() | {"PYTHONPATH": os.pathsep.join(map(str, folders))},
    )
    if run.returncode:
        raise RuntimeError(f"scenarios/{name}.py failed: {run.stderr.strip()}")
    # The last line names the pictures by their place on this machine.
    lines = [line for line in run.stdout.splitlines() if not line.startswith("pictures: ")]
    (started / PRINTED).write_text("\n".join(lines) + "\n")
    shutil.rmtree(folder, ignore_errors=True)
    started.rename(folder)


def scenario_failures(name: str) -> list[str]:
    """Numbers of a scenario that are not the expected ones, or how it failed."""
    expected = _expected_numbers()[name]
    wanted = {"number": [expected["value"], expected["tolerance"]], **expected.get("also", {})}
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


def _is_expected(found: Any, wanted: Any) -> bool:
    """Whether a number is within a tolerance (``[value, tolerance]``), or words are the same."""
    if isinstance(found, float | int) and not isinstance(found, bool):
        value, tolerance = wanted
        return bool(abs(found - value) <= tolerance)
    if isinstance(found, list) and found and isinstance(found[0], float):
        values, tolerance = wanted
        pairs = zip(found, values, strict=True)
        return all(abs(one - value) <= tolerance for one, value in pairs)
    return bool(found == wanted)


def _index(scenarios: list[Scenario]) -> str:
    cards = [
        f"## [{one.question}]({one.name}.md)\n\n"
        f"[![{one.question}]({one.name}/{one.expected['picture']}){{width=75%}}]({one.name}.md)\n"
        for one in scenarios
    ]
    entries = "\n".join(one.name for one in scenarios)
    toctree = f"```{{toctree}}\n:hidden:\n\n{entries}\n```\n"
    return HEAD + "\n".join(cards) + "\n" + toctree


def _page(scenario: Scenario, result: Path) -> str:
    expected = scenario.expected
    unit = "" if expected["unit"] == "1" else f" {expected['unit']}"
    script = _scripts()[scenario.name].relative_to(REPOSITORY)
    pictures = sorted(path.name for path in result.glob("*.png"))
    pictures.sort(key=lambda name: name != expected["picture"])
    drawn = "\n\n".join(
        f"![{name.removesuffix('.png').replace('_', ' ')}]({scenario.name}/{name})"
        for name in pictures
    )
    return (
        f"# {scenario.question}\n\n{scenario.text}\n\n"
        f"**Held by every build:** {expected['quantity']}: {expected['value']}{unit}, within "
        f"{expected['tolerance']}{unit}.\n\n{_how_it_ran(scenario.name)}"
        f"    python {script}\n\n{drawn}\n\n## What it prints\n\n"
        f"```text\n{(result / PRINTED).read_text()}```\n\n## The script\n\n"
        f"```{{literalinclude}} ../../../{script}\n:language: python\n```\n"
    )


def _how_it_ran(name: str) -> str:
    if name in CAMPAIGNS:
        return (
            f"It takes {CAMPAIGNS[name]}: this page shows what it gave when it last ran, by "
            "`python docs/build.py --campaigns`.\n\n"
        )
    if name in COARSER:
        settings = ", ".join(f"`{name}`" for name in COARSER[name])
        return f"For this page it ran on coarser settings ({settings}) than it takes alone:\n\n"
    return ""
