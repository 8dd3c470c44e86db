"""The gallery: every scenario with what it prints and draws, and the number that a test holds."""

from __future__ import annotations

import ast
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from making.state import REPOSITORY, cache_folder, environment

__all__ = ["gallery_pages", "scenario_names", "scenario_results"]

SCENARIOS = REPOSITORY / "scenarios"
PRINTED = "printed.txt"

HEAD = """# Gallery

Each entry is a question, a script of public names that answers it (`scenarios/`), what it prints
and draws when these pages are built, and one number of it that a test holds. Every figure and table
of the three papers that this project starts from has its place beside ours in [figures and tables
of the papers](../figures_of_the_papers.md).

"""


@dataclass(frozen=True)
class Scenario:
    """A script, its words and the number that a test holds."""

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
    """Names of the scenarios, in the order of the gallery."""
    return list(_expected_numbers())


def _expected_numbers() -> dict[str, dict[str, Any]]:
    return tomllib.loads((SCENARIOS / "expected_numbers.toml").read_text())


def _scenarios() -> list[Scenario]:
    found = []
    for name, number in _expected_numbers().items():
        docstring = ast.get_docstring(ast.parse((SCENARIOS / f"{name}.py").read_text())) or ""
        question, _, rest = docstring.partition("\n\n")
        text = "\n\n".join(part for part in rest.split("\n\n") if not part.startswith("    "))
        found.append(Scenario(name, question, text, number))
    return found


def scenario_results(name: str) -> Path:
    """Folder of what a scenario printed and drew; it runs only if the folder is not there yet."""
    folder = cache_folder() / "gallery" / name
    if (folder / PRINTED).exists():
        return folder
    started = folder.with_name(f"{name}.unfinished")
    shutil.rmtree(started, ignore_errors=True)
    run = subprocess.run(
        [sys.executable, str(SCENARIOS / f"{name}.py"), "--out", str(started)],
        capture_output=True,
        text=True,
        cwd=REPOSITORY,
        env=environment(),
    )
    if run.returncode:
        raise RuntimeError(f"scenario {name} failed: {run.stderr.strip()}")
    # The last line names the pictures by their place on this machine.
    lines = [line for line in run.stdout.splitlines() if not line.startswith("pictures: ")]
    (started / PRINTED).write_text("\n".join(lines) + "\n")
    shutil.rmtree(folder, ignore_errors=True)
    started.rename(folder)
    return folder


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
    pictures = sorted(path.name for path in result.glob("*.png"))
    pictures.sort(key=lambda name: name != expected["picture"])
    drawn = "\n\n".join(
        f"![{name.removesuffix('.png').replace('_', ' ')}]({scenario.name}/{name})"
        for name in pictures
    )
    return (
        f"# {scenario.question}\n\n{scenario.text}\n\n"
        f"**Held by a test:** {expected['quantity']}: {expected['value']}{unit}, within "
        f"{expected['tolerance']}{unit} (`{expected['test']}`).\n\n"
        f"    python scenarios/{scenario.name}.py\n\n{drawn}\n\n## What it prints\n\n"
        f"```text\n{(result / PRINTED).read_text()}```\n\n## The script\n\n"
        f"```{{literalinclude}} ../../../scenarios/{scenario.name}.py\n:language: python\n```\n"
    )
