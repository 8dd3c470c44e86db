"""Linear systems in the few shapes of each position that its lowest modes are made of.

Component modes of straight links are not accurate for links that are bent far at high crank
speeds (of the aluminium four-bar at 94 rad/s they are off by 0.8 in detail 2 and by 7e-3 in detail
4), and all coordinates take long. The second-order Krylov space of a position contains its lowest
modes: what ``K^-1 M`` and ``K^-1 C`` make of a block of vectors, so that the quadratic
eigenproblem is projected as such (Bai & Su 2005, SIAM Journal on Matrix Analysis 26, 640-659; here
by blocks, and of the products with ``K^-1 C`` those alone that are of first order in C).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from flexmech.analyses.frequencies.eigenproblem import solve_frequencies
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.arrays import FloatArray
from flexmech.linear_system import LinearSystem, StressedLinks

logger = logging.getLogger(__name__)

# Greatest relative error of a frequency by the projection: three digits below that of the fit.
TOLERANCE = 2e-7


class KrylovSpace(NamedTuple):
    """Size of a space.

    Parameters
    ----------
    block : int
        Vectors to begin with.
    powers : int
        Of ``K^-1 M``, from the first on.
    damped : int
        Powers that are taken times ``K^-1 C`` besides.
    """

    block: int
    powers: int
    damped: int


@dataclass(frozen=True)
class ProjectedSystems(Systems):
    """Linear systems of one engine, each projected on its own second-order Krylov space.

    Parameters
    ----------
    engine, formulation, fastest, detail, running
        As of :class:`flexmech.analyses.frequencies.formulation.Systems`; the engine is without
        component modes.
    space : KrylovSpace, optional
        None leaves systems as they are.
    """

    space: KrylovSpace | None = None

    def at(
        self,
        crank_angle: FloatArray,
        crank_speed: FloatArray | float,
        stressed: StressedLinks | None = None,
    ) -> LinearSystem:
        """Projected linear system at crank angles and speeds.

        Parameters
        ----------
        crank_angle : ndarray, shape (B,)
            In rad.
        crank_speed : ndarray, shape (B,), or float
            In rad/s.
        stressed : StressedLinks, optional
            What :meth:`stressed` gave there.
        """
        system = super().at(crank_angle, crank_speed, stressed)
        return system if self.space is None else krylov_projected(system, self.space)


def projected_systems(
    systems: Systems, crank_angles: FloatArray, crank_speeds: FloatArray
) -> tuple[ProjectedSystems, float]:
    """Systems with as large a Krylov space as they need.

    Parameters
    ----------
    systems : Systems
    crank_angles, crank_speeds : ndarray, shape (B,)
        Positions to check, in rad and rad/s.

    Returns
    -------
    ProjectedSystems
    float
        Greatest relative error of a frequency by the projection, in the positions checked.
    """
    count = systems.formulation.modes
    whole = ProjectedSystems(systems.engine.unreduced(), systems.formulation)
    full = whole.at(crank_angles, crank_speeds)
    exact = solve_frequencies(full, count)
    for space in _spaces(count):
        found = solve_frequencies(krylov_projected(full, space), count)
        error = float(np.max(np.abs(found / exact - 1)))
        if error <= TOLERANCE:
            return replace(whole, space=space), error
        logger.info("a Krylov space, %s, is off by %.1e", space, error)
    return whole, 0.0


def _spaces(count: int) -> tuple[KrylovSpace, ...]:
    """From small to large, for so many modes."""
    return (
        KrylovSpace(count + 1, 3, 1),
        KrylovSpace(count + 2, 3, 1),
        KrylovSpace(count + 4, 3, 2),
        KrylovSpace(count + 4, 4, 2),
        KrylovSpace(2 * count + 4, 4, 2),
    )


def krylov_projected(system: LinearSystem, space: KrylovSpace) -> LinearSystem:
    """Project a system on the second-order Krylov space of each of its positions.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions, n coordinates, unreduced.
    space : KrylovSpace
        One that leaves nothing out gives the system itself.

    Returns
    -------
    LinearSystem
        It has frequencies, and no shapes of links.
    """
    damped = space.damped if system.damping.any() else 0
    if (space.powers + damped) * space.block >= system.size:
        return system
    # Any vectors will do; these are the same for every position, so that frequencies are smooth.
    start = np.random.default_rng(0).standard_normal((system.size, space.block))
    flexibility = np.linalg.inv(system.stiffness)
    powers = [_unit(flexibility @ (system.mass @ start))]
    for _ in range(space.powers - 1):
        powers.append(_unit(flexibility @ (system.mass @ powers[-1])))
    answers = [_unit(flexibility @ (system.damping @ power)) for power in powers[:damped]]
    upper = np.swapaxes(np.linalg.cholesky(system.mass), 1, 2)
    unit, _ = np.linalg.qr(upper @ np.concatenate([*powers, *answers], axis=2))
    basis = np.linalg.solve(upper, unit)
    adjoint = np.swapaxes(basis, 1, 2)
    return replace(
        system,
        mass=adjoint @ system.mass @ basis,
        damping=adjoint @ system.damping @ basis,
        stiffness=adjoint @ system.stiffness @ basis,
        unit_mass_from=None,
    )


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors (B, n, b) scaled to the length 1; a vector of nothing stays."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0), dtype=float)
