"""A run by the shaped law beside that by the plain one, and the chart over the time of a move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import xarray as xr

from flexmech.analyses.response.agreement import errors_of
from flexmech.analyses.response.dataset import build_dataset
from flexmech.analyses.response.move_times import move_variables
from flexmech.analyses.response.plan import RunPlan, planned
from flexmech.analyses.response.request import FREE_SHAFT_GOES_ON, ResponseRequest
from flexmech.analyses.response.run import run_engine
from flexmech.analyses.response.shaping import (
    LawShaper,
    check_rest,
    ringing_modes,
    shaper_attributes,
    shaper_variables,
)
from flexmech.arrays import LabelledProgress
from flexmech.errors import InputError
from flexmech.linear_system import Engine

# Of the shaped run what is told beside the plain one.
_KEPT = (
    "deflection",
    "driving_torque",
    "driving_power",
    "crank_angle",
    "crank_speed_over_time",
    "crank_acceleration",
    "residual_envelope",
    "residual_amplitude",
    "residual_amplitude_at_end",
    "modal_amplitude",
    "peak_deflection",
    "peak_driving_torque",
    "peak_driving_power",
    "energy_error",
)


def check_stops(engines: Sequence[Engine], request: ResponseRequest) -> None:
    """Refuse a shaper and times of a move for what does not stop, before anything is computed.

    Parameters
    ----------
    engines : sequence of Engine
    request : ResponseRequest

    Raises
    ------
    InputError
    """
    if request.shaping is None and request.move_times is None:
        return
    if any(engine.shaft == "free" for engine in engines):
        raise InputError(FREE_SHAFT_GOES_ON)
    if request.move_times is not None and request.drive.law.blow is not None:
        raise InputError(
            "the law ends with a blow, which the equations that run the times of a move do not "
            'hold; leave --move-times out, or take a table with ends = "rest"'
        )
    if request.shaping is not None:
        check_rest(request)


def with_shaped_law(
    plain: xr.Dataset,
    engines: Sequence[Engine],
    request: ResponseRequest,
    plan: RunPlan,
    report: LabelledProgress,
) -> xr.Dataset:
    """Add the run by the shaped law, and the residual vibration over the time of a move.

    Parameters
    ----------
    plain : xarray.Dataset
        Of the run by the plain law.
    engines : sequence of Engine
        The first one's modes are those that the law is shaped for.
    request : ResponseRequest
    plan : RunPlan
        Of the plain run.
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    xarray.Dataset
        The same where neither is asked for.

    Raises
    ------
    InputError
        If no mode is seen to ring, or the linkage lacks one that is asked for.
    ComputationError
        If a run fails.
    """
    shaping, shaper, found = request.shaping, None, plain
    if shaping is not None:
        modes = shaping.modes or ringing_modes(plain)
        shaper = LawShaper.of(engines[0], request, shaping, modes)
        drive = shaper.shaped(request.drive)
        own = replace(request, speed=drive, shaping=None, move_times=None)
        own_plan = planned(engines, own)

        def told(label: str, done: int, total: int) -> None:
            report(f"{label}, shaped", done, total)

        runs = [run_engine(engine, own, own_plan, told) for engine in engines]
        found = found.merge(_beside(build_dataset(runs, own, own_plan)), compat="override")
        found = found.merge(shaper_variables(shaper), compat="override")
        found = found.assign_attrs(shaper_attributes(shaper, shaping, drive))
    moves = move_variables(engines, request, plan, shaper, report)
    return found.merge(moves, compat="override", combine_attrs="override").assign_attrs(moves.attrs)


def _beside(shaped: xr.Dataset) -> xr.Dataset:
    """What is told of the shaped run, under names and a time of its own."""
    kept = shaped.reset_coords()[[*_KEPT]]
    kept["residual_error"] = errors_of(shaped)["deflection"] * shaped["peak_deflection"]
    renamed = {str(name): f"shaped_{name}" for name in kept.data_vars}
    return kept.rename(renamed | {"time": "shaped_time"}).drop_attrs()
