"""The torque on a free shaft of a running Exudyn system: that of the rigid linkage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.linkages import CrankDrive
from flexmech.mechanism import Mechanism
from flexmech.multibody.items import Made
from flexmech.multibody.user_functions import torque_history
from flexmech.time_domain.recorded_runs import rigid_torque
from flexmech.types import FloatArray


@dataclass(frozen=True)
class TorqueTable:
    """Torque at times, linear between them.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Increasing, in s.
    torque : ndarray, shape (n,)
        In N m.
    """

    time: FloatArray
    torque: FloatArray

    @classmethod
    def at_steps(cls, mechanism: Mechanism, drive: CrankDrive, step: float, steps: int) -> Self:
        """Torque that drives the rigid linkage, at the time steps of a run.

        Parameters
        ----------
        mechanism : Mechanism
        drive : CrankDrive
        step : float
            In s.
        steps : int

        Returns
        -------
        TorqueTable
        """
        time = step * np.arange(steps + 2, dtype=float)
        return cls(time, rigid_torque(mechanism, drive, time))

    def at(self, time: FloatArray) -> FloatArray:
        """Torque at times (m,) in N m."""
        return np.asarray(np.interp(time, self.time, self.torque))

    def user_function(self) -> Made:
        """The same for Exudyn and for the script that makes the system."""
        return Made(torque_history, (self.time.tolist(), self.torque.tolist()))
