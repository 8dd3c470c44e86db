"""Duties of every command: files hold the printed answer, and load back as it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import flexmech
from tests.support.command import Ended, run_command

_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.(\d+))?(?:e([+-]?\d+))?")


class Journey:
    """A command that ended well and printed JSON: what it said, and the result in its folder."""

    def __init__(self, folder: Path, *words: str | Path | float) -> None:
        self.ended: Ended = run_command(folder, *words, "--json")
        assert self.ended.exit_code == 0, self.ended.stderr
        self.said: dict[str, Any] = json.loads(self.ended.stdout)
        self.answer = " ".join(self.said["answer"])
        self.rows: list[list[Any]] = self.said["table"]["rows"] if self.said["table"] else []

    def number(self, name: str, of: str | None = None) -> float:
        """A number of the answer by its name, and by what it is of."""
        (found,) = (
            one["value"] for one in self.said["numbers"] if (one["name"], one["of"]) == (name, of)
        )
        return float(found)

    def error(self, name: str, of: str | None = None) -> float:
        """The stated error of a number of the answer."""
        (found,) = (
            one["error"] for one in self.said["numbers"] if (one["name"], one["of"]) == (name, of)
        )
        return float(found)

    def table(self, name: str) -> dict[str, np.ndarray]:
        """Columns of a CSV file that the command wrote."""
        return self.ended.table(name)

    def result(self) -> flexmech.Result:
        """What the folder holds, loaded; it says what was printed, and its tables are the files."""
        assert [Path(file).name for file in self.said["files"]][-1] == "summary.txt"
        written = sorted(Path(file).name for file in self.said["files"])
        assert written == self.ended.files
        (found,) = flexmech.stored_results(self.ended.folder).all
        assert list(found.summary().answer) == self.said["answer"]
        for line in self.said["answer"]:
            assert line in (self.ended.folder / "summary.txt").read_text(encoding="utf-8")
        tables = found.tables()
        assert {f"{name}.csv" for name in tables} == {f for f in written if f.endswith(".csv")}
        for name, frame in tables.items():
            _assert_same(self.table(name), frame)
        return found


def tells(text: str, value: float) -> bool:
    """Whether a text has a number to which the value rounds, at its last digit."""
    for found in _NUMBER.finditer(text):
        last = 10.0 ** (int(found[2] or 0) - len(found[1] or ""))
        if abs(float(found[0]) - value) <= 0.501 * max(last, 1e-12 * abs(value)):
            return True
    return False


def _assert_same(columns: dict[str, np.ndarray], frame: pd.DataFrame) -> None:
    """The columns of a file are those of the table, to the eight or ten digits that are written."""
    assert list(columns) == list(frame.columns)
    for name, values in columns.items():
        if values.dtype.kind == "f":
            np.testing.assert_allclose(values, pd.to_numeric(frame[name]), rtol=6e-8, atol=0)
        else:
            known = ["" if pd.isna(one) else str(one) for one in frame[name]]
            assert [_plain(one) for one in values] == [_plain(one) for one in known]


def _plain(text: str) -> str:
    """Text as it is; numbers in one form."""
    try:
        return f"{float(text):.8g}"
    except ValueError:
        return text
