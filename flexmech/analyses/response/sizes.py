"""What sizes motor and bearings of a running linkage, with the errors of its run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.sizing import Driven, sizing_aspect, sizing_values
from flexmech.analyses.response.agreement import best_known, errors_of
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect
from flexmech.mechanics import Engine
from flexmech.mechanics.running import Trajectory

# A mean differs by no more than the greatest difference of the histories (Minkowski's inequality),
# and a peak by that of the peaks: their errors by the names of errors_of, and over which peak.
_ERRORS = {
    "rms_torque": ("driving_torque", "peak_torque"),
    "peak_torque": ("peak_driving_torque", "peak_torque"),
    "peak_power": ("peak_driving_torque", "peak_power"),
    "cubic_mean_force": ("joint_force", "peak_force"),
    "peak_force": ("peak_joint_force", "peak_force"),
}


def sizes_of_run(
    engine: Engine,
    refined: Trajectory,
    request: ResponseRequest,
    motor: Sequence[Driven],
    counted: slice,
) -> Values:
    """Means and peaks over the last turn of a periodic motion, or over the run.

    Parameters
    ----------
    engine : Engine
    refined : Trajectory
        At the refined samples.
    request : ResponseRequest
    motor : sequence of Driven
        A motor at these samples, if there is one.
    counted : slice
        Samples of the last turn, or all.

    Returns
    -------
    dict
    """
    drive, time, shaft = request.drive, refined.time, refined.shaft
    torque, speed = refined.driving_torque, drive.crank_speed(time)
    if shaft is None:
        torque = torque + engine.mechanism.shaft_inertia * drive.crank_acceleration(time)
    else:
        speed = speed + shaft.rate
    driven = [Driven("shaft", torque, speed), *motor]
    names = engine.mechanism.linkage.topology.joint_names
    forces = refined.joint_force[counted]
    return sizing_values(
        time[counted],
        [Driven(one.of, one.torque[counted], one.speed[counted]) for one in driven],
        {name: forces[:, number] for number, name in enumerate(names)},
        drive,
    )


def running_sizes_aspect(data: xr.Dataset) -> Aspect:
    """The same as a table and as numbers, of the engine whose errors are the smaller.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.

    Returns
    -------
    Aspect
    """
    if "sizing_value" not in data:
        return Aspect()
    errors = errors_of(data)
    place = best_known(errors["deflection"])
    own, values = data.isel(engine=place), data["sizing_value"].transpose("engine", "sizing").values
    quantities, of = (own[f"sizing_{name}"].values.tolist() for name in ("quantity", "of"))
    sizes = dict(zip(zip(quantities, of, strict=True), values[place].tolist(), strict=True))
    found = np.abs(values - values[place]).max(axis=0)
    for number, (name, one) in enumerate(sizes):
        if name in _ERRORS:
            cause, peak = _ERRORS[name]
            error = errors[cause].isel(engine=place)
            error = error.sel(joint=one) if "joint" in error.dims else error
            found[number] = max(found[number], float(error) * sizes[peak, one])
    return sizing_aspect(own, xr.DataArray(found, dims="sizing"))
