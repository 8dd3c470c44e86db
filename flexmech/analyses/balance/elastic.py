"""What elastic links make of a balance: shaking force of the running linkage, first frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.balance.compromise import inertia_loads
from flexmech.analyses.default_engines import engine_for
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray
from flexmech.mechanism import Mechanism

# Samples of a turn. Where the first natural frequency is beyond so many orders of the crank's speed
# the links respond quasi-statically, and so many steps between two samples suffice; speed alone: a
# step that resolves all frequencies, as it is chosen otherwise, takes minutes there.
_SAMPLES, _SLOW, _STEPS = 360, 100.0, 6
# Of the first natural frequency, which changes by little from one to the next.
_ANGLES = 12


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
    first_frequency : float
        Lowest natural frequency at rest, at any of some crank angles, in Hz.
    """

    crank_angle: FloatArray
    force: FloatArray
    moment: FloatArray
    first_frequency: float


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
    around = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    lowest = float(natural_frequencies(engine, around, modes=1).min())
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
    data = response(engine, request).dataset.isel(engine=0)
    motion = request.drive.motion(mechanism.linkage, data["time"].values)
    rigid = inertia_loads(mechanism, motion, point)
    force, moment = (
        (data[name] - data[f"rigid_{name}"]).transpose("time", ...).values
        for name in ("shaking_force", "shaking_moment")
    )
    angle = data["crank_angle"].values
    return ElasticShaking(angle, rigid.force + force, rigid.moment + moment, lowest)
