"""A motor on the hub of a running Exudyn system: its states are coordinates of their own.

A rotor on a coupling has its angle at the crank as a coordinate. The charge that has flowed is
one, whose rate is the current; and the integral of speed control is the rate of another: a
coordinate without mass would leave Exudyn without accelerations at the start. Circuit and coupling
are linear in them: inductance and rotor stand in the mass matrix, resistance, back-EMF and damping
in the damping matrix. Torque curves and speed control are a user function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import DcMotor, DriveTrain, MotorRun
from flexmech.multibody.items import ItemNumber, SystemItems

# Coordinates of the hub: two of its place, and its angle.
_HUB = 3


@dataclass(frozen=True)
class MotorOnHub:
    """A motor that turns the hub of a free shaft.

    Parameters
    ----------
    run : MotorRun
        Of the rigid linkage, whose motor and start it is.
    """

    run: MotorRun

    @property
    def count(self) -> int:
        """Coordinates besides those of the hub: of a rotor that turns by itself, of the motor."""
        return self._train.state_count - int(self._train.is_coupled)

    def start(self, hub: float) -> tuple[FloatArray, FloatArray]:
        """Coordinates (count,) at time zero and their rates, where the hub has an angle in rad."""
        begin = self.run.values[:, 0]
        if not self._train.is_coupled:
            return np.zeros(self.count), begin[2:]
        place = np.zeros(self.count)
        place[0] = hub + begin[2] - begin[0]
        return place, begin[3:]

    @property
    def _train(self) -> DriveTrain:
        return self.run.equation.train

    def add_node(self, items: SystemItems) -> list[ItemNumber]:
        """Add the node of the coordinates, if there are any, before that of the hub."""
        if not self.count:
            return []
        zeros = [0.0] * self.count
        return [
            items.add(
                "NodeGenericODE2",
                "motor_node",
                numberOfODE2Coordinates=self.count,
                referenceCoordinates=zeros,
                initialCoordinates=zeros,
                initialCoordinates_t=zeros,
            )
        ]

    def add_object(self, items: SystemItems, own: list[ItemNumber], hub: ItemNumber) -> None:
        """Add the motor between its node and that of the hub.

        Parameters
        ----------
        items : SystemItems
        own : list of ItemNumber
            Its node, if it has one.
        hub : ItemNumber
            Node of the hub.
        """
        size = self.count + _HUB
        mass, damping, stiffness = np.zeros((3, size, size))
        force = np.zeros(size)
        motor, control = self.run.drive.motor, self.run.drive.control
        rotor, first = self._rotor, int(self._train.is_coupled)
        if motor.coupling_stiffness is not None:
            twist = np.zeros(size)
            twist[[rotor, -1]] = 1.0, -1.0
            mass[rotor, rotor] = motor.inertia_at_crank
            stiffness += motor.coupling_stiffness * np.outer(twist, twist)
            damping += motor.coupling_damping * np.outer(twist, twist)
        if isinstance(motor, DcMotor) and motor.has_current:
            constant = motor.gear_ratio * motor.torque_constant
            mass[first, first], damping[first, first] = motor.inductance, motor.resistance
            damping[first, rotor], damping[rotor, first] = constant, -constant
            force[first] = 0.0 if control is not None else motor.voltage
        if self._train.has_integral:
            mass[self.count - 1, self.count - 1] = 1.0
        function: dict[str, Any] = {}
        if control is not None or not motor.has_current:
            function["forceUserFunction"] = self._force
        items.add(
            "ObjectGenericODE2",
            "motor",
            nodeNumbers=[*own, hub],
            massMatrix=mass,
            dampingMatrix=damping,
            stiffnessMatrix=stiffness,
            forceVector=force,
            **function,
        )

    def torque(self, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Torque on the hub in N m, (m,), by the system's coordinates (m, total_size) and rates."""
        motion = position[:, -1], velocity[:, -1]
        return self._train.on_crank(*motion, self._states(position.T, velocity.T))[0]

    @property
    def _rotor(self) -> int:
        """Coordinate of the motor and the hub by which the rotor turns."""
        return 0 if self._train.is_coupled else -1

    def _states(self, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """States of the drive train, (k, ...).

        By coordinates (n, ...) and their rates, of which those of motor and hub are the last.
        """
        own = slice(-self.count - _HUB, -_HUB)
        if not self._train.is_coupled:
            return velocity[own]
        return np.concatenate([position[own][:1], velocity[own]])

    def _force(self, mbs: Any, t: float, number: int, position: Any, velocity: Any) -> list[float]:
        """User function: what the torque curve, or the control's command, does."""
        rate = np.asarray(velocity)
        motor = self.run.drive.motor
        states = self._states(np.asarray(position), rate)
        given = self._train.motor_output(rate[-1], states)
        force = np.zeros(self.count + _HUB)
        if motor.has_current:
            force[int(self._train.is_coupled)] = given.voltage
        else:
            force[self._rotor] = motor.gear_ratio * given.torque
        if self._train.has_integral:
            force[self.count - 1] = given.rates[-1]
        return [float(own) for own in force]
