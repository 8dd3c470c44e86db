"""A command line as a user types it, run in this process, and the tables that it writes."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from flexmech.cli import app

MODELS = Path(__file__).parents[2] / "models"


@dataclasses.dataclass(frozen=True)
class Ended:
    """How a command ended, and the folder that its results are in."""

    exit_code: int
    stdout: str
    stderr: str
    folder: Path

    @property
    def files(self) -> list[str]:
        """Names of the files that the command wrote."""
        return sorted(path.name for path in self.folder.iterdir()) if self.folder.exists() else []

    def table(self, name: str) -> dict[str, np.ndarray]:
        """Columns of one of its tables (``frequencies`` for ``frequencies.csv``) by their names."""
        return columns_of(self.folder / f"{name}.csv")


def columns_of(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file by their names: numbers where all cells are numbers, else text.

    An empty cell of a column of numbers is NaN.
    """
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    names, cells = rows[0], np.array(rows[1:], dtype=str).reshape(-1, len(rows[0]))
    return {name: _numbers_or_text(cells[:, column]) for column, name in enumerate(names)}


def _numbers_or_text(cells: np.ndarray) -> np.ndarray:
    try:
        return np.where(cells == "", "nan", cells).astype(float)
    except ValueError:
        return cells


def run_command(folder: Path, *words: str | Path | float) -> Ended:
    """Run ``flexmech`` with these words; relative model files are looked for from the repository.

    ``models/...`` names a shipped model. Where the words hold no ``--out``, results go to
    ``folder``.
    """
    typed = [str(word) for word in words]
    typed = [str(MODELS.parent / word) if word.startswith("models/") else word for word in typed]
    if "--out" not in typed and typed[0] not in {"new", "export"}:
        typed += ["--out", str(folder)]
    result = CliRunner().invoke(app, typed)
    out = Path(typed[typed.index("--out") + 1]) if "--out" in typed else folder
    # These deliver no folder of results.
    out = out if typed[0] in {"new", "export", "report", "schema"} else out / typed[0]
    return Ended(result.exit_code, result.stdout, result.stderr, out)
