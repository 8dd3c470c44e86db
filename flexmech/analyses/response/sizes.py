"""What sizes motor and bearings of a running linkage, with the errors of its run."""

from __future__ import annotations

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
    engine: Engine, trajectory: Trajectory, request: ResponseRequest, given: Values, turns: int
) -> Values:
    """Means and peaks over the last turn of a periodic motion, or over the run.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the samples asked for.
    request : ResponseRequest
    given : dict
        What a motor gives; see :func:`flexmech.analyses.aspects.motor.motor_values`.
    turns : int
        Whole turns of a run on the periodic motion; 0 of other runs.

    Returns
    -------
    dict
    """
    drive, time, shaft = request.drive, trajectory.time, trajectory.shaft
    torque, speed = trajectory.driving_torque, drive.crank_speed(time)
    if shaft is None:
        torque = torque + engine.mechanism.shaft_inertia * drive.crank_acceleration(time)
    else:
        speed = speed + shaft.rate
    driven = [Driven("shaft", torque, speed)]
    if "motor_torque" in given:
        driven.append(Driven("motor", given["motor_torque"], given["motor_speed"]))
    counted = slice(-request.samples - 1, None) if turns else slice(None)
    names = engine.mechanism.linkage.topology.joint_names
    forces = trajectory.joint_force[counted]
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
