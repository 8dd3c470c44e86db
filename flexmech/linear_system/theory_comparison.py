"""How far beam theories differ on one linkage, and which of them it needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmech.types import FloatArray

NEGLIGIBLE = 0.01
"""Relative difference of a frequency up to which the simpler theory is taken."""


ELASTICITY = "elasticity"
"""In the place of a theory: plane stress for links whose soft layers are compressed."""

HELD_ENDS = "held ends"
"""In the place of a theory: Timoshenko's, and links of off-axis plies between joints as in three
dimensions."""


@dataclass(frozen=True)
class TheoryDifference:
    """Greatest relative difference of two theories' frequencies.

    Parameters
    ----------
    value : float
        ``|f / f_finer - 1|``.
    mode : int
        Where it is, counted from 1.
    noticed_from : int
        First mode whose difference is not negligible; 0 where all are.
    """

    value: float
    mode: int
    noticed_from: int = 0


@dataclass(frozen=True)
class TheoryComparison:
    """Natural frequencies of a linkage at rest by several beam theories on one mesh.

    Parameters
    ----------
    frequency : callable
        Of a theory's name, :data:`ELASTICITY` or :data:`HELD_ENDS`: its frequencies in Hz at some
        crank angles, (A, modes).
    eccentric : bool
        Whether a neutral axis is off the pins' axis, which asks for a beam that shears.
    """

    frequency: Callable[[str], FloatArray]
    eccentric: bool

    def difference(self, theory: str, finer: str) -> TheoryDifference:
        """Greatest difference of a theory from a finer one, over crank angles and modes."""
        by_mode = np.abs(self.frequency(theory) / self.frequency(finer) - 1).max(axis=0)
        mode = int(by_mode.argmax())
        noticed = np.flatnonzero(by_mode > NEGLIGIBLE)
        return TheoryDifference(
            float(by_mode[mode]), mode + 1, 1 + int(noticed[0]) if noticed.size else 0
        )

    @property
    def finest(self) -> str:
        """What other theories are held against: elasticity where zigzag beams fall short of it."""
        short = self.difference("zigzag", ELASTICITY).value > NEGLIGIBLE
        return ELASTICITY if short else "zigzag"

    @property
    def suitable(self) -> str:
        """The simplest theory whose frequencies a finer one does not change noticeably."""
        slender = self.difference("euler", "timoshenko").value <= NEGLIGIBLE
        # Zigzag beams are between the two: what shear does not change, warping cannot.
        if slender:
            return "timoshenko" if self.eccentric else "euler"
        warps = self.difference("timoshenko", "zigzag").value > NEGLIGIBLE
        return "zigzag" if warps else "timoshenko"
