"""An unstable band of crank speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["principal", "sum", "difference", "unnamed"]
KINDS: tuple[Kind, ...] = ("principal", "sum", "difference", "unnamed")
"""``f_a + f_a``, ``f_a + f_b`` or ``f_a - f_b`` a multiple of the crank's frequency, or none."""


@dataclass(frozen=True)
class BandEdge:
    """Where growth begins or ends.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    step_error, reduction_error, mesh_error : float
        Parts of its error in rad/s.
    is_open : bool
        Whether the band goes on beyond: the range of speeds, or the equilibrium, ends here.
    """

    crank_speed: float
    step_error: float
    reduction_error: float
    mesh_error: float
    is_open: bool

    @property
    def error(self) -> float:
        """Sum of the parts in rad/s."""
        return self.step_error + self.reduction_error + self.mesh_error


@dataclass(frozen=True)
class Band:
    """Neighbouring crank speeds at which a vibration grows.

    Parameters
    ----------
    lower, upper : BandEdge
    kind : Kind
    branches : tuple of int
        Numbers a, b of the branches that meet, from 1.
    order : int
        The n of ``f_a + f_b = n f_crank`` or ``f_a - f_b = n f_crank``; 0 without a name.
    largest_growth_rate : float
        1/s.
    fastest_speed : float
        Where it grows most, rad/s.
    closing_damping_ratio : float
        NaN if no damping ratio below 1 closes it.
    mismatch : float
        How far the frequencies are from the name, relative to the crank's frequency.
    signatures : tuple of float
        Krein signatures of the two multipliers that meet, beside the band of the undamped linkage;
        not a number without a name.
    """

    lower: BandEdge
    upper: BandEdge
    kind: Kind
    branches: tuple[int, ...]
    order: int
    largest_growth_rate: float
    fastest_speed: float
    closing_damping_ratio: float
    mismatch: float
    signatures: tuple[float, float]

    @property
    def error(self) -> float:
        """Greater of the edges' errors in rad/s."""
        return max(self.lower.error, self.upper.error)
