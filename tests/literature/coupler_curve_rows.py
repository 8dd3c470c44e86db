"""Linkages of Singh & Sanyal 2022, Figures 5 to 12, and how often their curves cross themselves."""

from __future__ import annotations

from typing import NamedTuple

from flexmech.verification import verification_case


class Row(NamedTuple):
    """Lengths in mm, angle in degrees."""

    figure: str
    crank: float
    coupler: float
    rocker: float
    frame: float
    distance: float
    angle: float

    def crossings(self, *, wet: bool) -> int:
        """Dry, or with R-914 saturated at 80 K: as the verification has them."""
        state = "wet" if wet else "dry"
        case = verification_case(f"Crossings of coupler curves, Figures 5 to 12: {state}")
        return int(case.expected_values()[case.labels.index(f"Figure {self.figure}")])


ROWS = [
    Row("5", 2250, 4500, 4500, 4500, 4500, 245.5),
    Row("6", 3000, 4500, 4500, 5000, 4500, 270),
    Row("7", 2250, 4500, 4500, 4500, 5000, 336),
    Row("8", 2250, 4500, 4500, 4500, 5000, 336),
    Row("9", 100, 130, 130, 120, 33, 320),
    Row("10", 100, 130, 130, 120, 33, 320),
    Row("11", 2250, 4500, 4500, 4500, 3750, 45),
    Row("12", 15, 30, 30, 30, 30, 358),
]
