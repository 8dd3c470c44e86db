"""Greatest values of a balance, sought between crank angles, and how far they are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from flexmech.analyses.balance.compromise import inertia_loads
from flexmech.analyses.balance.elastic import ElasticShaking
from flexmech.analyses.balance.request import BalanceRequest
from flexmech.analyses.extremes import Peaks, greatest_between
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.mechanism import Mechanism

JOINT_FORCE = "joint_force_"
"""Before the joint, in the name of the greatest of its force."""


def rigid_peaks(states: Sequence[Mechanism], request: BalanceRequest) -> xr.Dataset:
    """Greatest shaking force and moment, driving torque and joint forces of rigid links.

    Parameters
    ----------
    states : sequence of Mechanism
        As given, and balanced.
    request : BalanceRequest

    Returns
    -------
    xarray.Dataset
        ``greatest``, ``greatest_angle`` and ``greatest_error`` over (state, quantity). Of a linkage
        that cannot be moved through all angles between, errors are not numbers.
    """
    joints = [f"{JOINT_FORCE}{name}" for name in states[0].linkage.topology.joint_names]
    names = ["shaking_force", "shaking_moment", "driving_torque", *joints]
    return _dataset(names, [_of_state(state, request) for state in states])


def _of_state(mechanism: Mechanism, request: BalanceRequest) -> Peaks:
    speed, joints = request.speed_of(mechanism), mechanism.linkage.topology.joint_names

    def loads_at(crank_angle: FloatArray) -> FloatArray:
        motion = mechanism.linkage.motion(crank_angle, speed)
        loads = inertia_loads(mechanism, motion, request.moment_point)
        forces = mechanism.without_loads_over_time.inverse_dynamics(motion).joint_force
        sizes = [np.linalg.norm(forces[name], axis=-1) for name in joints]
        shaking = np.linalg.norm(loads.force, axis=-1)
        return np.stack([shaking, np.abs(loads.moment), np.abs(loads.torque), *sizes], axis=1)

    try:
        return greatest_between(loads_at, request.crank_angles)
    except InputError:
        # It passes a dead point, or a gap of its range of motion.
        values = loads_at(request.crank_angles)
        number = values.argmax(axis=0)
        unknown = np.full(values.shape[1], np.nan)
        return Peaks(values.max(axis=0), request.crank_angles[number], unknown)


def elastic_peaks(found: Sequence[ElasticShaking]) -> xr.Dataset:
    """Greatest shaking force and moment of elastic links in periodic motion.

    Parameters
    ----------
    found : sequence of ElasticShaking
        Of each state.

    Returns
    -------
    xarray.Dataset
        As of :func:`rigid_peaks`.
    """
    parts = []
    for each in found:
        force, moment = (CubicSpline(each.crank_angle, one) for one in (each.force, each.moment))

        def loads_at(angle: FloatArray, force: Any = force, moment: Any = moment) -> FloatArray:
            size = np.linalg.norm(force(angle), axis=-1)
            return np.stack([size, np.abs(moment(angle))], axis=1)

        peaks = greatest_between(loads_at, each.crank_angle)
        known = peaks.error + np.array([each.force_error, each.moment_error])
        parts.append(peaks._replace(error=known))
    return _dataset(["elastic_shaking_force", "elastic_shaking_moment"], parts)


def _dataset(names: list[str], parts: Sequence[Peaks]) -> xr.Dataset:
    over = ("state", "quantity")
    columns: Mapping[str, str] = {
        "greatest": "value",
        "greatest_angle": "angle",
        "greatest_error": "error",
    }
    return xr.Dataset(
        {
            name: (over, np.stack([getattr(part, field) for part in parts]))
            for name, field in columns.items()
        },
        {"quantity": names},
    )
