"""The running linkage as the Exudyn system that a response simulates."""

from __future__ import annotations

import math
from typing import Protocol, TypeVar, cast

from flexmech.analyses.requests import engine_of
from flexmech.analyses.response.plan import engines_in_state, planned
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.run import run_engine
from flexmech.analyses.response.start import simulation_start
from flexmech.choices import Integrator
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment
from flexmech.linear_system import Engine
from flexmech.linkages import CrankDrive
from flexmech.threads import one_thread
from flexmech.time_domain.recorded_runs import LinkState
from flexmech.types import LabelledProgress, silent

System = TypeVar("System", covariant=True)

# How far a sample may be off a step, in steps.
_ON_A_STEP = 1e-6


class _HandsOver(Protocol[System]):
    """An engine whose running model is a system of its own program."""

    def running_system(
        self,
        drive: CrankDrive,
        start: LinkState,
        step: float,
        steps: int,
        *,
        integrator: Integrator = "trapezoidal",
        stride: int = 1,
    ) -> System:
        """Hand over the system that the engine simulates."""


def exudyn_system(
    engine: _HandsOver[System],
    request: ResponseRequest,
    *,
    environment: Environment | None = None,
    progress: LabelledProgress | None = None,
) -> System:
    """Assemble the Exudyn system that :func:`response` runs, with named items and sensors.

    It is ready for ``system.mbs.SolveDynamic(system.settings)``, for the viewer, and for
    whatever Exudyn can do besides; ``system.script`` makes the same system without flexmech.

    Parameters
    ----------
    engine : ExudynEngine
    request : ResponseRequest
        Without a step, the run of :func:`response` is made first to find it.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the mechanism runs in; dry by default.
    progress : callable, optional
        Called with a label, the steps done and the steps to do.

    Returns
    -------
    ExudynSystem

    Raises
    ------
    InputError
        If the engine is not Exudyn's, or :func:`response` would refuse the request.
    ComputationError
        If no step is found, or no start.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> request = flexmech.ResponseRequest(flexmech.CrankDrive(20.0), 0.01, step=1e-4)
    >>> system = flexmech.exudyn_system(flexmech.ExudynEngine(mechanism, 2), request)
    >>> system.nodes["coupler_node_1"], system.objects["pin_A"], system.sensors["driving_torque"]
    (4, 14, 15)
    """
    asked = engine_of(cast(Engine, engine))
    if not hasattr(asked, "running_system"):
        raise InputError(
            f"the {asked.name} engine has no Exudyn system; give flexmech.ExudynEngine(mechanism)"
        )
    report = progress or silent
    [chosen], _ = engines_in_state([asked], request, environment)
    with one_thread():
        plan = planned([chosen], request)
        step = request.step
        if step is None:
            run = run_engine(chosen, request, plan.time, plan.highest, plan.band, report)
            step = run.trajectory.step
        start = simulation_start(chosen, request, step)
        stride = request.sample_interval / step
        return cast("_HandsOver[System]", chosen).running_system(
            request.drive,
            start,
            step,
            max(1, math.ceil(plan.time[-1] / step - 1e-9)),
            integrator=request.integrator,
            stride=round(stride) if abs(stride - round(stride)) < _ON_A_STEP else 1,
        )
