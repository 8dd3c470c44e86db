"""The Campbell diagram of one engine: bands, their errors, gaps, and critical speeds."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.campbell.bands import BandSolver
from flexmech.analyses.campbell.crossings import CriticalSpeed, critical_speeds, edges_of
from flexmech.analyses.campbell.edges import exact_edges
from flexmech.analyses.campbell.projection import ProjectedSystems, projected_systems
from flexmech.analyses.campbell.request import CampbellRequest
from flexmech.analyses.campbell.sampling import FIT_TOLERANCE, SampledBands, sampled_bands
from flexmech.analyses.frequencies.discretisation import check_angle_indices, mesh_error
from flexmech.analyses.frequencies.engine_map import MOST_ELEMENTS
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.requests import CHECKED_SPEEDS
from flexmech.arrays import FloatArray, IntArray, unbroken_runs
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine

logger = logging.getLogger(__name__)


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
        Of the crank speeds asked for on the grid of ``sampled``.
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
            solver.reason(float(speeds[run[0]])).told(speed_unit),
        )
        for run in unbroken_runs(~sampled.exists[places])
    ]
