"""How far reduction and mesh put the exponents of the Floquet modes off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize

from flexmech.analyses.stability.exponents import wrapped
from flexmech.analyses.stability.kept_modes import KeptModes
from flexmech.analyses.stability.solver import BY_REFINEMENT, LinkageSolver


@dataclass(frozen=True)
class ExponentErrors:
    """Greatest relative errors of the kept modes' exponents.

    Parameters
    ----------
    reduction, mesh : float
    """

    reduction: float
    mesh: float


def exponent_errors(solver: LinkageSolver, crank_speed: float) -> ExponentErrors:
    """Compare with more moving modes, and with a mesh of half the element length.

    Parameters
    ----------
    solver : LinkageSolver
    crank_speed : float
        rad/s.

    Returns
    -------
    ExponentErrors
    """
    coarse = solver.sampled_coarsely()
    moving, with_more_modes = coarse.both_reductions(crank_speed)
    modes, finer = coarse.solve(moving), coarse.refined()
    return ExponentErrors(
        reduction=_apart(modes, coarse.solve(with_more_modes)),
        mesh=_apart(modes, finer.solve(finer.moving(crank_speed))) * BY_REFINEMENT,
    )


def _apart(modes: KeptModes, others: KeptModes) -> float:
    """Greatest relative difference of exponents, whatever members of their families they are."""
    ours, theirs = modes.exponent, others.exponent
    size = np.abs(ours.imag)[:, None]
    cost = np.abs(size - np.abs(theirs.imag)) / (size + 1 / modes.period)
    cost = cost + (np.sign(ours.imag)[:, None] != np.sign(theirs.imag))
    gap = ours - theirs[scipy.optimize.linear_sum_assignment(cost)[1]]
    turned = wrapped(gap.imag, 2 * np.pi / modes.period)
    return float((np.hypot(gap.real, turned) / np.abs(ours)).max())
