"""Contents of a report: the traces of its plots and its readings, as numbers."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

CONTENT = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)
PANEL = re.compile(r'<section class="panel[^"]*" id="([a-z-]+)"')


class Trace(NamedTuple):
    """A line or points of a plot: the title of its axis, its name, and what the reader chose."""

    axis: str
    name: str
    when: dict[str, str]
    look: str
    x: np.ndarray
    y: np.ndarray


class Page:
    """A report that was written."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.text = path.read_text(encoding="utf-8")
        match = CONTENT.search(self.text)
        assert match, "the page holds its data"
        self.content: dict[str, Any] = json.loads(match[1])
        self.panels = PANEL.findall(self.text)

    def array(self, number: int) -> np.ndarray:
        """Numbers of 4 bytes."""
        return np.frombuffer(base64.b64decode(self.content["arrays"][number]), "<f4")

    def plot(self, name: str) -> dict[str, Any]:
        (plot,) = [each for each in self.content["plots"] if each["name"] == name]
        return plot

    def traces(self, plot: str) -> list[Trace]:
        found = self.plot(plot)
        return [
            Trace(
                found["axes"][each["axis"]]["title"],
                each["name"],
                each["when"],
                each["look"],
                self.array(each["x"]),
                self.array(each["y"]),
            )
            for each in found["traces"]
        ]
