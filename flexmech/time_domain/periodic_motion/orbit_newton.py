"""Newton's method for the periodic motion of links with nonlinear internal forces.

Its steps are solved by GMRES. The preconditioner splits the coordinates of each sample by its
frozen modes: those that the harmonics of the orbit can excite are dynamic, with the whole linear
periodic problem solved for them (collocation, one matrix over all samples); the others respond
quasi-statically, so that a bowed link is free to stretch. A step changes bending modes along
straight lines, which stretches links by the square of it; these forces are relaxed statically
before the step is judged. Steps are shortened by the natural monotonicity test: the next correction
with the same matrices must be shorter (Deuflhard, Newton Methods for Nonlinear Problems, 2004,
ch. 3).
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import lapack
from scipy.sparse.linalg import LinearOperator, gmres

from flexmech.arrays import FloatArray
from flexmech.linear_system import SystemMatrices
from flexmech.time_domain.periodic_motion.orbit_equations import OrbitEquations, OrbitState, times

logger = logging.getLogger(__name__)

# The iteration ends at this residual, over the loads; see OrbitEquations.error. At 1e-5 an orbit of
# linear links is noticeably not that of the linear equations.
TOLERANCE = 1e-9
# A run that converges takes three to five passes; with shortened steps a dozen or two. Those of an
# engine that does not tell how damping changes with the displacement gain a digit in two.
MOST_PASSES = 40
# Shorter steps mean that another way, by continuation, costs less: each halving is a solution.
SHORTEST_STEP = 1 / 64
# A correction with the same matrices must be shorter than the step by this part of its length, as
# Deuflhard has it.
SHORTENED = 0.25
# Modes up to this multiple of the fastest harmonic move. What is faster is left to GMRES, with
# (1 / 1.5)^2 of its dynamics at the fastest harmonic.
MOVING = 1.5
# Unknowns of the moving modes at all samples, whose matrix is factorized: 100 MB at most.
MOST_MOVING = 3600
# GMRES: relative residual of a step, basis vectors, restarts, and the products from which on the
# modes are found anew. Speed alone: an inexact step costs a further pass at most, but for the
# first, without which linear links would not be solved at once.
STEP_TOLERANCE = 1e-4
MOST_VECTORS = 60
MOST_RESTARTS = 2
MANY_PRODUCTS = 20
# Static relaxation ends at this part of the loads, with which Newton's method continues; each pass
# halves the forces or better. Speed alone.
BALANCED = 1e-2
MOST_BALANCING = 8
# Detuning of the moving modes alone below which that of all coordinates is found, and the steps
# of inverse iteration that it takes. The static modes are worth (1 / 1.5)^2 of a detuning; near a
# critical speed each step separates the singular motion from the others by orders of magnitude.
SUSPICIOUS = 1e-2
INVERSE_STEPS = 3


@dataclass(frozen=True)
class NewtonRun:
    """Result of Newton's method for a periodic motion.

    Parameters
    ----------
    state : OrbitState
        The last.
    converged : bool
    passes : int
    detuning : float
        How far the linear periodic problem is from being singular: the least force that keeps a
        motion up, over the elastic forces of that motion. Of the last state if it has
        converged, else of the first; 1 where it is not small.
    """

    state: OrbitState
    converged: bool
    passes: int
    detuning: float


def newton(equations: OrbitEquations, z: FloatArray, damping_rate: float = 0.0) -> NewtonRun:
    """Solve for a periodic motion near another one.

    Parameters
    ----------
    equations : OrbitEquations
    z : ndarray, shape (N, n)
    damping_rate : float
        Damping ``damping_rate * M z'`` that acts besides, in 1/s.

    Returns
    -------
    NewtonRun
    """
    state = equations.state(z, damping_rate)
    modal: _ModalPreconditioner | None = None
    passes, detuning, products = 0, 1.0, 0
    while state.error > TOLERANCE and passes < MOST_PASSES:
        matrices = equations.linearized(state, damping_rate)
        if modal is None or products > MANY_PRODUCTS:
            modal = _ModalPreconditioner(equations, state, matrices)
        if passes == 0:
            detuning = modal.detuning(matrices)
        step, products = modal.solve(matrices, -state.residual)
        length, part = _length(equations, step), 1.0
        while True:
            trial = _in_static_balance(
                equations, modal, equations.state(state.z + part * step, damping_rate), damping_rate
            )
            correction, count = modal.solve(matrices, -trial.residual)
            if trial.error <= TOLERANCE:
                break
            if _length(equations, correction) <= (1 - SHORTENED * part) * length:
                break
            part /= 2
            if part < SHORTEST_STEP:
                return NewtonRun(state, False, passes, detuning)
        products = max(products, count) if part == 1 else MANY_PRODUCTS + 1
        state, passes = trial, passes + 1
        logger.info("pass %d: %.3g of a step, residual %.2e", passes, part, state.error)
    converged = state.error <= TOLERANCE
    if converged and modal is not None:
        detuning = modal.detuning(equations.linearized(state, damping_rate))
    return NewtonRun(state, converged, passes, detuning)


def _length(equations: OrbitEquations, z: FloatArray) -> float:
    """Root of the mass times the square of displacements, summed over the turn."""
    return float(np.sqrt(np.sum(z * times(equations.mass, z))))


def _in_static_balance(
    equations: OrbitEquations, modal: _ModalPreconditioner, state: OrbitState, damping_rate: float
) -> OrbitState:
    """The state with the quasi-static modes in equilibrium."""
    rows = np.swapaxes(modal.modes[:, :, modal.moving :], 1, 2)
    enough = BALANCED * float(np.linalg.norm(times(rows, equations.load)))
    for _ in range(MOST_BALANCING):
        force = times(rows, state.residual)
        size = float(np.linalg.norm(force))
        if size <= enough or not np.isfinite(size):
            break
        elastic = equations.elastic(state)
        stiffness = rows @ elastic @ np.swapaxes(rows, 1, 2)
        change = np.linalg.solve(stiffness, force[..., None])[..., 0]
        state = equations.state(state.z - times(np.swapaxes(rows, 1, 2), change), damping_rate)
    return state


class _ModalPreconditioner:
    """Frozen modes of each sample: dynamic and quasi-static ones.

    Parameters
    ----------
    equations : OrbitEquations
    state : OrbitState
        Whose modes they are.
    matrices : SystemMatrices
        Linearized about it.

    Attributes
    ----------
    modes : ndarray, shape (N, n, n)
        As columns, the slowest first.
    moving : int
        Number m of modes that move.
    """

    def __init__(
        self, equations: OrbitEquations, state: OrbitState, matrices: SystemMatrices
    ) -> None:
        self._equations = equations
        stiffness, shift = equations.elastic(state), 0.0
        while (half := _inverse_root(stiffness + shift * matrices.mass)) is None:
            # Compressed beyond buckling: the modes are those of a stiffness shifted by mass.
            shift = max(10 * shift, equations.crank_speed**2)
        across = np.swapaxes(half, 1, 2)
        periods, vectors = np.linalg.eigh(half @ matrices.mass @ across)
        # At unit strain energy; their squared periods come with them.
        self.modes = np.ascontiguousarray((across @ vectors)[:, :, ::-1])
        periods = periods[:, ::-1]
        fastest = equations.samples / 2 * abs(equations.crank_speed)
        excited = (periods * (shift + (MOVING * fastest) ** 2) > 1).sum(axis=1).max()
        self.moving = int(np.clip(excited, 1, MOST_MOVING // equations.samples))
        self._static = 1 / (1 - shift * periods[:, self.moving :])
        block = self._moving_block(matrices)
        self._factors, self._pivots, _ = lapack.dgetrf(block, overwrite_a=True)

    def _moving_block(self, matrices: SystemMatrices) -> FloatArray:
        """The linear periodic problem of the moving modes, (N m, N m)."""
        equations, m = self._equations, self.moving
        samples, own = equations.samples, self.modes[:, :, :m]
        rows, columns = np.swapaxes(own, 1, 2), np.moveaxis(own, 1, 0).reshape(-1, samples * m)
        block = np.zeros((samples, m, samples, m))
        for matrix, weight in (
            (matrices.mass, equations.second),
            (matrices.damping, equations.first),
        ):
            product = (rows @ matrix).reshape(samples * m, -1) @ columns
            block += weight[:, None, :, None] * product.reshape(block.shape)
        every = np.arange(samples)
        block[every, :, every] += rows @ matrices.stiffness @ own
        return np.asfortranarray(block.reshape(samples * m, samples * m))

    def solve(self, matrices: SystemMatrices, force: FloatArray) -> tuple[FloatArray, int]:
        """Linear periodic response to forces.

        Parameters
        ----------
        matrices : SystemMatrices
            At or near the state whose modes these are.
        force : ndarray, shape (N, n)

        Returns
        -------
        ndarray, shape (N, n)
        int
            Products with the matrices that it took.
        """
        y, count = self._solve(matrices, times(np.swapaxes(self.modes, 1, 2), force))
        return times(self.modes, y), count

    def detuning(self, matrices: SystemMatrices) -> float:
        """See :class:`NewtonRun`; by inverse iteration, in modes of unit strain energy."""
        y = np.zeros(self.modes.shape[:2])
        y[:, : self.moving] = np.random.default_rng(0).standard_normal((len(y), self.moving))
        answer = 1.0
        for _ in range(INVERSE_STEPS):
            y, answer = _unit(self._precondition(_unit(y)[0].ravel()).reshape(y.shape))
        if 1 / answer > SUSPICIOUS:
            return 1.0
        return 1 / _unit(self._solve(matrices, y)[0])[1]

    def _solve(self, matrices: SystemMatrices, force: FloatArray) -> tuple[FloatArray, int]:
        """:meth:`solve` by the modes' amplitudes and the forces on them, (N, n)."""
        equations, modes = self._equations, self.modes
        rows, count = np.swapaxes(modes, 1, 2), 0

        def product(y: FloatArray) -> FloatArray:
            nonlocal count
            count += 1
            z = times(modes, y.reshape(force.shape))
            inner = (
                times(matrices.mass, equations.second @ z)
                + times(matrices.damping, equations.first @ z)
                + times(matrices.stiffness, z)
            )
            return times(rows, inner).ravel()

        square = (force.size, force.size)
        operator: Any = LinearOperator(square, matvec=product, dtype=float)
        inverse: Any = LinearOperator(square, matvec=self._precondition, dtype=float)
        y, _ = gmres(
            operator,
            force.ravel(),
            rtol=STEP_TOLERANCE,
            restart=MOST_VECTORS,
            maxiter=MOST_RESTARTS,
            M=inverse,
        )
        return y.reshape(force.shape), count

    def _precondition(self, force: FloatArray) -> FloatArray:
        """Moving modes by their own problem, the others statically."""
        y = force.reshape(self._equations.samples, -1).copy()
        slow = np.ascontiguousarray(y[:, : self.moving]).ravel()
        solved = lapack.dgetrs(self._factors, self._pivots, slow)[0]
        y[:, : self.moving] = solved.reshape(len(y), self.moving)
        y[:, self.moving :] *= self._static
        return y.ravel()


def _unit(y: FloatArray) -> tuple[FloatArray, float]:
    """A vector by its length, and that length."""
    length = float(np.linalg.norm(y))
    return y / length, length


def _inverse_root(matrices: FloatArray) -> FloatArray | None:
    """Inverse Cholesky factors of matrices (N, n, n); None where one is not positive definite."""
    try:
        return np.linalg.inv(np.linalg.cholesky(matrices))
    except np.linalg.LinAlgError:
        return None
