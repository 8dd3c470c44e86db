"""A motor on the hub of a running Exudyn system: its states are coordinates of their own.

The charge that has flowed is a coordinate, whose rate is the current; and the integral of speed
control is the rate of another: a coordinate without mass would leave Exudyn without accelerations
at the start. A circuit is linear in them: its inductance stands in the mass matrix, resistance and
back-EMF in the damping matrix. Torque curves and speed control are a user function.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import DcMotor, MotorRun
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
        """Coordinates besides those of the hub."""
        return self.run.equation.motor.state_count

    @property
    def start_rates(self) -> FloatArray:
        """Rates of the coordinates at time zero, (count,): the states."""
        return self.run.values[2:, 0]

    @property
    def _has_current(self) -> bool:
        return self.run.drive.motor.has_current

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
        mass, damping = np.zeros((2, size, size))
        force = np.zeros(size)
        motor, control = self.run.drive.motor, self.run.drive.control
        if isinstance(motor, DcMotor) and motor.has_current:
            constant = motor.gear_ratio * motor.torque_constant
            mass[0, 0], damping[0, 0] = motor.inductance, motor.resistance
            damping[0, -1], damping[-1, 0] = constant, -constant
            force[0] = 0.0 if control is not None else motor.voltage
        if control is not None and control.has_integral:
            mass[self.count - 1, self.count - 1] = 1.0
        function: dict[str, Any] = {}
        if control is not None or not self._has_current:
            function["forceUserFunction"] = self._force
        items.add(
            "ObjectGenericODE2",
            "motor",
            nodeNumbers=[*own, hub],
            massMatrix=mass,
            dampingMatrix=damping,
            stiffnessMatrix=np.zeros((size, size)),
            forceVector=force,
            **function,
        )

    def torque(self, velocity: FloatArray) -> FloatArray:
        """Torque on the hub in N m, (m,), by rates of the system's coordinates (m, total_size)."""
        states = velocity[:, -self.count - _HUB : -_HUB].T
        given = self.run.equation.motor.output(velocity[:, -1], states)
        return np.asarray(self.run.drive.motor.gear_ratio * given.torque)

    def _force(self, mbs: Any, t: float, number: int, position: Any, velocity: Any) -> list[float]:
        """User function: what the torque curve, or the control's command, does."""
        rate = np.asarray(velocity)
        driven_by, motor = self.run.equation.motor, self.run.drive.motor
        given = driven_by.output(rate[-1], rate[: self.count])
        force = np.zeros(self.count + _HUB)
        if motor.has_current:
            force[0] = given.voltage
        else:
            force[-1] = motor.gear_ratio * given.torque
        if driven_by.control is not None and driven_by.control.has_integral:
            force[self.count - 1] = given.rates[-1]
        return [float(own) for own in force]
