"""The linkage running: response in time, by one engine or more."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Protocol, TypeVar, cast

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.default_engines import engine_for
from flexmech.analyses.requests import Engines, engine_of, engines_of
from flexmech.analyses.response.by_motor import with_motor
from flexmech.analyses.response.dataset import add_mesh_errors, build_dataset
from flexmech.analyses.response.plan import engines_in_state, planned
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.run import mesh_error, run_engine
from flexmech.analyses.response.settled import settled_with_links
from flexmech.analyses.response.shaped_run import check_stops, with_shaped_law
from flexmech.analyses.response.start import simulation_start
from flexmech.arrays import LabelledProgress, silent
from flexmech.choices import Integrator
from flexmech.dynamical_systems import ON_A_STEP
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment
from flexmech.linear_system import Engine
from flexmech.linkages import Drive, MotorDrive, MotorRun, SettledRun
from flexmech.linkages.motors.integrated_run import known_until
from flexmech.mechanism import Mechanism
from flexmech.threads import one_thread
from flexmech.time_domain import LinkState
from flexmech.validation import check_flag

System = TypeVar("System", covariant=True)


def response(
    engines: Engines,
    speed: ResponseRequest | Drive | MotorDrive | float | None = None,
    *,
    speed_unit: str | None = None,
    check_mesh: bool = False,
    environment: Environment | None = None,
    progress: LabelledProgress | None = None,
) -> Response:
    """Run a linkage at constant crank speed, by a law of motion of its crank, or under a motor.

    Engines that simulate (Exudyn) run the nonlinear motion; the others the equations of
    motion in link frames. Joint forces and torque are those up to half the lowest frequency
    at which the links vibrate along themselves. Each run is repeated with another time step.
    With a shaper a law that stops is run shaped as well, and what rings after both is told over
    the time of the move.

    Parameters
    ----------
    engines : Engine, Mechanism or sequence of them
        All of one mechanism; of a mechanism the reference engine is made.
    speed : float, Drive, MotorDrive or ResponseRequest, optional
        Crank speed in ``speed_unit``, a drive in rad/s, a motor, or all that a run can be asked to
        be. Left out: the mechanism's drive, or the greatest speed at which it operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s,
        that of the request, or that of the model file for the mechanism's speed.
    check_mesh : bool
        Run again with twice the elements.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the mechanism runs in; dry by default.
    progress : callable, optional
        Called with a label, the steps done and the steps to do.

    Returns
    -------
    Response

    Raises
    ------
    InputError
        If the linkage locks in the course of a turn, no engine is given, or links that bend
        without load (unequally wet ones) are to start straight.
    ComputationError
        If a run diverges or does not converge; names the time and the crank angle.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> request = flexmech.ResponseRequest(20.0, revolutions=0.25)
    >>> run = flexmech.response(engine, request)
    >>> [str(name) for name in run.dataset["deflection"].dims]
    ['engine', 'time', 'link']
    """
    check_flag(check_mesh, "check_mesh")
    engines, report = engines_of(engines), progress or silent
    request = _request(speed, speed_unit, engines[0].mechanism)
    engines, request = with_motor(engines, request, environment)
    chosen, lines = engines_in_state(engines, request, environment)
    check_stops(chosen, request)
    with one_thread():
        loss = CountedLoss.of(chosen[0])
        chosen = [loss.engine(each) for each in chosen]
        plan = planned(chosen, request)
        if isinstance(request.drive, SettledRun):
            turn = settled_with_links(chosen, request, plan.highest)
            request = replace(request, speed=turn)
            plan = replace(plan, time=request.sample_time(plan.refinement))
        elif isinstance(request.drive, MotorRun):
            known = known_until(request.drive, plan.until(request.step))
            request = replace(request, speed=known)
        runs = [run_engine(engine, request, plan, report) for engine in chosen]
        dataset = build_dataset(runs, request, plan)
        if check_mesh:
            add_mesh_errors(dataset, [mesh_error(run, request, plan, report) for run in runs])
        dataset = with_shaped_law(dataset, chosen, request, plan, report)
    if plan.note:
        dataset.attrs["prediction_note"] = plan.note
    dataset.attrs["environment_lines"] = "\n".join(lines)
    dataset.attrs |= theory_attributes(chosen, request.modes) | loss.attributes
    return Response(Response.schema().labelled(dataset))


def _request(
    speed: ResponseRequest | Drive | MotorDrive | float | None,
    unit: str | None,
    mechanism: Mechanism,
) -> ResponseRequest:
    """All that a run is asked to be, as it is usual but for the speed where that alone is given."""
    if not isinstance(speed, ResponseRequest):
        return ResponseRequest(speed, speed_unit=unit).of(mechanism)
    if unit is not None:
        raise InputError("speed_unit: the request has its own; give it there")
    return speed.of(mechanism)


class _HandsOver(Protocol[System]):
    """An engine whose running model is a system of its own program."""

    def running_system(
        self,
        drive: Drive,
        start: LinkState,
        step: float,
        steps: int,
        *,
        integrator: Integrator = "trapezoidal",
        stride: int = 1,
    ) -> System:
        """Hand over the system that the engine simulates."""


def exudyn_system(
    engine: _HandsOver[System] | Mechanism,
    speed: ResponseRequest | Drive | float | None = None,
    *,
    speed_unit: str | None = None,
    environment: Environment | None = None,
    progress: LabelledProgress | None = None,
) -> System:
    """Assemble the Exudyn system that :func:`response` runs, with named items and sensors.

    It is ready for ``system.mbs.SolveDynamic(system.settings)``, for the viewer, and for
    whatever Exudyn can do besides; ``system.script`` makes the same system without flexmech.

    Parameters
    ----------
    engine : ExudynEngine or Mechanism
        Of a mechanism that engine is made.
    speed : float, Drive or ResponseRequest, optional
        As of :func:`response`, whose run is made first to find the step where none is asked for.
    speed_unit : str, optional
        As of :func:`response`.
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
    >>> request = flexmech.ResponseRequest(20.0, 0.01, step=1e-4)
    >>> system = flexmech.exudyn_system(flexmech.ExudynEngine(mechanism, 2), request)
    >>> system.nodes["coupler_node_1"], system.objects["pin_A"], system.sensors["driving_torque"]
    (4, 13, 15)
    """
    asked = engine_of(engine_for(cast("Engine | Mechanism", engine), "exudyn"))
    if not hasattr(asked, "running_system"):
        raise InputError(
            f"the {asked.name} engine has no Exudyn system; give flexmech.ExudynEngine(mechanism)"
        )
    report, request = progress or silent, _request(speed, speed_unit, asked.mechanism)
    if isinstance(request.drive, MotorRun):
        raise InputError(
            "drive: an exported Exudyn system has no motor; give a crank speed or a law in its "
            "place, or run it by flexmech response"
        )
    [chosen], _ = engines_in_state([asked], request, environment)
    with one_thread():
        loss = CountedLoss.of(chosen)
        chosen = loss.engine(chosen)
        plan = planned([chosen], request)
        step = request.step
        if step is None:
            run = run_engine(chosen, request, plan, report)
            step = run.trajectory.step
        start = simulation_start(chosen, request, step)
        stride = request.sample_interval / step
        system = cast("_HandsOver[System]", chosen).running_system(
            request.drive,
            start,
            step,
            max(1, math.ceil(plan.time[-1] / step - ON_A_STEP)),
            integrator=request.integrator,
            stride=round(stride) if abs(stride - round(stride)) < ON_A_STEP else 1,
        )
        told = replace(cast(Any, system), remarks=tuple(loss.attributes.values()))
        return cast(System, told)
