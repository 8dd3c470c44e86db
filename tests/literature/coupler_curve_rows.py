"""Linkages of Singh & Sanyal 2022, Figures 5 to 12, and how often their curves cross themselves."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """Lengths in mm, angle in degrees, crossings dry and with R-914 saturated at 80 K."""

    figure: str
    crank: float
    coupler: float
    rocker: float
    frame: float
    distance: float
    angle: float
    dry: int
    wet: int


ROWS = [
    Row("5", 2250, 4500, 4500, 4500, 4500, 245.5, 0, 1),
    Row("6", 3000, 4500, 4500, 5000, 4500, 270, 1, 1),
    Row("7", 2250, 4500, 4500, 4500, 5000, 336, 1, 0),
    Row("8", 2250, 4500, 4500, 4500, 5000, 336, 1, 0),
    Row("9", 100, 130, 130, 120, 33, 320, 0, 1),
    Row("10", 100, 130, 130, 120, 33, 320, 0, 1),
    Row("11", 2250, 4500, 4500, 4500, 3750, 45, 0, 0),
    Row("12", 15, 30, 30, 30, 30, 358, 0, 0),
]
