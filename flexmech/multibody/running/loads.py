"""Loads on a running linkage: weight, torque or motor, impacts, couples of sections.

Pulses of a hammer act on points of links. A point need not be a node: the force is put on the
element where the point is, which spreads it over its two nodes by its own shape functions (a
consistent load). A cable element does that itself; of the geometrically exact beam, which is linear
between its nodes, each node carries its share, on the pins' axis where the link is eccentric.

Couples of sections: the rigid motion of a link has the rotary inertia of its sections whatever the
element: a couple ``-rho I alpha`` a unit of length, with the angular acceleration of the link's
rigid frame. Its sections are normal to the axis, so that it is a force across the link at its end
and the opposite one at its start.

The states of a motor on the hub of a free shaft are coordinates of their own. A rotor on a coupling
has its angle at the crank as a coordinate. The charge that has flowed is one, whose rate is the
current; and the integral of speed control is the rate of another: a coordinate without mass would
leave Exudyn without accelerations at the start. Circuit and coupling are linear in them: inductance
and rotor stand in the mass matrix, resistance, back-EMF and damping in the damping matrix. Torque
curves and speed control are a user function. On a frame on springs all turn against that, which
bears the reaction, and a rotor behind a gear has the inertia of
:class:`flexmech.mechanics.running.ShaftTorque`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import DcMotor, Drive, DriveTrain, Linkage, MotorRun, RigidMotion
from flexmech.linkages.motion import direction, normal, quarter_turn
from flexmech.mechanics import LinkModel
from flexmech.mechanics.running import Impact, StepBlock, rigid_torque, with_rotor
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber, Made, SystemItems
from flexmech.multibody.links import BeamPart
from flexmech.multibody.running.user_functions import (
    Shaft,
    section_couples,
)

# Times of a run at which the crank's range is taken: between them it gains less than 1e-6 of it.
TIMES = 2001
# Degrees of a link's angle over the crank angle, the first whose last coefficients are below
# DIGITS, in rad. Most cranks that turn round need 64; a rocker near a dead point more.
DEGREES, DIGITS = (16, 32, 64, 128, 256), 1e-10
# In rad: links that turn with the crank have second derivatives of round-off alone.
UNIFORM = 1e-6
# Coordinates of the hub: two of its place, and its angle.
_HUB = 3


class LinkEnergies:
    """Kinetic and potential energies of an assembly, by Exudyn's coordinates.

    All of its mass is in rigid bodies at nodes, whose centres turn with them, and in a constant
    matrix: that of cables, and of the differences between the nodes of exact beams.

    Parameters
    ----------
    assembly : LinkAssembly
    links : sequence of LinkModel
        The links' matrices in the same coordinates.
    """

    def __init__(self, assembly: LinkAssembly, links: Sequence[LinkModel]) -> None:
        self._pull = np.array(assembly.mechanism.gravity)
        bodies = assembly.items.bodies
        self._angles = np.array([body.first + 2 for body in bodies], dtype=np.intp)
        self._places = self._angles[:, None] + [-2, -1]
        self._masses = np.array([body.mass for body in bodies])
        self._inertias = np.array([body.inertia for body in bodies])
        self._centres = np.array([body.centre for body in bodies]).reshape(-1, 2)
        # The potential counts from where attached bodies are on the pins' axis.
        self._level = sum(
            body.body.mass * assembly.parts[body.link].axis_below * self._pull[1]
            for body in assembly.attached
        )
        self._constant = np.zeros((assembly.system_size, assembly.system_size))
        self.weight: FloatArray = np.zeros(assembly.system_size)
        for first, matrix in assembly.items.masses:
            between = slice(first, first + len(matrix))
            self._constant[between, between] += matrix
        for number, part in assembly.beams:
            if part.bodies:
                continue
            columns, mass = part.coordinates, links[number].mass
            for body in links[number].bodies:
                mass = mass - body.rows.T @ body.matrices(np.zeros(()))[0] @ body.rows
            self._constant[columns, columns] = mass
            fields = np.stack([part.fields.along, part.fields.across])
            self.weight[columns] = mass @ (self._pull @ fields)

    def kinetic(self, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Kinetic energy, (m,), by coordinates and velocities (m, system_size)."""
        spin, rate = velocity[:, self._angles], velocity[:, self._places]
        lever = quarter_turn(self._arms(position))
        square = np.sum(rate * (rate + 2 * spin[..., None] * lever), axis=-1)
        of_bodies = square @ self._masses + spin**2 @ self._inertias
        return np.asarray(of_bodies + np.sum(velocity @ self._constant * velocity, axis=1)) / 2

    def gravity(self, position: FloatArray) -> FloatArray:
        """Potential of the weight but for a constant, (m,), by coordinates (m, system_size)."""
        lifted = (position[:, self._places] + self._arms(position)) @ self._pull @ self._masses
        return np.asarray(-lifted - position @ self.weight - self._level)

    def _arms(self, position: FloatArray) -> FloatArray:
        """From the nodes of bodies to their centres in m, (m, k, 2)."""
        (along, across), angle = self._centres.T[..., None], position[:, self._angles]
        return np.asarray(along * direction(angle) + across * normal(angle))


class SectionCouples:
    """Couples of the sections in a running system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    links : sequence of LinkModel
        The links' matrices in the same coordinates.
    """

    def __init__(self, assembly: LinkAssembly, links: Sequence[LinkModel]) -> None:
        self._assembly = assembly
        self._links = {
            number: (link, float(link.uncounted_rotary_inertia))
            for number, link in enumerate(links)
            if np.any(link.uncounted_rotary_inertia)
        }

    def add(self, drive: Drive, shaft: Shaft, duration: float) -> None:
        """Add the forces at the ends of the links.

        Parameters
        ----------
        drive : Drive
        shaft : Shaft
            Shaft of that drive.
        duration : float
            Duration of the run in s.
        """
        linkage = self._assembly.mechanism.linkage
        passed = np.asarray(drive.crank_angle(np.linspace(0.0, duration, TIMES)))
        first, last = float(passed.min()), float(passed.max())
        if first == last or not self._links:
            return
        last = min(last, first + 2 * np.pi)
        start = linkage.motion(drive.crank_angle(0.0))
        lead = shaft.start_angle - float(start.crank_angle)
        for number, (_, rotary) in self._links.items():
            series = _angle_over_crank(linkage, number, first, last)
            if drive.is_constant and np.abs(series.deriv(2).coef).max() < UNIFORM:
                continue
            part, items = self._assembly.parts[number], self._assembly.items
            items.begin(f"{part.name}: couples that accelerate its sections")
            for end, node, sign in (("start", part.nodes[0], -1), ("end", part.nodes[-1], 1)):
                name = f"{part.name}_sections_{end}"
                marker = items.add("MarkerNodePosition", name, nodeNumber=node)
                given = (shaft, lead, [first, last], series.coef.tolist(), sign * rotary)
                force = Made(section_couples, given)
                items.add_force(f"{name}_force", marker, loadVectorUserFunction=force)

    def energy_and_power(
        self,
        motion: RigidMotion,
        carried: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> tuple[FloatArray, FloatArray]:
        """Kinetic energy of the sections' rotation, and the power of their couples besides.

        Parameters
        ----------
        motion : RigidMotion
            The prescribed one, a batch of shape (m,), by which the couples are.
        carried : RigidMotion
            That of the link frames, which a frame on springs or a free shaft turns besides.
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Displacement of the links in these frames, in m and rad, and its rate.

        Returns
        -------
        ndarray, shape (m,)
            In J, of the prescribed motion.
        ndarray, shape (m,)
            In W, by all other motion of the ends.
        """
        energy, power = np.zeros((2, len(motion.crank_angle)))
        for number, (link, rotary) in self._links.items():
            omega, spin = motion.angular_velocity[:, number], carried.angular_velocity[:, number]
            (u, v), (u0, v0), length = link.end, link.start, link.readings.nodes[-1]
            q, change = displacement[number], rate[number]
            energy += rotary * length * omega**2 / 2
            drift = (spin - omega) * length + spin * (q[:, u] - q[:, u0])
            drift += change[:, v] - change[:, v0]
            power -= rotary * motion.angular_acceleration[:, number] * drift
        return energy, power


def _angle_over_crank(
    linkage: Linkage, link: int, first: float, last: float
) -> np.polynomial.Chebyshev:
    """Angle of a link over a range of crank angles, without jumps of whole turns."""
    for degree in DEGREES:
        places = np.polynomial.chebyshev.chebpts1(degree + 1)
        crank = (first + last + (last - first) * places) / 2
        angle = np.unwrap(linkage.motion(crank).angle[:, link])
        fitted = np.polynomial.Chebyshev.fit(crank, angle, degree, domain=[first, last])
        if np.abs(fitted.coef[-degree // 8 :]).max() < DIGITS:
            break
    return fitted


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
    def at_steps(cls, mechanism: Mechanism, drive: Drive, step: float, steps: int) -> Self:
        """Torque that drives the rigid linkage, at the time steps of a run.

        Parameters
        ----------
        mechanism : Mechanism
        drive : Drive
        step : float
            In s.
        steps : int

        Returns
        -------
        TorqueTable
        """
        time = step * np.arange(steps + 2, dtype=float)
        return cls(time, rigid_torque(mechanism, drive, time))

    def torque_at(self, time: FloatArray, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Torque on the hub in N m, (m,), whatever coordinates and rates.

        Parameters
        ----------
        time : ndarray, shape (m,)
        position, velocity : ndarray, shape (m, n)
            The system's coordinates and their rates.
        """
        return np.asarray(np.interp(time, self.time, self.torque))


@dataclass(frozen=True)
class MotorOnHub:
    """A motor that turns the hub of a free shaft.

    Parameters
    ----------
    run : MotorRun
        Run of the rigid linkage, whose motor and start it is.
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
        names = ("referenceCoordinates", "initialCoordinates", "initialCoordinates_t")
        given = dict.fromkeys(names, [0.0] * self.count)
        node = items.add(
            "NodeGenericODE2", "motor_node", numberOfODE2Coordinates=self.count, **given
        )
        return [node]

    def add_object(
        self,
        items: SystemItems,
        nodes: list[ItemNumber],
        hub: ItemNumber,
        frame: ItemNumber | None = None,
    ) -> None:
        """Add the motor between its node, that of the hub and that of what carries it.

        Parameters
        ----------
        items : SystemItems
        nodes : list of ItemNumber
            Its node, if it has one.
        hub : ItemNumber
            Node of the hub.
        frame : ItemNumber, optional
            Node of a frame on springs.
        """
        below = [] if frame is None else [frame]
        ahead = _HUB * len(below)
        every = np.eye(ahead + self.count + _HUB)
        mass, damping, stiffness = np.zeros((3, *every.shape))
        force = np.zeros(len(every))
        motor, control = self.run.drive.motor, self.run.drive.control
        spin = every[_HUB - 1] * len(below)
        shaft = every[-1] - spin
        rotor, first = shaft, ahead + int(self._train.is_coupled)
        counted = motor.inertia_at_crank * np.outer(every[-1], every[-1])
        if motor.coupling_stiffness is not None:
            rotor = every[ahead]
            twist, counted = np.outer(rotor - shaft, rotor - shaft), np.zeros_like(counted)
            stiffness += motor.coupling_stiffness * twist
            damping += motor.coupling_damping * twist
        geared = motor.gear_ratio * rotor + spin
        mass += motor.inertia * np.outer(geared, geared) - counted
        if isinstance(motor, DcMotor) and motor.has_current:
            constant = motor.gear_ratio * motor.torque_constant * rotor
            mass[first, first], damping[first, first] = motor.inductance, motor.resistance
            damping[first] += constant
            damping[:, first] -= constant
            force[first] = 0.0 if control is not None else motor.voltage
        if self._train.has_integral:
            mass[ahead + self.count - 1, ahead + self.count - 1] = 1.0
        function: dict[str, Any] = {}
        if control is not None or not motor.has_current:
            function["forceUserFunction"] = partial(self._force, rotor, spin)
        items.add(
            "ObjectGenericODE2",
            "motor",
            nodeNumbers=[*below, *nodes, hub],
            massMatrix=mass,
            dampingMatrix=damping,
            stiffnessMatrix=stiffness,
            forceVector=force,
            **function,
        )

    def torque_at(self, time: FloatArray, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Torque on the hub in N m, (m,).

        Parameters
        ----------
        time : ndarray, shape (m,)
        position, velocity : ndarray, shape (m, n)
            The system's coordinates and their rates.
        """
        motion = position[:, -1], velocity[:, -1]
        return self._train.on_crank(*motion, self._states(position.T, velocity.T))[0]

    def on_frame(self, block: StepBlock, position: FloatArray, velocity: FloatArray) -> StepBlock:
        """Records with the energies of the rotor on a frame on springs.

        Parameters
        ----------
        block : StepBlock
        position, velocity : ndarray, shape (m, n)
            As of :meth:`torque_at`.
        """
        train, motor = self._train, self.run.drive.motor
        states, speed, twist = self._states(position.T, velocity.T), velocity[:, -1], np.zeros(1)
        if train.is_coupled:
            twist = states[0] - position[:, -1]
        torque = motor.gear_ratio * train.motor_output(speed, states).torque
        return with_rotor(block, motor, twist, train.rotor_speed(speed, states), torque)

    def _states(self, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """States of the drive train, (k, ...).

        By coordinates (n, ...) and their rates, of which those of motor and hub are the last.
        """
        motor = slice(-self.count - _HUB, -_HUB)
        if not self._train.is_coupled:
            return velocity[motor]
        return np.concatenate([position[motor][:1], velocity[motor]])

    def _force(
        self,
        rotor: FloatArray,
        spin: FloatArray,
        mbs: Any,
        t: float,
        number: int,
        position: Any,
        velocity: Any,
    ) -> list[float]:
        """User function: what the torque curve, or the control's command, does.

        By the rows (n,) of the rotation of the rotor and of a frame.
        """
        rate = np.asarray(velocity)
        motor = self.run.drive.motor
        states = self._states(np.asarray(position), rate)
        given = self._train.motor_output(rate[-1] - spin @ rate, states)
        force = np.zeros(len(rate))
        if motor.has_current:
            force[int(self._train.is_coupled) - self.count - _HUB] = given.voltage
        else:
            force += motor.gear_ratio * given.torque * rotor
        if self._train.has_integral:
            force[-1 - _HUB] = given.rates[-1]
        return [float(value) for value in force]


def add_running_loads(assembly: LinkAssembly, energies: LinkEnergies) -> None:
    """Add point masses and weight, node by node.

    One object over all nodes, as in the model at standstill, would make each tangent dense.

    Parameters
    ----------
    assembly : LinkAssembly
        Not assembled yet.
    energies : LinkEnergies
        Energies of its links, for their weight.
    """
    x, y = assembly.mechanism.gravity
    for body in assembly.items.bodies if x or y else ():
        if body.mass:
            name = f"{body.number.name}_weight"
            assembly.items.begin(f"{body.number.name}: weight")
            marker = assembly.items.mark_place(f"{name}_centre", body.number, *body.centre)
            assembly.items.add_force(name, marker, body.mass * x, body.mass * y)
    for _, part in assembly.beams:
        if part.bodies:
            continue
        assembly.items.begin(f"{part.name}: point masses and weight")
        weights = energies.weight[part.coordinates].reshape(len(part.nodes), -1)
        for number, (node, mass, weight) in enumerate(
            zip(part.nodes, part.point_masses, weights, strict=True)
        ):
            if mass or weight.any():
                assembly.items.add(
                    "ObjectGenericODE2",
                    f"{part.name}_load_{number}",
                    nodeNumbers=[node],
                    massMatrix=np.diag([mass, mass] + [0.0] * (assembly.kind.per_node - 2)),
                    forceVector=weight,
                )


def add_impacts(assembly: LinkAssembly, drive: Drive, impacts: Sequence[Impact]) -> None:
    """Add the loads of impacts to a system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    drive : Drive
        By which the links' rigid frames turn, and the forces with them.
    impacts : sequence of Impact

    Raises
    ------
    InputError
        If one is on no link of the mechanism.
    """
    for count, impact in enumerate(impacts):
        assembly.items.begin(f"impact on {impact.point}")
        link = impact.point.index(assembly.topology)
        part = assembly.parts[link]
        if not isinstance(part, BeamPart):
            raise InputError(
                f"the impact is on the {part.name}, which is rigid; strike an elastic link"
            )
        for marker, share in _shares(assembly, part, impact.point.fraction, f"impact_{count}"):
            force = _pulse_force(impact, drive, assembly.mechanism.linkage, link, share)
            assembly.items.add_force(f"{marker.name}_force", marker, loadVectorUserFunction=force)


def _shares(
    assembly: LinkAssembly, part: BeamPart, fraction: float, name: str
) -> Iterator[tuple[ItemNumber, float]]:
    """Markers that carry a unit force on a point, and the share of each."""
    x = fraction * part.positions[-1]
    element = int(np.searchsorted(part.positions, x, side="right")) - 1
    element = min(element, len(part.elements) - 1)
    start, end = part.positions[element : element + 2]
    if not part.bodies:
        yield assembly.add_axis_marker(part, float(x), name), 1.0
        return
    inside = float((x - start) / (end - start))
    for number, share in ((element, 1 - inside), (element + 1, inside)):
        node_name = f"{name}_node_{number}"
        yield assembly.add_axis_marker(part, float(part.positions[number]), node_name), share


def _pulse_force(impact: Impact, drive: Drive, linkage: Linkage, link: int, share: float) -> Any:
    """User function of a load that carries a share of an impact's force in ground axes."""

    def force(mbs: Any, t: float, load: Any) -> list[float]:
        # Exudyn asks for it several times a step, nearly always outside the pulse.
        pulse = impact.pulse
        if not pulse.start < t < pulse.end:
            return [0.0, 0.0, 0.0]
        size = share * float(pulse.force(t))
        angle = float(drive.motion(linkage, np.array([t])).angle[0, link])
        if impact.direction == "transverse":
            angle += math.pi / 2
        return [size * math.cos(angle), size * math.sin(angle), 0.0]

    return force
