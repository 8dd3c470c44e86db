"""Arms whose tip is in a bearing, and Floquet exponents as a stability map has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech import RotatingArm, stability
from flexmech.linkages import Clamp, Link, LinkEnd, Pivot, Topology

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class ArmInBearing(RotatingArm):
    """Its tip is in a bearing of the ground that does not turn: springs alone hold it."""

    @property
    def topology(self) -> Topology:
        return Topology(
            (Link("arm", self.length),),
            (Clamp("O2", LinkEnd("arm", "start")),),
            (Pivot("bearing", LinkEnd("arm", "end"), sprung=True),),
        )


def exponents(engine: Any, speed: float, modes: int, prestress: Any = "axial") -> ComplexArray:
    """Floquet exponents in 1/s of the modes that turn forward, by frequency.

    With the whole turns of their largest harmonics.
    """
    data = stability(engine, [speed], modes=modes, prestress=prestress).dataset.isel(
        engine=0, crank_speed=0
    )
    frequency = data["frequency"].values[::2]
    growth = data["log_modulus"].values[::2] * abs(speed) / (2 * np.pi)
    found = growth + 2j * np.pi * frequency
    return np.asarray(found[np.argsort(found.imag)])


def multipliers(engine: Any, speed: float, modes: int, **options: Any) -> ComplexArray:
    """Floquet multipliers of the kept modes, forward and back."""
    data = stability(engine, [speed], modes=modes, **options).dataset.isel(engine=0, crank_speed=0)
    return np.asarray(np.exp(data["log_modulus"].values + 1j * data["angle"].values))


def frozen_eigenvalues(engine: Any, speed: float, prestress: Any = "axial") -> ComplexArray:
    """All eigenvalues of ``M z'' + C z' + K z = 0`` at one crank angle, with rotation terms."""
    system = engine.unreduced().linear_system(0.7, speed, prestress=prestress)
    mass, rest = system.mass[0], np.hstack((system.stiffness[0], system.damping[0]))
    size = len(mass)
    matrix = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(mass, rest)]])
    return np.asarray(np.linalg.eigvals(matrix))


def forward(values: ComplexArray, count: int) -> ComplexArray:
    """The lowest of those with a positive imaginary part."""
    turning = values[values.imag > 0]
    return np.asarray(turning[np.argsort(turning.imag)][:count])


def distance(first: ComplexArray, second: ComplexArray) -> float:
    """Greatest distance of a number of one set from the nearest of the other."""
    gaps = np.abs(first[:, None] - second)
    return float(max(gaps.min(axis=0).max(), gaps.min(axis=1).max()))
