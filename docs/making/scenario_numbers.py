"""Run a scenario as the pages show it, and keep the numbers that hold it.

Used as ``python -m making.scenario_numbers NAME FOLDER``: the script runs in the folder, where it
writes its pictures and tables, and ``numbers.json`` there has its numbers.
``scenarios/expected_numbers.toml`` has each number as an expression in the names of the script, and
coarser settings of scripts that take minutes by themselves.
"""

from __future__ import annotations

import ast
import json
import os
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from making.state import REPOSITORY

__all__ = ["KEPT", "SCENARIOS", "expected_numbers"]

KEPT = "numbers.json"
"""File of the numbers, beside the pictures."""
DOTS_PER_INCH = 200
"""Density of the pictures: thin lines stay sharp on a screen of twice the usual density."""
SCENARIOS = REPOSITORY / "scenarios"


def expected_numbers() -> dict[str, dict[str, Any]]:
    """Tables of ``scenarios/expected_numbers.toml``, by the place of the script without ending."""
    return tomllib.loads((SCENARIOS / "expected_numbers.toml").read_text())


def run_script(script: Path, settings: Mapping[str, str]) -> dict[str, Any]:
    """Run a script with other values of some of its settings; its names at the end.

    Parameters
    ----------
    script : Path
    settings : mapping of str to str
        Expressions by the names that the script assigns at its top level.

    Raises
    ------
    RuntimeError
        If the script assigns none of one of these names.
    """
    tree, unknown = ast.parse(script.read_text()), set(settings)
    for line in tree.body:
        match line:
            case ast.Assign(targets=[ast.Name(id=name)]) if name in settings:
                line.value = ast.parse(settings[name], mode="eval").body
                unknown.discard(name)
            case ast.Assign(targets=[ast.Tuple(elts=several)], value=ast.Tuple(elts=values)):
                for place, target in enumerate(several):
                    if isinstance(target, ast.Name) and target.id in settings:
                        values[place] = ast.parse(settings[target.id], mode="eval").body
                        unknown.discard(target.id)
    if unknown:
        raise RuntimeError(f"{script.name} has no settings {', '.join(sorted(unknown))}")
    names: dict[str, Any] = {"__name__": "__main__", "__file__": str(script)}
    exec(compile(ast.fix_missing_locations(tree), script, "exec"), names)
    return names


def plain(value: Any) -> Any:
    """A number, a word or a list of them."""
    if isinstance(value, tuple | list | np.ndarray):
        return [plain(one) for one in value]
    if isinstance(value, str | bool | int):
        return value
    return bool(value) if isinstance(value, np.bool_) else float(value)


def main(name: str, folder: Path) -> None:
    """Run a scenario with its coarser settings, if any, and keep its numbers."""
    expected = expected_numbers()[name]
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    mpl.rcParams["savefig.dpi"] = DOTS_PER_INCH
    names = run_script(SCENARIOS / f"{name}.py", expected.get("coarser", {}))
    wanted = {"number": expected["number"]}
    wanted |= {words: expression for words, (expression, *_) in expected.get("also", {}).items()}
    numbers = {words: plain(eval(expression, names)) for words, expression in wanted.items()}
    Path(KEPT).write_text(json.dumps(numbers, indent=2))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
