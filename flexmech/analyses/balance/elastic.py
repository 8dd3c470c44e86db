"""Greatest forces of a balance between crank angles, of rigid links and of elastic links."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from flexmech.analyses.balance.compromise import inertia_loads
from flexmech.analyses.balance.request import BalanceRequest
from flexmech.analyses.default_engines import engine_for
from flexmech.analyses.extremes import Extremes, extremes
from flexmech.analyses.frequencies.positions import frequency_extremes, natural_frequencies
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.linkages.frame_forces import shaft_axis
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism

# Samples of a turn. Where the first natural frequency is beyond so many orders of the crank's speed
# the links respond quasi-statically, and so many steps between two samples suffice; speed alone: a
# step that resolves all frequencies, as it is chosen otherwise, takes minutes there.
_SAMPLES, _SLOW, _STEPS = 360, 100.0, 6
# Angles of the first natural frequency, which is sought between them.
_ANGLES = 12
_PEAKS = {"force": "peak_joint_force", "torque": "peak_driving_torque"}


@dataclass(frozen=True)
class ElasticShaking:
    """Shaking force by inertia of the elastic linkage in periodic motion, over one turn.

    Parameters
    ----------
    crank_angle : ndarray, shape (N,)
        In rad.
    force : ndarray, shape (N, 2)
        In N.
    moment : ndarray, shape (N,)
        In N m.
    force_error, moment_error : float
        By other time steps, component modes and elements, in N and N m.
    first_frequency : float
        Lowest natural frequency at rest over a turn, in Hz.
    frequency_error : float
        By twice the elements, relative.
    """

    crank_angle: FloatArray
    force: FloatArray
    moment: FloatArray
    force_error: float
    moment_error: float
    first_frequency: float
    frequency_error: float


def elastic_shaking(
    mechanism: Mechanism, speed: float, point: tuple[float, float] | None
) -> ElasticShaking:
    """Run the elastic linkage on its periodic motion, by the reference engine.

    What elastic links add to the forces on the frame is that of the run less that of rigid links;
    with the inertia of rigid links it is compared with theirs.

    Parameters
    ----------
    mechanism : Mechanism
    speed : float
        Speed of the crank in rad/s.
    point : tuple of float or None
        About which the moment is taken, m.

    Returns
    -------
    ElasticShaking

    Raises
    ------
    InputError, ComputationError
        As :func:`flexmech.response`.
    """
    engine = engine_for(mechanism)
    lowest, frequency_error = _lowest_frequency(engine)
    turn = 2 * np.pi / abs(speed)
    # Linear equations: their periodic motion is found directly, and comes back to itself.
    request = ResponseRequest(
        speed,
        revolutions=1.0,
        samples=_SAMPLES,
        start="periodic",
        step=turn / (_SAMPLES * _STEPS) if lowest * turn > _SLOW else None,
        prestress="equilibrium" if mechanism.is_free_strained else "axial",
        moment_point=point,
    )
    data = response(engine, request, check_mesh=True).dataset.isel(engine=0)
    motion = request.drive.motion(mechanism.linkage, data["time"].values)
    rigid = inertia_loads(mechanism, motion, point)
    force, moment = (
        (data[name] - data[f"rigid_{name}"]).transpose("time", ...).values
        for name in ("shaking_force", "shaking_moment")
    )
    about = shaft_axis(mechanism.linkage.topology, motion) if point is None else point
    errors = _errors(mechanism, data, float(np.abs(motion.origin - np.array(about)).max()))
    angle = data["crank_angle"].values
    shaking = rigid.force + force, rigid.moment + moment
    return ElasticShaking(angle, *shaking, *errors, lowest, frequency_error)


def _errors(mechanism: Mechanism, data: xr.Dataset, arm: float) -> tuple[float, float]:
    """Errors of a run's force on the frame in N, and of its moment in N m, with arms up to one."""
    topology = mechanism.linkage.topology
    joints = [one.joint for one in topology.clamps]
    joints += [one.joint for one in topology.pivots] + [one.joint for one in topology.sliders]

    def error(of: str) -> xr.DataArray:
        relative = sum(data[f"{by}_error_of_{of}"] for by in ("step", "reduction", "mesh"))
        return relative * data[_PEAKS[of]]

    force = float(error("force").sel(joint=joints).sum())
    return force, float(error("torque")) + arm * force


def _lowest_frequency(engine: Engine) -> tuple[float, float]:
    """Lowest natural frequency at rest over a turn in Hz, and its relative error by elements."""
    around = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    lowest = np.array([[True], [False]])
    found = frequency_extremes(engine, around, 0.0, modes=1, wanted=lowest)
    least = float(found.lowest_frequency[0])
    finer = engine.with_(elements=2 * engine.elements)
    again = float(natural_frequencies(finer, found.lowest_angle[0], modes=1)[..., 0])
    return least, abs(again - least) / least


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
        ``greatest``, ``greatest_angle`` and ``greatest_error`` over (state, quantity). Errors are
        not numbers where the linkage cannot be moved through all angles between.
    """
    joints = [f"{JOINT_FORCE}{name}" for name in states[0].linkage.topology.joint_names]
    names = ["shaking_force", "shaking_moment", "driving_torque", *joints]
    return _dataset(names, [_of_state(state, request) for state in states])


def _of_state(mechanism: Mechanism, request: BalanceRequest) -> Extremes:
    speed, joints = request.speed_of(mechanism), mechanism.linkage.topology.joint_names

    def loads_at(crank_angle: FloatArray) -> FloatArray:
        motion = mechanism.linkage.motion(crank_angle, speed)
        loads = inertia_loads(mechanism, motion, request.moment_point)
        forces = mechanism.without_loads_over_time.inverse_dynamics(motion).joint_force
        sizes = [np.linalg.norm(forces[name], axis=-1) for name in joints]
        shaking = np.linalg.norm(loads.force, axis=-1)
        return np.stack([shaking, np.abs(loads.moment), np.abs(loads.torque), *sizes], axis=1)

    return extremes(loads_at, request.crank_angles)


def elastic_peaks(found: Sequence[ElasticShaking]) -> xr.Dataset:
    """Greatest shaking force and moment of elastic links in periodic motion.

    Parameters
    ----------
    found : sequence of ElasticShaking
        Elastic shaking of each state.

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

        peaks = extremes(loads_at, each.crank_angle)
        known = peaks.error + np.array([each.force_error, each.moment_error])
        parts.append(replace(peaks, error=known))
    return _dataset(["elastic_shaking_force", "elastic_shaking_moment"], parts)


def _dataset(names: list[str], parts: Sequence[Extremes]) -> xr.Dataset:
    over = ("state", "quantity")
    fields = {"greatest": "greatest", "greatest_angle": "greatest_angle", "error": "greatest_error"}
    return xr.Dataset(
        {
            name: (over, np.stack([getattr(part, field) for part in parts]))
            for field, name in fields.items()
        },
        {"quantity": names},
    )
