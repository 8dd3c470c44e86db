"""Settings of Exudyn's time integration, by their paths in its settings object."""

from __future__ import annotations

from typing import Any

from flexmech.choices import Integrator
from flexmech.linear_system import ROUND_OFF
from flexmech.multibody.items import Choice
from flexmech.multibody.library import load_exudyn

# Generalized-alpha's damping of vibration much faster than the step: 1 none, 0 at once.
SPECTRAL_RADIUS = 0.9

# Out-of-balance force at which Newton's method stops, relative to that at the step's start.
# Ten times more moves joint forces by 2e-6 of their peak, the energy error in its fifth digit.
STEP_RESIDUAL = 1e-8
# The tangent is kept from step to step until an iteration gains less than this factor.
CONTRACTIVITY = 0.25


Setting = bool | int | float | Choice


def solver_settings(
    step: float, steps: int, integrator: Integrator, force_scale: float
) -> dict[str, Setting]:
    """Settings of a run.

    Parameters
    ----------
    step : float
        In s.
    steps : int
    integrator : {"trapezoidal", "generalized-alpha"}
    force_scale : float
        Force between neighbouring nodes in N, to whose round-off Newton's method goes.

    Returns
    -------
    dict of str to Setting
        By paths such as ``"timeIntegration.numberOfSteps"``.
    """
    settings: dict[str, Setting] = {
        "solution.file.write": False,
        "solution.sensors.active": False,
        "linearSolver.solverType": Choice("LinearSolverType", "EigenSparse"),
        "timeIntegration.adaptiveStep": False,
        "timeIntegration.automaticStepSize": False,
        "timeIntegration.verboseMode": 0,
        "timeIntegration.numberOfSteps": steps,
        "timeIntegration.endTime": steps * step,
        "timeIntegration.newton.useModifiedNewton": True,
        "timeIntegration.newton.modifiedNewtonContractivity": CONTRACTIVITY,
        "timeIntegration.newton.relativeTolerance": STEP_RESIDUAL,
        "timeIntegration.newton.absoluteTolerance": float(ROUND_OFF * force_scale),
        # A first iteration may meet forces a million times those of the step.
        "timeIntegration.newton.adaptInitialResidual": False,
    }
    if integrator == "trapezoidal":
        settings["timeIntegration.generalizedAlpha.useNewmark"] = True
        settings["timeIntegration.generalizedAlpha.useIndex2Constraints"] = True
    else:
        settings["timeIntegration.generalizedAlpha.spectralRadius"] = SPECTRAL_RADIUS
    return settings


def applied(settings: dict[str, Setting]) -> Any:
    """Exudyn's object with these settings.

    Parameters
    ----------
    settings : dict of str to Setting

    Returns
    -------
    exudyn.SimulationSettings
    """
    made = load_exudyn().SimulationSettings()
    for path, value in settings.items():
        *parts, name = path.split(".")
        owner = made
        for part in parts:
            owner = getattr(owner, part)
        setattr(owner, name, value.chosen() if isinstance(value, Choice) else value)
    return made
