"""The linkage running: response in time, by one engine or more."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexmech.analyses.response.dataset import SPECTRUM_REACH, build_dataset
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.run import highest_frequency, mesh_error, run_engine
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.threads import one_thread

__all__ = ["response"]

Progress = Callable[[str, int, int], None]

# Samples in a period of the highest frequency of the spectra; two would be the limit.
SAMPLES_PER_PERIOD = 2.5


def response(
    engines: Engine | Sequence[Engine],
    request: ResponseRequest,
    *,
    check_mesh: bool = False,
    progress: Progress | None = None,
) -> Response:
    """Run a linkage at constant crank speed.

    Engines that simulate (Exudyn) run the nonlinear motion; the others the linear
    equations of motion in link frames. Each run is repeated with another time step.

    Parameters
    ----------
    engines : Engine or sequence of Engine
        All of one mechanism.
    request : ResponseRequest
    check_mesh : bool
        Run again with twice the elements.
    progress : callable, optional
        Called with a label, the steps done and the steps to do.

    Returns
    -------
    Response

    Raises
    ------
    InputError
        If the linkage locks in the course of a turn, or no engine is given.
    ComputationError
        If a run diverges or does not converge; names the time and the crank angle.
    """
    chosen = [engines] if isinstance(engines, Engine) else list(engines)
    if not chosen:
        raise InputError("response needs one engine or more")
    # A crank that cannot turn round shows itself here, before anything is computed.
    chosen[0].mechanism.linkage.motion(
        np.asarray(request.drive.crank_angle(request.sample_time())), 1.0
    )
    with one_thread():
        highest = highest_frequency(chosen[0], request)
        fastest = SAMPLES_PER_PERIOD * SPECTRUM_REACH * highest
        refinement = max(1, int(np.ceil(fastest * request.sample_interval)))
        time = request.sample_time(refinement)
        runs = [run_engine(e, request, time, highest, _labelled(progress, e)) for e in chosen]
        mesh_errors = [mesh_error(run, request) for run in runs] if check_mesh else None
        return Response(build_dataset(runs, request, refinement, highest, mesh_errors))


def _labelled(progress: Progress | None, engine: Engine) -> Callable[[int, int], None] | None:
    if progress is None:
        return None
    return lambda done, total: progress(engine.name, done, total)
