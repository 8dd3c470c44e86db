"""Problem and state of Newton's method for the equilibrium of a linkage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import DeadMoments
from flexmech.linkages import RigidMotion
from flexmech.reference.corotational import LinearStrain
from flexmech.reference.dependent_element import Ties
from flexmech.reference.element_arrays import in_positions


@dataclass(frozen=True)
class State:
    """State of Newton's method over a batch of positions.

    Parameters
    ----------
    z : ndarray, shape (size, B)
    error : ndarray, shape (B,)
        Greatest force out of balance.
    factors : ndarray, shape (size, width + 1, B)
        Of the tangent stiffness.
    converged : ndarray of bool, shape (B,)
    """

    z: FloatArray
    error: FloatArray
    factors: FloatArray
    converged: NDArray[np.bool_]

    @classmethod
    def unloaded(cls, size: int, batch: int) -> State:
        """Start at zero displacement."""
        return cls(
            np.zeros((size, batch)), np.zeros(batch), np.zeros(0), np.zeros(batch, dtype=bool)
        )

    @property
    def is_stable(self) -> NDArray[np.bool_]:
        """Converged positions with a positive definite tangent stiffness."""
        if not self.converged.any():
            return self.converged
        return np.asarray(self.converged & np.all(self.factors[:, 0] > 0, axis=0))

    def with_part(self, which: IntArray, part: State) -> State:
        """The state with some positions replaced; all of them at first."""
        if len(which) == len(self.error):
            return part
        for own, new in ((self.z, part.z), (self.factors, part.factors)):
            own[..., which] = new
        self.error[which] = part.error
        self.converged[which] = part.converged
        return self


@dataclass(frozen=True)
class Imbalance:
    """Residual and tangent at displacements.

    Parameters
    ----------
    residual : ndarray, shape (size, B)
        Outer minus inner forces.
    band : ndarray
        Tangent stiffness in band form, positions last.
    strains : list of LinearStrain
        Of each link's elements.
    """

    residual: FloatArray
    band: FloatArray
    strains: list[LinearStrain]

    @property
    def error(self) -> FloatArray:
        """Greatest force out of balance, shape (B,)."""
        return np.asarray(np.abs(self.residual).max(axis=0, initial=0.0), dtype=float)

    def at(self, which: IntArray) -> Imbalance:
        """Quantities of some positions."""
        strains = [strain.of(which) for strain in self.strains]
        residual, band = (in_positions(values, which) for values in (self.residual, self.band))
        return Imbalance(residual, band, strains)


@dataclass(frozen=True)
class Problem:
    """Loads and constraints of the equilibrium in a batch of positions.

    Parameters
    ----------
    outer : ndarray, shape (size, B)
        Forces on the linkage, where it is not displaced.
    extra : sequence of ndarray, shape (e, r, r, B)
        Stiffness that comes with them, by each element's relative coordinates.
    ties : Ties
        Of the linkage where it is not displaced.
    motion : RigidMotion
    dead : DeadMoments
        Of bodies and rigid links.
    loads : list of ndarray, shape (n_link, B), or None
        The forces link by link, where ties move with the displacement.
    swelling : float
        Part of the swelling that has come on.
    """

    outer: FloatArray
    extra: Sequence[FloatArray]
    ties: Ties
    motion: RigidMotion
    dead: DeadMoments
    loads: list[FloatArray] | None = None
    swelling: float = 1.0

    def loaded(self, part: float) -> Problem:
        """The problem with a part of the loads and of the swelling."""
        extra = [part * e for e in self.extra]
        loads = self.loads and [part * load for load in self.loads]
        dead = self.dead.scaled(part)
        return Problem(part * self.outer, extra, self.ties, self.motion, dead, loads, part)

    def at(self, which: IntArray) -> Problem:
        """Quantities of some positions."""
        return Problem(
            in_positions(self.outer, which),
            [in_positions(e, which) for e in self.extra],
            self.ties.at(which) if self.loads is None else self.ties,
            self.motion.at(which),
            self.dead.at(which),
            self.loads and [in_positions(load, which) for load in self.loads],
            self.swelling,
        )
