"""Rigid motion and inverse dynamics along a law of motion of the crank, over time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from flexmech.analyses.kinematics.quantities import Forces, extremes_dataset
from flexmech.arrays import FloatArray
from flexmech.linkages import Drive, InverseDynamics, TableDrive
from flexmech.mechanism import Mechanism

# Between two of these parts of a run a linkage and its loads have one extreme.
_PARTS = 720


def forces_along(
    mechanism: Mechanism, drive: Drive, lumped: tuple[int, ...] | None
) -> Callable[[FloatArray], tuple[InverseDynamics, InverseDynamics | None]]:
    """Inverse dynamics at times of a run.

    Parameters
    ----------
    mechanism : Mechanism
    drive : Drive
    lumped : tuple of int or None
        Elements of each link, for forces by lumped masses too.

    Returns
    -------
    callable
        From times (A,) in s to the forces there, by distributed masses and by lumped ones if any.
    """

    def at(time: FloatArray) -> tuple[InverseDynamics, InverseDynamics | None]:
        motion = drive.motion(mechanism.linkage, time)
        forces = mechanism.inverse_dynamics(motion, time)
        if lumped is None:
            return forces, None
        return forces, mechanism.inverse_dynamics(motion, time, lumped)

    return at


def over_time(
    dataset: xr.Dataset,
    mechanism: Mechanism,
    drive: Drive,
    time: FloatArray,
    at: Forces,
    point: tuple[float, float] | None,
) -> xr.Dataset:
    """The dataset of positions along a run with time as what it is over, and its extremes.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over crank_angle: of the positions at the times.
    mechanism : Mechanism
    drive : Drive
    time : ndarray, shape (A,)
        In s.
    at : callable
        Of :func:`forces_along`.
    point : tuple of float or None
        About which the shaking moment is taken, m.

    Returns
    -------
    xarray.Dataset
    """
    inertia = mechanism.shaft_inertia
    acceleration = drive.crank_acceleration(time)
    dataset = dataset.reset_index("crank_angle").rename_dims(crank_angle="time")
    dataset = dataset.assign_coords(time=time).assign(
        crank_speed_over_time=("time", drive.crank_speed(time)),
        crank_acceleration=("time", acceleration),
    )
    if inertia:
        dataset["shaft_inertia_torque"] = "time", inertia * acceleration

    def shaft_torque(times: FloatArray) -> FloatArray:
        return np.asarray(inertia * drive.crank_acceleration(times))

    step = float(time[-1] - time[0]) / _PARTS
    found = extremes_dataset(mechanism, at, time, point, shaft_torque, step=step)
    for name in ("least", "greatest"):
        when = found[f"{name}_angle"].values
        found[f"{name}_time"] = "extreme", when
        found[f"{name}_angle"] = "extreme", drive.crank_angle(when)
    attributes: dict[str, str | float] = {"drive": drive.words, "run_up_time": drive.law_time}
    if isinstance(drive, TableDrive):
        attributes["drive_note"] = drive.spline_words
    return dataset.merge(found).assign_attrs(attributes)
