"""How far a crank speed is from an unstable band, or in it: a number that changes its sign."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.stability.exponents import GROWS, wrapped
from flexmech.analyses.stability.kept_modes import KeptModes
from flexmech.analyses.stability.runs_of_growth import Sample
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage


@dataclass(frozen=True)
class SignedGrowth:
    """Positive where a vibration grows, negative where none does, zero at the edge of a band.

    With damping or forces that follow it is the greatest growth rate in 1/s. Without, that is
    zero outside of bands; but where modes a and b meet, ``((lambda_a - conj(lambda_b)) / 2)^2``
    is the square of the growth rate in the band, negative beside it, and smooth.

    Parameters
    ----------
    solver : LinkageSolver
    """

    solver: LinkageSolver

    def __call__(self, crank_speed: float) -> float:
        """Measure at a crank speed in rad/s."""
        return self.at(self.solver.moving(crank_speed))

    def sample(self, crank_speed: float) -> Sample:
        """Measure and growth rate at a crank speed in rad/s."""
        moving = self.solver.moving(crank_speed)
        if not self.solver.is_hamiltonian:
            growth = self.solver.growth_at(moving)
            return Sample(crank_speed, growth, growth)
        modes = self.solver.solve(moving)
        return Sample(crank_speed, self._of(modes), modes.growth_rate)

    def at(self, moving: VibratingLinkage) -> float:
        """Measure of a linkage in its moving modes."""
        if not self.solver.is_hamiltonian:
            return self.solver.growth_at(moving)
        return self._of(self.solver.solve(moving))

    def _of(self, modes: KeptModes) -> float:
        return self.of_exponents(modes.exponent, modes.period)

    def of_exponents(self, exponent: NDArray[np.complex128], period: float) -> float:
        """Measure of exponents (k,) in 1/s that are known, of a turn's time in s."""
        growth = float(exponent.real.max())
        if not self.solver.is_hamiltonian:
            return growth
        if growth * period > GROWS:
            return growth**2
        return -(nearest_meeting(exponent, period) ** 2)


def nearest_meeting(exponent: NDArray[np.complex128], period: float) -> float:
    """Half of the least angular velocity by which two modes of opposite sense pass, in rad/s."""
    forward = exponent.imag[exponent.imag > 0] * period
    total = forward[:, None] + forward
    return float(np.abs(wrapped(total)).min() / (2 * period))
