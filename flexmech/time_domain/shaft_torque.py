"""The torque that drives the rigid linkage: what a free shaft carries in a run in time."""

from __future__ import annotations

import numpy as np

from flexmech.linkages import CrankDrive
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

# Positions whose inverse dynamics are held in memory at a time.
BATCH = 4096


def rigid_torque(mechanism: Mechanism, drive: CrankDrive, time: FloatArray) -> FloatArray:
    """Torque on the shaft with which the rigid linkage and the shaft move as prescribed.

    Inverse dynamics under everything that acts on the linkage, and the shaft's own inertia times
    its acceleration in a run-up.

    Parameters
    ----------
    mechanism : Mechanism
    drive : CrankDrive
    time : ndarray, shape (m,)
        In s.

    Returns
    -------
    ndarray, shape (m,)
        In N m.

    Raises
    ------
    InputError
        If the connections do not determine the forces, or a spring has no direction.
    """
    torque = np.empty(len(time))
    for first in range(0, len(time), BATCH):
        some = time[first : first + BATCH]
        motion = drive.motion(mechanism.linkage, some)
        torque[first : first + BATCH] = mechanism.inverse_dynamics(motion, some).driving_torque
    return torque + mechanism.shaft_inertia * drive.crank_acceleration(time)
