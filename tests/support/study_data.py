"""Studies of designs that many tests use."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmech import load_mechanism
from flexmech.studies import Output, Study, Variable
from flexmech.studies.evaluation import Evaluated, Task
from flexmech.units import DENSITY, LENGTH

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = load_mechanism(MODELS / "aluminium_fourbar.toml")
THICKNESS = "links.coupler.in_plane_thickness"
MASS = {"mass": Output("mass")}

FILE = f"""model = "{MODELS / "aluminium_fourbar.toml"}"
seed = 1
[vary."{THICKNESS}"]
range = ["1 mm", "3 mm"]
steps = 3
[vary.length]
paths = ["linkage.coupler"]
values = ["250 mm", "280 mm", "900 mm"]
[outputs]
mass = {{ quantity = "mass" }}
f1 = {{ quantity = "lowest_frequency", speed = "0 rpm", prestress = "none", angles = 4 }}
[[limits]]
output = "f1"
above = "40 Hz"
[[goals]]
output = "mass"
"""
"""A study file of nine designs, three of which cannot be assembled."""


def study_file(folder: Path, old: str = "", new: str = "", text: str = FILE) -> Path:
    """The study file in a folder, with a part of it replaced."""
    assert old in text
    file = folder / "study.toml"
    file.write_text(text.replace(old, new) if old else text)
    return file


def thickness(*numbers: float, distribution: Any = "range", link: str = "coupler") -> Variable:
    """A thickness that varies."""
    key = f"links.{link}.in_plane_thickness"
    return Variable(key, (key,), LENGTH, distribution, numbers)


def density(mean: float, deviation: float) -> Variable:
    """A density of coupler and rocker that varies normally."""
    key = "materials.aluminium.density"
    return Variable("density", (key,), DENSITY, "normal", (mean, deviation))


def study(*variables: Variable, outputs: Any = None, **more: Any) -> Study:
    """A study of the aluminium four-bar; of its mass if nothing else is said."""
    return Study(ALUMINIUM, variables, outputs or MASS, **more)


@dataclass
class Scripted(Executor):
    """Workers that take the outputs of designs from a function of all of them, (n, k) to (n, m).

    A function whose statistics are known stands in the place of the mechanism: all else of a study
    is as it is. Designs of which it gives no number are refused.
    """

    function: Callable[[Any], Any]

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        del fn, kwargs
        values = np.asarray(self.function(args[1]))
        failed = np.isnan(values).any(axis=1)
        future: Future[Any] = Future()
        reasons = ["no number" if each else "" for each in failed]
        future.set_result(Task(Evaluated(values, np.where(failed, 5, 0), reasons), 0.0))
        return future


def bytes_of(folder: Path) -> dict[str, str]:
    """Every file of a folder with the digest of its bytes."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
