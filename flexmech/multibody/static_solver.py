"""Exudyn's static solver: when its Newton's method is content."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence
from typing import Any

from flexmech.linear_system import LAST_STEP, MAX_ITERATIONS, RELATIVE_RESIDUAL
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.library import load_exudyn
from flexmech.types import FloatArray


def simulation_settings(absolute_tolerance: float = 1e-8, *, of_steps: bool = False) -> Any:
    """Settings for one quiet static step and for linearization.

    Parameters
    ----------
    absolute_tolerance : float
        Where Newton's method stops.
    of_steps : bool
        Whether that is a norm of the step's coordinates, instead of one of forces in N.

    Returns
    -------
    exudyn.SimulationSettings
    """
    settings = load_exudyn().SimulationSettings()
    settings.solution.file.write = False
    # A third faster at any size; of dense matrices Exudyn warns beyond 1000 coordinates.
    settings.linearSolver.solverType = load_exudyn().LinearSolverType.EigenSparse
    settings.staticSolver.numberOfLoadSteps = 1
    settings.staticSolver.adaptiveStep = False
    settings.staticSolver.verboseMode = 0
    newton = settings.staticSolver.newton
    # The relative tolerance refers to the first residual and fails near an easy start.
    newton.relativeTolerance = 0.0
    newton.absoluteTolerance = absolute_tolerance
    newton.maxIterations = MAX_ITERATIONS
    newton.residualMode = int(of_steps)
    return settings


class StaticSettings:
    """When Exudyn's static solver is content.

    Forces out of balance are no measure beside a stiff link: what its round-off hides may bend a
    soft one that is pinned to it. So Newton's method goes on until its step is small, and is
    content with forces that are round-off only where no step ever is.
    """

    def __init__(self, round_off: float) -> None:
        self._by_steps = simulation_settings(LAST_STEP, of_steps=True)
        self._round_off = round_off

    def under(self, loaded: float) -> tuple[Any, Any]:
        """Settings to be tried one after the other under loads of a size in N."""
        by_forces = simulation_settings(max(RELATIVE_RESIDUAL * loaded, self._round_off))
        return self._by_steps, by_forces


def solve_static(assembly: LinkAssembly, settings: Sequence[Any], start: FloatArray) -> bool:
    """Move the model into static equilibrium.

    Parameters
    ----------
    assembly : LinkAssembly
    settings : sequence of exudyn.SimulationSettings
        Tried one after the other, each from the same start.
    start : ndarray, shape (size,)
        Exudyn's coordinates, less the reference ones.

    Returns
    -------
    bool
        Whether Newton's method ended by one of these settings.
    """
    return any(_ends(assembly, each, start) for each in settings)


def _ends(assembly: LinkAssembly, settings: Any, start: FloatArray) -> bool:
    exudyn = load_exudyn()
    assembly.mbs.systemData.SetODE2Coordinates(start, exudyn.ConfigurationType.Initial)
    with contextlib.redirect_stdout(io.StringIO()):
        try:
            return bool(assembly.mbs.SolveStatic(settings, updateInitialValues=False))
        except exudyn.SolverError:
            return False
