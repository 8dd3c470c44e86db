"""What elastic links make of a balance: shaking force of the running linkage, first frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.balance.compromise import inertia_loads
from flexmech.analyses.default_engines import engine_for
from flexmech.analyses.frequencies.positions import frequency_extremes, natural_frequencies
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine
from flexmech.linkages.frame_forces import shaft_axis
from flexmech.mechanism import Mechanism

# Samples of a turn. Where the first natural frequency is beyond so many orders of the crank's speed
# the links respond quasi-statically, and so many steps between two samples suffice; speed alone: a
# step that resolves all frequencies, as it is chosen otherwise, takes minutes there.
_SAMPLES, _SLOW, _STEPS = 360, 100.0, 6
# Of the first natural frequency, which is sought between them.
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
        Of the crank in rad/s.
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
