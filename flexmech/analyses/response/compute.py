"""The linkage running: response in time, by one engine or more."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.environment import environment_lines
from flexmech.analyses.frequencies import natural_frequencies
from flexmech.analyses.provenance import with_units
from flexmech.analyses.requests import engines_of
from flexmech.analyses.response.dataset import SPECTRUM_REACH, add_mesh_errors, build_dataset
from flexmech.analyses.response.request import MOST_SAMPLES, ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.run import mesh_error, run_engine
from flexmech.analyses.turn import sampled_turn
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.linear_system import Engine
from flexmech.threads import one_thread
from flexmech.time_domain import lowest_axial_frequency
from flexmech.types import LabelledProgress

__all__ = ["response"]


# Samples in a period of the highest frequency of the spectra; two would be the limit.
SAMPLES_PER_PERIOD = 2.5
# Forces and torque count up to this part of the lowest frequency at which the links vibrate
# along themselves: what rings faster depends on the time step and on how the start is idealized.
FORCE_BAND = 0.5


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
    chosen = engines_of(engines, request.modes)
    report = progress or (lambda label, done, total: None)
    lines = environment_lines(chosen[0].mechanism, environment)
    if environment is not None:
        wet = mechanism_in_state(chosen[0].mechanism, environment)
        chosen = [engine.with_(mechanism=wet).fit_for(request.modes) for engine in chosen]
    mechanism = chosen[0].mechanism
    if request.start == "rigid" and mechanism.is_free_strained:
        raise InputError(
            "start rigid would hold links straight that are bent without any load, and then let "
            "them ring; choose start equilibrium or periodic"
        )
    # A crank that cannot turn round shows itself here, before anything is computed.
    mechanism.linkage.motion(request.drive.crank_angle(request.sample_time()), 1.0)
    with one_thread():
        lowest, highest = _predicted_range(chosen, request)
        refinement = _refinement(request, highest)
        time = request.sample_time(refinement)
        band = FORCE_BAND * lowest_axial_frequency(
            chosen[0], sampled_turn(request.drive.start_angle)
        )
        runs = [run_engine(engine, request, time, highest, band, report) for engine in chosen]
        dataset = build_dataset(runs, request, refinement, lowest, highest)
        if check_mesh:
            add_mesh_errors(dataset, [mesh_error(run, request, report) for run in runs])
    dataset.attrs["environment_lines"] = "\n".join(lines)
    dataset.attrs |= theory_attributes(chosen, request.modes)
    return Response(with_units(dataset, "response"))


def _predicted_range(engines: Sequence[Engine], request: ResponseRequest) -> tuple[float, float]:
    """Lowest and highest natural frequency of interest, at rest over a turn, in Hz."""
    first, turn = engines[0], sampled_turn(request.drive.start_angle)
    frequency = natural_frequencies(
        first, turn, modes=request.modes, prestress=first.prestress_at_rest, rotation_terms=False
    )
    for engine in engines:
        # Frequencies at speed that cannot be computed show themselves before the long run.
        natural_frequencies(
            engine, turn, request.drive.speed, modes=request.modes, prestress=request.prestress
        )
    return float(frequency.min()), float(frequency.max())


def _refinement(request: ResponseRequest, highest: float) -> int:
    """Samples taken for each one asked for, so that the spectra's frequencies show."""
    fastest = SAMPLES_PER_PERIOD * SPECTRUM_REACH * highest
    if not fastest * request.duration <= MOST_SAMPLES:
        raise InputError(
            f"a run of {request.duration:.3g} s holds more vibrations of up to "
            f"{SPECTRUM_REACH * highest:.3g} Hz than {MOST_SAMPLES} samples can show; ask for "
            "fewer revolutions, or a higher crank speed"
        )
    return max(1, int(np.ceil(fastest * request.sample_interval)))
