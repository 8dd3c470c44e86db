"""A rotor on a coupling to a free shaft in the equations of motion: the last coordinate.

It counts from the prescribed angle of the crank, with which the frames of the links turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import SystemMatrices
from flexmech.linkages import Drive
from flexmech.time_domain.equations_of_motion.shaft_torque import RotorCoupling, ShaftTorque


@dataclass(frozen=True)
class DrivenRotor:
    """The rotor of a motor behind a coupling.

    Parameters
    ----------
    drive : Drive
        Of the frames.
    given : ShaftTorque
        Of the motor on the rotor.
    coupling : RotorCoupling
        That of ``given``.
    shaft : ndarray, shape (n,)
        By all coordinates but the rotor's, that by which the shaft turns.
    """

    drive: Drive
    given: ShaftTorque
    coupling: RotorCoupling
    shaft: FloatArray

    def added(self, time: FloatArray, matrices: SystemMatrices) -> SystemMatrices:
        """Matrices (m, n + 1, n + 1) with the rotor, at times (m,), of those without (m, n, n).

        What the coupling takes off the shaft is among these already.
        """
        _, damping, stiffness, *_ = self.given.at(time)
        motor, held = self.coupling.motor, self.coupling.stiffness
        damped = motor.coupling_damping
        return SystemMatrices(
            self._bordered(matrices.mass, 0.0, np.full(len(time), motor.inertia_at_crank)),
            self._bordered(matrices.damping, damped, damped + damping),
            self._bordered(matrices.stiffness, held, held + stiffness),
        )

    def force(self, time: FloatArray, force: FloatArray) -> FloatArray:
        """Forces (m, n + 1) on all coordinates, of those (m, n) on the ones without the rotor."""
        motor = np.interp(time, self.given.time, self.given.torque) + self.given.pull(time)
        lag = np.interp(time, self.given.time, self.coupling.lag)
        turned = self.coupling.motor.inertia_at_crank * self.drive.crank_acceleration(time)
        return np.column_stack([force, motor - lag - turned])

    def started(self, state: VibrationState) -> VibrationState:
        """A start with the twist that the coupling has at time zero."""
        position, velocity = state.position.copy(), state.velocity.copy()
        position[-1], velocity[-1] = self.coupling.start
        return VibrationState(position, velocity, state.acceleration)

    def _bordered(self, matrix: FloatArray, between: float, corner: FloatArray) -> FloatArray:
        count = matrix.shape[1]
        total = np.zeros((len(corner), count + 1, count + 1))
        total[:, :count, :count] = matrix
        total[:, :count, count] = total[:, count, :count] = -between * self.shaft
        total[:, count, count] = corner
        return total
