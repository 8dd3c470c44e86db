"""The Campbell diagram of one engine: bands, their errors, gaps, and critical speeds.

Rays meet ends of bands at speeds that are solved for. A band's end is a lowest or highest frequency
over the crank angle. Near a crossing both speed and angle are unknown: three crank angles around
each extreme that may be the band's end give a parabola, its vertex the frequency there, and that a
better speed by the secant method.

Systems are projected on the few shapes of each position that its lowest modes are made of.
Component modes of straight links are not accurate for links that are bent far at high crank
speeds (of the aluminium four-bar at 94 rad/s they are off by 0.8 in detail 2 and by 7e-3 in detail
4), and all coordinates take long. The second-order Krylov space of a position contains its lowest
modes: what ``K^-1 M`` and ``K^-1 C`` make of a block of vectors, so that the quadratic
eigenproblem is projected as such (Bai & Su 2005, SIAM Journal on Matrix Analysis 26, 640-659; here
by blocks, and of the products with ``K^-1 C`` those alone that are of first order in C).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from flexmech.analyses.campbell.bands import (
    FIT_TOLERANCE,
    Bands,
    BandSolver,
    SampledBands,
    sampled_bands,
)
from flexmech.analyses.campbell.crossings import (
    LOWEST,
    CriticalSpeed,
    Edge,
    critical_speeds,
    edges_of,
    ray,
)
from flexmech.analyses.campbell.request import CampbellRequest
from flexmech.analyses.frequencies.discretisation import check_angle_indices, mesh_error
from flexmech.analyses.frequencies.engine_map import MOST_ELEMENTS
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.analyses.requests import CHECKED_SPEEDS
from flexmech.arrays import FloatArray, IntArray, unbroken_runs
from flexmech.errors import ComputationError
from flexmech.mechanics import Engine, LinearSystem, StressedLinks
from flexmech.solvers.eigenproblem import solve_frequencies
from flexmech.solvers.formulation import Systems

logger = logging.getLogger(__name__)

# Relative change of the speed in the last round, and relative distance of ray and band then.
CONVERGED = 1e-8
# The secant doubles the digits in less than two rounds; what has not converged is sought anew.
MOST_ROUNDS = 20
# Distance of crank angles around an extreme, in steps of the grid: at first, and at last, where the
# parabola through three of them is the curve to nine digits.
FIRST_ASIDE, LAST_ASIDE = 0.5, 0.04
# Relative differences of frequencies below this are their round-off.
ROUND_OFF = 1e-10
# Extremes on the grid at a solved speed that may be the band's end a little further on: as near to
# it as this many times what the end moves by until the next solved speed, and relatively. A grid
# misses the peak of a sharp one by one or two per cent.
MAY_BE_END, NEAR_END = 2.0, 0.02
# A band seldom has more that are nearly as low; those missed are found by whole turns. Speed alone
# beyond three.
MOST_EXTREMES = 3
# By this part of its step's width a speed may be outside it on the way: the secant comes back from
# there, and beyond there may be no solution.
OUTSIDE = 0.5


@dataclass
class _Search:
    """Speeds and crank angles of c extremes that are tracked to where they meet a ray.

    Parameters
    ----------
    owner : ndarray of int, shape (c,)
        Number of the edge.
    sign : ndarray, shape (c,)
        1 for the lowest frequency of a band, -1 for the highest.
    mode : ndarray of int, shape (c,)
    order, low, high : ndarray, shape (c,)
        Of the ray, and the ends of the step in speed.
    speed, slope : ndarray, shape (c,)
        Where the extreme meets the ray, and how it changes with speed.
    angle, aside : ndarray, shape (c,)
        Of the extreme, and of the angles on both sides of it; 0 at an end of the crank angles.
    last : ndarray, shape (2, c)
        Speed and frequency of the round before; not a number before the first.
    off : ndarray, shape (c,)
        Relative distance of ray and extreme.
    converged : ndarray of bool, shape (c,)
    """

    owner: IntArray
    sign: FloatArray
    mode: IntArray
    order: FloatArray
    low: FloatArray
    high: FloatArray
    speed: FloatArray
    slope: FloatArray
    angle: FloatArray
    aside: FloatArray
    last: FloatArray
    off: FloatArray
    converged: NDArray[np.bool_]

    def advance(self, systems: Systems, least_aside: float) -> None:
        """One round of those that have not converged."""
        these = np.flatnonzero(~self.converged)
        extreme, certain = self._narrowed(systems, these, least_aside)
        speed, ray_slope = self.speed[these], self.order[these] / (2 * np.pi)
        target = ray_slope * np.abs(speed)
        moved = speed - self.last[0, these]
        use = certain & (np.abs(moved) > 1e-5 * np.abs(speed))
        secant = (extreme - self.last[1, these]) / np.where(use, moved, 1.0)
        self.slope[these] = np.where(use, secant, self.slope[these])
        self.last[:, these] = np.where(certain, [speed, extreme], self.last[:, these])
        change = (extreme - target) / (ray_slope * np.sign(speed) - self.slope[these])
        width = OUTSIDE * (self.high - self.low)[these]
        new = np.clip(speed + change, self.low[these] - width, self.high[these] + width)
        self.speed[these] = np.where(certain, new, speed)
        self.off[these] = np.abs(extreme / target - 1)
        small = np.abs(new - speed) <= CONVERGED * np.abs(new)
        narrow = self.aside[these] <= least_aside
        # One that would meet the ray far from this step only is left.
        left = (new == speed) & (np.abs(change) > width)
        self.converged[these] = left | (certain & small & narrow & (self.off[these] <= CONVERGED))

    def _narrowed(
        self, systems: Systems, these: IntArray, least_aside: float
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Extremes (k,) of some, and whether they are known; their angles come nearer."""
        sign, aside = self.sign[these], self.aside[these]
        angle = self.angle[these] + np.array([[-1.0], [0.0], [1.0]]) * aside
        speed = np.broadcast_to(self.speed[these], angle.shape)
        found = frequencies_along(systems, angle.ravel(), speed.ravel())
        found = found.reshape(*angle.shape, -1)[:, np.arange(len(these)), self.mode[these]]
        before, here, behind = sign * found
        slope, bend = (behind - before) / 2, before - 2 * here + behind
        level = np.maximum(np.abs(slope), np.abs(bend)) <= ROUND_OFF * np.abs(here)
        vertex = ~level & (bend > 0) & (np.abs(slope) <= bend)
        bend = np.where(vertex, bend, 1.0)
        move = np.where(vertex, -slope / bend, np.where(level, 0.0, -np.sign(slope)))
        self.angle[these] += move * aside
        certain = vertex | level
        self.aside[these] = np.where(
            certain, np.maximum(aside / 4, np.minimum(least_aside, aside)), aside
        )
        lowest = np.where(vertex, here - slope**2 / (2 * bend), np.minimum(before, behind))
        return sign * np.where(level, here, lowest), certain


def exact_edges(
    solver: BandSolver, sampled: SampledBands, edges: list[Edge]
) -> tuple[dict[Edge, float], float]:
    """Speeds of edges, and how far the rays are off there.

    Parameters
    ----------
    solver : BandSolver
    sampled : SampledBands
    edges : list of Edge
        On its grid.

    Returns
    -------
    dict of Edge to float
        rad/s.
    float
        Greatest relative distance of ray and band.
    """
    if not edges:
        return {}, 0.0
    step = float(np.max(np.diff(solver.crank_angles), initial=np.radians(1.0)))
    search = _begin(solver, sampled, edges, FIRST_ASIDE * step)
    for _ in range(MOST_ROUNDS):
        if search.converged.all():
            break
        search.advance(solver.systems, LAST_ASIDE * step)
    margin = CONVERGED * np.abs(search.high)
    inside = (search.speed >= search.low - margin) & (search.speed <= search.high + margin)
    found, off = {}, 0.0
    for number, edge in enumerate(edges):
        own = np.flatnonzero((search.owner == number) & search.converged & inside)
        if not len(own):
            logger.info("%s is searched for over all crank angles", edge)
            found[edge] = _by_whole_turns(solver, sampled.crank_speed, edge)
            continue
        # A ray enters a band at the first of its extremes, and has left it behind the last.
        chosen = own[(np.argmin if edge.enters else np.argmax)(search.speed[own])]
        found[edge] = float(search.speed[chosen])
        off = max(off, float(search.off[chosen]))
    return found, off


def _begin(solver: BandSolver, sampled: SampledBands, edges: list[Edge], aside: float) -> _Search:
    """Extremes that may be the ends of bands, and first guesses of the speeds."""
    rows: list[tuple[float, ...]] = []
    for number, edge in enumerate(edges):
        step = slice(edge.place, edge.place + 2)
        speed, ends = sampled.crank_speed[step], sampled.values[step, edge.end, edge.branch - 1]
        off = ends - ray(edge.order, speed)
        part = float(np.clip(off[0] / (off[0] - off[1]), 0.0, 1.0))
        guess, slope = speed[0] + part * (speed[1] - speed[0]), np.diff(ends) / np.diff(speed)
        for angle, inside in _extremes_near(solver, sampled.solved, edge, speed):
            rows.append((number, edge.order, *speed, guess, slope[0], angle, aside * inside))
    owner, order, low, high, guess, slope, angle, asides = np.array(rows, dtype=float).T.copy()
    number = owner.astype(np.intp)
    return _Search(
        owner=number,
        sign=np.array([1.0 if edge.end == LOWEST else -1.0 for edge in edges])[number],
        mode=np.array([edge.branch - 1 for edge in edges])[number],
        order=order,
        low=low,
        high=high,
        speed=guess,
        slope=slope,
        angle=angle,
        aside=asides,
        last=np.full((2, len(owner)), np.nan),
        off=np.full(len(owner), np.inf),
        converged=np.zeros(len(owner), dtype=bool),
    )


def _extremes_near(
    solver: BandSolver, solved: Bands, edge: Edge, step: FloatArray
) -> list[tuple[float, bool]]:
    """Crank angles of extremes around a step, and whether each is inside the crank angles."""
    grid, full_turn = solver.crank_angles, solver.full_turn
    sign = 1.0 if edge.end == LOWEST else -1.0
    below = int(np.searchsorted(solved.crank_speed, step[0], side="right")) - 1
    above = min(int(np.searchsorted(solved.crank_speed, step[1])), len(solved.crank_speed) - 1)
    rows = sorted({below, above})
    ends = solved.values[rows, edge.end, edge.branch - 1]
    near = MAY_BE_END * float(np.ptp(ends)) + NEAR_END * float(ends.max())
    angles = solved.angle[rows, 0 if edge.end == LOWEST else 1, edge.branch - 1].tolist()
    for row in rows:
        value = sign * solved.frequency[row, :, edge.branch - 1]
        around = np.pad(value, 1, mode="wrap" if full_turn else "edge")
        lowest = (value <= around[:-2]) & (value <= around[2:]) & (value <= value.min() + near)
        places = np.flatnonzero(lowest)
        angles += grid[places[np.argsort(value[places])][:MOST_EXTREMES]].tolist()
    width = float(np.max(np.diff(grid), initial=0.0))
    found: list[float] = []
    for angle in angles:
        apart = np.abs(np.array(found) - angle)
        if full_turn:
            apart = np.minimum(apart, 2 * np.pi - apart)
        # The same extreme moves by a step at most from one solved speed to the next, mostly.
        if not np.any(apart <= width):
            found.append(angle)
    return [(angle, full_turn or grid[0] < angle < grid[-1]) for angle in found]


def _by_whole_turns(solver: BandSolver, grid: FloatArray, edge: Edge) -> float:
    """Speed of an edge by solutions over all crank angles (Brent's method)."""

    def distance(crank_speed: float) -> float:
        bands = solver.solve(np.array([crank_speed]))
        if not len(bands.crank_speed):
            raise solver.reason(crank_speed)
        end = float(bands.values[0, edge.end, edge.branch - 1])
        return end - float(ray(edge.order, crank_speed))

    low, high = grid[edge.place : edge.place + 2].tolist()
    at_low, at_high = distance(low), distance(high)
    if at_low * at_high > 0:
        # The fit put it into this step, and the solution has it at one of the ends.
        return float(low if abs(at_low) < abs(at_high) else high)
    return float(brentq(distance, low, high, xtol=CONVERGED * high))


# Greatest relative error of a frequency by the projection: three digits below that of the fit.
TOLERANCE = 2e-7


class KrylovSpace(NamedTuple):
    """Size of a space.

    Parameters
    ----------
    block : int
        Vectors to begin with.
    powers : int
        Powers of ``K^-1 M``, from the first on.
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
        As of :class:`flexmech.solvers.formulation.Systems`; the engine is without
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
    )


def _unit(vectors: FloatArray) -> FloatArray:
    """Vectors (B, n, b) scaled to the length 1; a vector of nothing stays."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0), dtype=float)


@dataclass(frozen=True)
class Gap:
    """Neighbouring crank speeds asked for that have no solution.

    Parameters
    ----------
    first, last : float
        rad/s.
    count : int
    reason : str
        At the first of them.
    """

    first: float
    last: float
    count: int
    reason: str


@dataclass(frozen=True)
class EngineDiagram:
    """What one engine finds.

    Parameters
    ----------
    engine : Engine
        With the elements that it has needed.
    sampled : SampledBands
    places : ndarray of int, shape (S,)
        Places of the crank speeds asked for on the grid of ``sampled``.
    critical : list of CriticalSpeed
    gaps : list of Gap
    mesh_error : ndarray, shape (c, m)
        Estimated relative error of the frequencies at the speeds checked.
    checked_speeds : ndarray, shape (c,)
    projection_error, crossing_error : float
        Greatest relative error of a frequency by the Krylov spaces, and greatest relative
        distance of ray and band at the ends of critical speeds.
    """

    engine: Engine
    sampled: SampledBands
    places: IntArray
    critical: list[CriticalSpeed]
    gaps: list[Gap]
    mesh_error: FloatArray
    checked_speeds: FloatArray
    projection_error: float
    crossing_error: float


def engine_diagram(
    engine: Engine,
    request: CampbellRequest,
    tolerance: float | None,
    report: Callable[[int], None],
    speed_unit: str,
) -> EngineDiagram:
    """Campbell diagram of one engine.

    Parameters
    ----------
    engine : Engine
    request : CampbellRequest
    tolerance : float, optional
        Estimated relative error by the mesh, at the lowest speed, up to which the elements are
        doubled; None keeps them.
    report : callable
        Called with the number of speeds after each that is solved for.
    speed_unit : str
        In which reasons speak of crank speeds.

    Returns
    -------
    EngineDiagram

    Raises
    ------
    ComputationError
        If there is no solution at any of the crank speeds.
    """
    speeds, turn = request.crank_speeds, request.turn
    checks = turn[check_angle_indices(turn, request.full_turn)]
    # Before the long work, and where links are bent least: the error of far bent links is told.
    meshed = _on_a_fine_mesh(engine, request, checks, tolerance)
    systems = meshed.systems
    # Extremes are refined to a tenth of this before the error of the mesh is known.
    error = np.full(request.formulation.modes, FIT_TOLERANCE)
    solver = BandSolver(systems, turn, request.full_turn, error, report)
    sampled, places = sampled_bands(solver, speeds)
    there = np.flatnonzero(sampled.exists[places])
    if not len(there):
        raise solver.reason(float(speeds[0]))
    some = there[np.unique(np.linspace(0, len(there) - 1, CHECKED_SPEEDS).astype(np.intp))]
    checked = speeds[some]
    errors = np.stack([meshed.error_at(w, checks).max(axis=0) for w in checked.tolist()])
    edges, crossing_error = exact_edges(
        solver, sampled, edges_of(sampled.crank_speed, sampled.values, request.orders)
    )
    return EngineDiagram(
        engine=meshed.engine,
        sampled=sampled,
        places=places,
        critical=critical_speeds(sampled.crank_speed, sampled.values, request.orders, edges),
        gaps=_gaps(solver, sampled, places, speed_unit),
        mesh_error=errors,
        checked_speeds=checked,
        projection_error=meshed.projection_error,
        crossing_error=crossing_error,
    )


@dataclass(frozen=True)
class _Meshed:
    """Systems on a mesh, and their mesh error (c, m) at the speed for which it was chosen."""

    engine: Engine
    systems: ProjectedSystems
    projection_error: float
    speed: float
    error: FloatArray

    def error_at(self, speed: float, checks: FloatArray) -> FloatArray:
        """Mesh error at a speed."""
        if speed == self.speed:
            return self.error
        return mesh_error(self.systems, checks, speed).frequency


def _on_a_fine_mesh(
    engine: Engine, request: CampbellRequest, checks: FloatArray, tolerance: float | None
) -> _Meshed:
    """Systems on a mesh that is fine enough at the slowest speed that has a solution."""
    failure: ComputationError | None = None
    by_size = np.sort(np.abs(request.crank_speeds))
    for speed in dict.fromkeys(by_size[[0, len(by_size) // 2, -1]].tolist()):
        try:
            while True:
                systems = Systems(engine, request.formulation)
                at = np.full(len(checks), speed)
                projected, projection_error = projected_systems(systems, checks, at)
                error = mesh_error(projected, checks, speed).frequency
                if _fine_enough(engine, error, tolerance):
                    return _Meshed(engine, projected, projection_error, speed, error)
                engine = engine.with_(elements=2 * engine.elements)
        except ComputationError as refusal:
            failure = failure or refusal
    assert failure is not None
    raise failure


def _fine_enough(engine: Engine, error: FloatArray, tolerance: float | None) -> bool:
    """Whether the elements are within the tolerance, or as many as may be."""
    if tolerance is None or float(error.max()) <= tolerance:
        return True
    logger.info("%d elements are off by %.1e", engine.elements, float(error.max()))
    return 2 * engine.elements > MOST_ELEMENTS


def _gaps(
    solver: BandSolver, sampled: SampledBands, places: IntArray, speed_unit: str
) -> list[Gap]:
    """Runs of the crank speeds asked for that have no solution."""
    speeds = sampled.crank_speed[places]
    return [
        Gap(
            float(speeds[run[0]]),
            float(speeds[run[-1]]),
            len(run),
            solver.reason(float(speeds[run[0]])).in_unit(speed_unit),
        )
        for run in unbroken_runs(~sampled.exists[places])
    ]
