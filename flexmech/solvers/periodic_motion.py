"""The periodic motion of the running linkage at large displacements, stable or not.

Newton's method finds it from the quasi-static equilibrium, without running a transient out: an
unstable motion is found as well as a stable one, and the motion has no numerical damping. Where
the direct way fails, continuation in a damping proportional to the mass leads the way, with less of
it from one motion to the next and none in the end.

Newton's steps are solved by GMRES. The preconditioner splits the coordinates of each sample by its
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
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack
from scipy.sparse.linalg import LinearOperator, gmres

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FourierSeries, differentiation_matrices
from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.linkages import ConstantSpeed, Linkage, RigidMotion
from flexmech.mechanics import Engine, LinkFrames, StressedLinks, SystemMatrices
from flexmech.mechanics.running.driven_connectors import LinkMotion
from flexmech.mechanics.running.recorded_run import FrameMotion, LinkState
from flexmech.solvers.orbit_equations import OrbitEquations, OrbitState, RunningForces, times
from flexmech.solvers.shooting import CRITICAL
from flexmech.threads import one_thread

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
        motion up, over the elastic forces of that motion. It belongs to the last state if that has
        converged, else to the first; 1 where it is not small.
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
        length, fraction = _length(equations, step), 1.0
        while True:
            trial = _in_static_balance(
                equations,
                modal,
                equations.state(state.z + fraction * step, damping_rate),
                damping_rate,
            )
            correction, count = modal.solve(matrices, -trial.residual)
            if trial.error <= TOLERANCE:
                break
            if _length(equations, correction) <= (1 - SHORTENED * fraction) * length:
                break
            fraction /= 2
            if fraction < SHORTEST_STEP:
                return NewtonRun(state, False, passes, detuning)
        products = max(products, count) if fraction == 1 else MANY_PRODUCTS + 1
        state, passes = trial, passes + 1
        logger.info("pass %d: %.3g of a step, residual %.2e", passes, fraction, state.error)
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
        stiffness = rows @ equations.stiffness(state) @ np.swapaxes(rows, 1, 2)
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
        stiffness, shift = equations.stiffness(state), 0.0
        stiffness = (stiffness + np.swapaxes(stiffness, 1, 2)) / 2
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
        samples, shapes = equations.samples, self.modes[:, :, :m]
        rows = np.swapaxes(shapes, 1, 2)
        columns = np.moveaxis(shapes, 1, 0).reshape(-1, samples * m)
        block = np.zeros((samples, m, samples, m))
        for matrix, weight in (
            (matrices.mass, equations.second),
            (matrices.damping, equations.first),
        ):
            product = (rows @ matrix).reshape(samples * m, -1) @ columns
            block += weight[:, None, :, None] * product.reshape(block.shape)
        every = np.arange(samples)
        block[every, :, every] += rows @ matrices.stiffness @ shapes
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


# Samples of a turn at which the equations are satisfied: with 32 an orbit of linear links is not
# that of the linear equations. At each number the motion is searched from all starts, at the finest
# from the coarser motion alone: a search there takes minutes.
SAMPLES = (128, 256)
FINEST = 512
# Harmonics in the fastest quarter of those that the samples show, over the greatest displacement:
# more samples are taken above the first, and the orbit is not resolved above the second.
TAIL = 1e-4
GREATEST_TAIL = 1e-3
# Damping of the continuation: at first over the crank speed, and the part of it that stays from one
# motion to the next; that part is brought nearer to one where a motion is not found, at most
# to the last. Below the least the motion is undamped. Where all are found these are three motions;
# no more than the most, each of which takes seconds.
FIRST_DAMPING = 2.0
LESS = 0.4
LEAST_CHANGE = 0.9
LEAST_DAMPING = 0.003
MOST_DAMPED = 16
# Speed alone: runs with several steps, and analyses of one mechanism, start on the same motion.
KEPT_ORBITS = 4


@dataclass(frozen=True)
class NonlinearOrbit:
    """The periodic motion at a crank speed, a function of the crank angle.

    Parameters
    ----------
    crank_speed : float
        In rad/s.
    independent : ndarray, shape (N, n)
        Independent coordinates z of the unreduced links at crank angles ``2 pi k / N``, and of a
        frame on springs.
    beyond_linear : tuple of ndarray, shape (N, n_link)
        Displacement of each link beyond that which is linear in z, by finite poses of rigid links.
    linkage : Linkage
    frames : LinkFrames
        Frames of the unreduced links.
    residual : float
        Forces out of balance over the inertia forces and weight; each is measured by the root
        of the work that the straight links would do under it.
    tail : float
        Displacement in the fastest quarter of the harmonics over the greatest displacement.
    distance : float
        Greatest distance from the quasi-static equilibrium over the greatest displacement of
        the orbit, at stations along the links; nan where there is no such equilibrium.
    passes : int
        Number of passes of Newton's method, in all.
    """

    crank_speed: float
    independent: FloatArray
    beyond_linear: tuple[FloatArray, ...]
    linkage: Linkage
    frames: LinkFrames
    residual: float
    tail: float
    distance: float
    passes: int

    def at(self, crank_angle: ArrayLike) -> tuple[list[FloatArray], list[FloatArray]]:
        """Displacement of each link in the frame of its rigid motion, and its time derivative.

        Parameters
        ----------
        crank_angle : array_like, shape (A,)
            In rad.

        Returns
        -------
        tuple of list of ndarray, shape (A, n_link)
            The derivative is that in the link's frame.
        """
        _, moving, _ = self._moving(crank_angle)
        return [q for q, _, _ in moving], [v for _, v, _ in moving]

    def stressed_links(self, engine: Engine, crank_angle: ArrayLike) -> StressedLinks:
        """Links about this motion, whose small vibrations are asked for.

        Parameters
        ----------
        engine : Engine
            With the same links' coordinates; with its damping, and its shaft free or prescribed.
        crank_angle : array_like, shape (A,)
            In rad.

        Returns
        -------
        StressedLinks
            Batch of A positions.
        """
        motion, moving, places = self._moving(crank_angle)
        return RunningForces(engine, motion).on_frame(places).stressed(moving)

    def _moving(self, crank_angle: ArrayLike) -> tuple[RigidMotion, LinkMotion, list[FloatArray]]:
        """Rigid motion at crank angles (A,); displacement and two rates of links and frame."""
        angle = np.asarray(crank_angle, dtype=float)
        motion = self.linkage.motion(angle, np.full(len(angle), self.crank_speed))
        first, second = differentiation_matrices(len(self.independent), self.crank_speed)

        def with_rates(samples: FloatArray) -> list[FloatArray]:
            return [_at_angles(s, angle) for s in (samples, first @ samples, second @ samples)]

        count = self.frames.size
        linear = self.frames.link_motion(motion, *with_rates(self.independent[:, :count]))
        beyond = [with_rates(samples) for samples in self.beyond_linear]
        moving = [
            (q + more, v + faster, a + change)
            for (q, v, a), (more, faster, change) in zip(linear, beyond, strict=True)
        ]
        on_springs = self.independent.shape[1] > count
        return motion, moving, with_rates(self.independent[:, count:]) if on_springs else []

    def state(self, crank_angle: float) -> LinkState:
        """State of the links at a crank angle in rad."""
        displacement, rate = self.at([crank_angle])
        return LinkState(
            [q[0] for q in displacement], [v[0] for v in rate], self.frame_motion([crank_angle])
        )

    def frame_motion(self, crank_angle: ArrayLike) -> FrameMotion | None:
        """Motion of a frame on springs at crank angles (A,) in rad; None where it stands."""
        places = self._moving(crank_angle)[2]
        return FrameMotion(*places[:2]) if places else None


def _at_angles(z: FloatArray, crank_angle: FloatArray) -> FloatArray:
    """Values (A, n) of a periodic motion at crank angles in rad, by samples (N, n) of a turn."""
    return FourierSeries.through(z, with_last_cosine=True).at(crank_angle / (2 * np.pi))


def nonlinear_orbit(
    engine: Engine, crank_speed: float, near: NonlinearOrbit | None = None
) -> NonlinearOrbit:
    """Find the periodic motion of an engine's links with their nonlinear internal forces.

    Where several periodic motions exist, this is the one next to the start, or the one that damping
    leads to.

    Parameters
    ----------
    engine : Engine
        With a prescribed shaft.
    crank_speed : float
        In rad/s, not zero.
    near : NonlinearOrbit, optional
        Motion of an engine with the same links' coordinates, at a crank speed nearby, from which
        Newton's method starts; it starts from the quasi-static equilibrium by default, and where it
        finds nothing from there.

    Returns
    -------
    NonlinearOrbit

    Raises
    ------
    InputError
        If the speed is zero, the shaft free, or what acts on the links does not repeat itself every
        turn.
    ComputationError
        If no periodic motion is found, the crank speed is critical, or the harmonics do not
        fade out.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> orbit = nonlinear_orbit(flexmech.ReferenceEngine(mechanism, elements=4), 20.0)
    >>> orbit.residual < 1e-9
    True
    >>> round(orbit.distance, 2)
    0.09
    """
    ConstantSpeed(crank_speed)  # refuses what is no speed
    engine.check_runs()
    engine.require_prescribed_shaft("a periodic motion at large displacements")
    with one_thread():
        if near is None:
            return _kept_orbit(engine, float(crank_speed))
        return _orbit(engine, float(crank_speed), near)


@lru_cache(maxsize=KEPT_ORBITS)
def _kept_orbit(engine: Engine, crank_speed: float) -> NonlinearOrbit:
    return _orbit(engine, crank_speed, None)


def _orbit(engine: Engine, crank_speed: float, near: NonlinearOrbit | None) -> NonlinearOrbit:
    z = None if near is None else near.independent
    passes = 0
    # What a motion nearby does not fade out in, this one does not either.
    enough = 0 if near is None else min(len(near.independent), SAMPLES[-1])
    for count in (number for number in SAMPLES if number >= enough):
        equations = OrbitEquations(engine, crank_speed, count)
        still = _equilibrium(equations)
        straight = np.zeros((count, equations.size))
        starts = [straight if still is None else _independent(equations, still)]
        if z is not None:
            starts.insert(0, _at_angles(z, equations.motion.crank_angle))
        run, taken = _found(equations, starts)
        z, passes = run.state.z, passes + taken
        moved = _at_stations(equations, run.state.displacement)
        if _tail(moved) <= TAIL:
            break
    if _tail(moved) > TAIL:
        finer = OrbitEquations(engine, crank_speed, FINEST)
        resolved = newton(finer, _at_angles(run.state.z, finer.motion.crank_angle))
        passes += resolved.passes
        if resolved.converged:
            run, equations, still = resolved, finer, _equilibrium(finer)
            moved = _at_stations(equations, run.state.displacement)
    tail, greatest = _tail(moved), float(np.abs(moved).max())
    if tail > GREATEST_TAIL:
        raise ComputationError(
            f"the periodic motion at crank speed {CRANK_SPEED} is not resolved: harmonics near the "
            f"{len(moved) // 2}th of the crank's turn still carry {100 * tail:.2g} % of the "
            "greatest displacement; change the crank speed a little, or give the links damping",
            crank_speed=crank_speed,
        )
    distance = np.nan
    if still is not None:
        distance = float(np.abs(moved - _at_stations(equations, still)).max()) / greatest
    return NonlinearOrbit(
        crank_speed,
        run.state.z,
        tuple(run.state.beyond_linear),
        engine.mechanism.linkage,
        equations.frames,
        run.state.error,
        tail,
        distance,
        passes,
    )


def _found(equations: OrbitEquations, starts: Sequence[FloatArray]) -> tuple[NewtonRun, int]:
    """Periodic motion from one of the starts, or from the last by continuation in damping.

    With the number of passes of Newton's method.
    """
    passes = 0
    for start in starts:
        run = newton(equations, start)
        passes, detuning = passes + run.passes, run.detuning
        if run.converged:
            break
    if not run.converged:
        run, taken = _by_continuation(equations, starts[-1])
        passes += taken
        if run.converged:
            detuning = run.detuning
    if detuning < CRITICAL:
        raise ComputationError(
            f"crank speed {CRANK_SPEED} is critical: a free vibration fits one turn of the crank "
            "exactly, and without damping no motion near the quasi-static equilibrium is periodic; "
            "change the speed a little, or give the links damping",
            crank_speed=equations.crank_speed,
        )
    if not run.converged:
        raise ComputationError(
            f"no periodic motion found at crank speed {CRANK_SPEED}: {passes} passes of Newton's "
            f"method leave {100 * run.state.error:.3g} % of the loads out of balance; change the "
            "crank speed, or give the links more damping",
            crank_speed=equations.crank_speed,
        )
    return run, passes


def _by_continuation(equations: OrbitEquations, start: FloatArray) -> tuple[NewtonRun, int]:
    """Periodic motion by continuation in a decreasing damping, with the number of passes."""
    speed = abs(equations.crank_speed)
    damping_rate, last_found, less, passes = FIRST_DAMPING * speed, np.inf, LESS, 0
    run = newton(equations, start, damping_rate)
    for _ in range(MOST_DAMPED):
        passes += run.passes
        logger.info("damping %.3g 1/s: %s", damping_rate, "found" if run.converged else "not found")
        if run.converged:
            if damping_rate == 0:
                break
            start, last_found, less = run.state.z, damping_rate, less**1.5
            damping_rate = last_found * less if last_found * less > LEAST_DAMPING * speed else 0.0
        else:
            less = np.sqrt(less)
            if not np.isfinite(last_found) or less > LEAST_CHANGE:
                break
            damping_rate = last_found * less
        run = newton(equations, start, damping_rate)
    if run.converged and damping_rate == 0:
        return run, passes
    state = equations.state(run.state.z)
    return NewtonRun(state, False, run.passes, run.detuning), passes


def _equilibrium(equations: OrbitEquations) -> list[FloatArray] | None:
    """Displacement of each link at the quasi-static equilibria, if they all exist."""
    try:
        return equations.engine.stressed_links(equations.motion, "equilibrium").displacement
    except ComputationError as error:
        logger.info("the orbit is looked for from straight links: %s", error)
        return None


def _independent(equations: OrbitEquations, displacement: Sequence[FloatArray]) -> FloatArray:
    """Coordinates z (N, n) of the displacement of each link, (N, n_link), on a frame at rest."""
    columns = [q[..., None] for q in displacement]
    z = np.zeros((equations.samples, equations.size))
    count = equations.frames.size
    z[:, :count] = equations.frames.independent(equations.motion, columns)[..., 0]
    return z


def _at_stations(equations: OrbitEquations, displacement: Sequence[FloatArray]) -> FloatArray:
    """Displacements of all links at their stations, (N, s), in m."""
    moved = [
        np.einsum("scn,bn->bsc", link.shape, q).reshape(len(q), -1)
        for link, q in zip(equations.engine.links, displacement, strict=True)
    ]
    return np.concatenate(moved, axis=1)


def _tail(moved: FloatArray) -> float:
    """Greatest harmonic of the fastest quarter over the greatest displacement; (N, s)."""
    amplitude = 2 * np.abs(np.fft.rfft(moved, axis=0)) / len(moved)
    return float(amplitude[3 * len(moved) // 8 :].max() / np.abs(moved).max())
