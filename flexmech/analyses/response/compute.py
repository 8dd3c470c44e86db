"""The linkage running: response in time, by one engine or more."""

from __future__ import annotations

from collections.abc import Sequence

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.datasets import with_units
from flexmech.analyses.response.dataset import add_mesh_errors, build_dataset
from flexmech.analyses.response.plan import engines_in_state, planned
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.run import mesh_error, run_engine
from flexmech.hygrothermal import Environment
from flexmech.linear_system import Engine
from flexmech.numbers import check_flag
from flexmech.threads import one_thread
from flexmech.types import LabelledProgress, silent


def response(
    engines: Engine | Sequence[Engine],
    request: ResponseRequest,
    *,
    check_mesh: bool = False,
    environment: Environment | None = None,
    progress: LabelledProgress | None = None,
) -> Response:
    """Run a linkage at constant crank speed.

    Engines that simulate (Exudyn) run the nonlinear motion; the others the equations of
    motion in link frames. Joint forces and torque are those up to half the lowest frequency
    at which the links vibrate along themselves. Each run is repeated with another time step.

    Parameters
    ----------
    engines : Engine or sequence of Engine
        All of one mechanism.
    request : ResponseRequest
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
    >>> request = flexmech.ResponseRequest(flexmech.CrankDrive(20.0), revolutions=0.25)
    >>> run = flexmech.response(engine, request)
    >>> [str(name) for name in run.dataset["deflection"].dims]
    ['engine', 'time', 'link']
    """
    check_flag(check_mesh, "check_mesh")
    report = progress or silent
    chosen, lines = engines_in_state(engines, request, environment)
    with one_thread():
        plan = planned(chosen, request)
        runs = [
            run_engine(engine, request, plan.time, plan.highest, plan.band, report)
            for engine in chosen
        ]
        dataset = build_dataset(runs, request, plan.refinement, plan.lowest, plan.highest)
        if check_mesh:
            add_mesh_errors(dataset, [mesh_error(run, request, report) for run in runs])
    if plan.note:
        dataset.attrs["prediction_note"] = plan.note
    dataset.attrs["environment_lines"] = "\n".join(lines)
    dataset.attrs |= theory_attributes(chosen, request.modes)
    return Response(with_units(dataset, "response"))
