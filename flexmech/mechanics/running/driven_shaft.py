"""A free shaft in the equations of motion: its rotation is among the coordinates.

The frames of the links turn with the prescribed motion. The shaft carries the torque that keeps the
rigid linkage in it, by virtual work: the forces on the links and this torque do no work as the
rigid linkage turns; or that of a motor (:class:`ShaftTorque`). What the equations give is turned
back afterwards into the frames of the rigid linkage at the angle that the shaft has.

Where links stretch by the square of their slopes the shaft has the natural coordinates ``d`` of
:mod:`flexmech.mechanics.running.natural_coordinates`. By its rotation phi its torque
T does the virtual work ``T dphi = T ((1 + d_1) dd_2 - d_2 dd_1)``: the force T on ``d_2``, and a
stiffness. In linear equations phi itself is a coordinate, and all is of the first order in it.

A motor's torque depends on the speed of its shaft, and on the past where it has a current or a
controller. Along a known motion of what it turns, the crank's shaft or a rotor on a coupling to
that, it is a history; beside that it changes by ``-damping * rate - stiffness * rotation``, of the
coordinate by which that turns. Runs are repeated, each with the torque along the motion of the one
before (Newton's method on the whole motion), until nothing changes: what was left out of the
change does not matter then. The coordinate of a rotor on a coupling comes after those of the
links. It counts from the prescribed angle of the crank, with which the frames of the links turn.

All torques act between the shaft or the rotor and what carries them, the ground or a frame on
springs, and all their coordinates are rotations against that: on the coordinates of the frame they
have no share, since these carry stator and crank alike. A rotor with the inertia J behind a gear of
the ratio n, which keeps the sense of rotation, turns n times as fast as the crank against the
frame, and with the frame: its kinetic energy is ``J (n theta' + phi')^2 / 2``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import VibrationState
from flexmech.linkages import Drive, Motor, RigidMotion
from flexmech.mechanics import Engine, LinkFrames, SystemMatrices
from flexmech.mechanics.links.link_inertia import field_coefficients
from flexmech.mechanics.running.natural_coordinates import RunLink
from flexmech.mechanics.running.recorded_run import ShaftMotion, StepBlock, Trajectory, rigid_torque


@dataclass(frozen=True)
class RotorCoupling:
    """A coupling to the crank's shaft along a known motion.

    Parameters
    ----------
    start : tuple of float
        Twist at time zero in rad, and its rate in rad/s.
    torque : ndarray, shape (m,)
        On the crank at the times of the known motion, in N m.
    lag : ndarray, shape (m,)
        What the coupling's torque by the coordinate of the shaft has less than by its rotation.
    """

    start: tuple[float, float]
    torque: FloatArray
    lag: FloatArray

    def started(self, state: VibrationState, rotor: int) -> VibrationState:
        """A start with the twist that the coupling has at time zero.

        Parameters
        ----------
        state : VibrationState
        rotor : int
            Number of the coordinate of the rotor.
        """
        position, velocity = state.position.copy(), state.velocity.copy()
        position[rotor], velocity[rotor] = self.start
        return VibrationState(position, velocity, state.acceleration)


@dataclass(frozen=True)
class ShaftTorque:
    """Torque of a motor at the crank along a motion, and how it changes beside it.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Increasing, in s.
    torque : ndarray, shape (m,)
        Along the motion, in N m.
    damping, stiffness : ndarray, shape (m,)
        In N m s/rad and N m/rad.
    across, turning : ndarray, shape (m,)
        Coordinate by which the shaft, or the rotor, turns in that motion, and its rate.
    motor : Motor
    coupling : RotorCoupling, optional
        Between rotor and shaft.
    recorded : list
        Records, filled by :meth:`record`.
    """

    time: FloatArray
    torque: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    across: FloatArray
    turning: FloatArray
    motor: Motor
    coupling: RotorCoupling | None = None
    recorded: list[tuple[FloatArray, ...]] = field(default_factory=list, compare=False)

    def at(self, time: FloatArray) -> tuple[FloatArray, ...]:
        """Torque, damping, stiffness, and the coordinate with its rate, at times (m,) in s."""
        known = (self.torque, self.damping, self.stiffness, self.across, self.turning)
        return tuple(np.interp(time, self.time, values) for values in known)

    def pull(self, time: FloatArray) -> FloatArray:
        """What damping and stiffness take off too much at the known motion, (m,) in N m."""
        _, damping, stiffness, across, turning = self.at(time)
        return np.asarray(damping * turning + stiffness * across)

    def on_shaft(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Torque on the shaft along the motion, and where its coordinates are zero, (m,) in N m."""
        if self.coupling is None:
            torque = np.interp(time, self.time, self.torque)
            return torque, torque + self.pull(time)
        known = self.coupling.torque, self.coupling.lag
        torque, lag = (np.interp(time, self.time, values) for values in known)
        return torque, lag

    def added(
        self, time: FloatArray, matrices: SystemMatrices, shaft: FloatArray
    ) -> SystemMatrices:
        """Matrices with the answer of the motor, and with its rotor.

        A rotor without a coupling is in the inertia of the shaft, as if it stood on the crank: on a
        frame on springs it gets the rates that it has behind its gear.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        matrices : SystemMatrices
            Matrices of all coordinates but the rotor's, (m, n, n): of the links, and of a frame on
            springs.
        shaft : ndarray, shape (size,)
            By those of the links, that by which the shaft turns.

        Returns
        -------
        SystemMatrices
            Arrays of shape (m, n + 1, n + 1) with a coupling, after the coordinates of the links.
        """
        size, count = len(shaft), matrices.mass.shape[1]
        new = [size] * (self.coupling is not None)
        parts = (matrices.mass, matrices.damping, matrices.stiffness)
        mass, damped, held = (np.insert(np.insert(m, new, 0.0, 1), new, 0.0, 2) for m in parts)
        every, motor = np.eye(mass.shape[1]), self.motor
        turned, frame = shaft @ every[:size], every[-1] * (count > size)
        counted = motor.inertia_at_crank * np.outer(turned + frame, turned + frame)
        if self.coupling is not None:
            assert motor.coupling_stiffness is not None
            twist, turned = np.outer(every[size] - turned, every[size] - turned), every[size]
            damped += motor.coupling_damping * twist
            held += motor.coupling_stiffness * twist
            counted = np.zeros_like(counted)
        geared = motor.gear_ratio * turned + frame
        mass += motor.inertia * np.outer(geared, geared) - counted
        _, damping, stiffness, *_ = self.at(time)
        damped += damping[:, None, None] * np.outer(turned, turned)
        held += stiffness[:, None, None] * np.outer(turned, turned)
        return SystemMatrices(mass, damped, held)

    def forces(
        self, time: FloatArray, force: FloatArray, acceleration: FloatArray, size: int
    ) -> FloatArray:
        """Forces (m, n) with that on the rotor on a coupling, (m, n + 1), and with its inertia.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        force : ndarray, shape (m, n)
        acceleration : ndarray, shape (m,)
            Acceleration of the prescribed angle of the crank in rad/s^2.
        size : int
            Number of coordinates of the links, before those of a frame on springs.
        """
        at_crank, total = self.motor.inertia_at_crank, force.copy()
        if force.shape[1] > size:
            counted = at_crank * (self.coupling is None)
            total[:, -1] += (counted - self.motor.inertia * self.motor.gear_ratio) * acceleration
        if self.coupling is None:
            return total
        motor = np.interp(time, self.time, self.torque) + self.pull(time)
        lag = np.interp(time, self.time, self.coupling.lag)
        return np.insert(total, size, motor - lag - at_crank * acceleration, axis=1)

    def beside(self, time: FloatArray, across: FloatArray, turning: FloatArray) -> FloatArray:
        """The torque of the motor (m,) where the coordinate and its rate have some values.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        across, turning : ndarray, shape (m,)
        """
        torque, damping, stiffness, *known = self.at(time)
        return np.asarray(torque - damping * (turning - known[1]) - stiffness * (across - known[0]))

    def record(self, *histories: FloatArray) -> None:
        """Keep more steps: see :attr:`history`."""
        self.recorded.append(histories)

    @property
    def history(self) -> tuple[FloatArray, ...]:
        """What was recorded, each (m,), once at every instant.

        The time; the shaft's coordinate and its rate; its rotation and the rate of that; and of a
        rotor on a coupling its coordinate and rate.
        """
        parts = [np.concatenate(blocks) for blocks in zip(*self.recorded, strict=True)]
        time, first = np.unique(parts[0], return_index=True)
        return (time, *(values[first] for values in parts[1:]))


def with_rotor(
    block: StepBlock, motor: Motor, twist: FloatArray, speed: FloatArray, torque: FloatArray
) -> StepBlock:
    """Records on a frame on springs with the energies of a rotor, whose reaction the frame bears.

    Parameters
    ----------
    block : StepBlock
        With the motion of the frame. A rotor without a coupling counts in its kinetic energy as one
        on the crank; of one on a coupling only the torque on the crank counts.
    motor : Motor
    twist : ndarray, shape (m,)
        Twist of the coupling in rad.
    speed : ndarray, shape (m,)
        Speed of the rotor at the crank, against the frame, in rad/s.
    torque : ndarray, shape (m,)
        Torque of the motor at the crank in N m.

    Returns
    -------
    StepBlock
    """
    assert block.frame is not None
    spin = block.frame.rate[:, 2]
    kinetic = block.kinetic_energy + motor.inertia * (motor.gear_ratio * speed + spin) ** 2 / 2
    if motor.coupling_stiffness is None:
        counted = motor.inertia_at_crank * (speed + spin) ** 2 / 2
        return replace(block, kinetic_energy=kinetic - counted)
    slip = speed - block.crank_speed
    power = torque * speed - block.driving_torque * block.crank_speed
    return replace(
        block,
        kinetic_energy=kinetic,
        strain_energy=block.strain_energy + motor.coupling_stiffness * twist**2 / 2,
        dissipation_power=block.dissipation_power + motor.coupling_damping * slip**2,
        prestress_power=block.prestress_power + power,
    )


@dataclass(frozen=True)
class DrivenShaft:
    """The free shaft of a driven linkage.

    Parameters
    ----------
    engine : Engine
    drive : Drive
    frames : LinkFrames
        Frames of the reduced links.
    fields : tuple of ndarray, shape (n_link, 3)
        Fields of each reduced link: unit displacements along and across, and unit rotation.
    link : int
        That it drives.
    rows : ndarray, shape (2, n_link)
        By its coordinates ``d`` of the shaft; in linear equations zero and phi.
    given : ShaftTorque, optional
        Torque of a motor, in place of the torque that drives the rigid linkage.
    """

    engine: Engine
    drive: Drive
    frames: LinkFrames
    fields: tuple[FloatArray, ...]
    link: int
    rows: FloatArray
    given: ShaftTorque | None = None

    @classmethod
    def of(
        cls,
        engine: Engine,
        drive: Drive,
        frames: LinkFrames,
        links: Sequence[RunLink],
        given: ShaftTorque | None = None,
    ) -> Self | None:
        """The shaft of an engine; None where it is prescribed.

        Parameters
        ----------
        engine : Engine
        drive : Drive
        frames : LinkFrames
        links : sequence of RunLink
        given : ShaftTorque, optional

        Returns
        -------
        DrivenShaft or None
        """
        if engine.free_shaft is None:
            return None
        fields = []
        for link in links:
            rigid_fields = link.model.fields
            rigid = np.stack(
                [rigid_fields.along, rigid_fields.across, rigid_fields.tangential], axis=1
            )
            # Static shapes of a straight link show how it moves as a rigid body.
            fields.append(np.asarray(np.linalg.lstsq(link.basis, rigid)[0]))
        number = engine.free_shaft.link
        driven = links[number]
        if driven.natural is None:
            rows = np.zeros((2, driven.reduced.size))
            rows[1, engine.free_shaft.rotation(driven.reduced)] = 1.0
        else:
            rows = driven.natural @ driven.basis
        return cls(engine, drive, frames, tuple(fields), number, rows, given)

    @property
    def is_natural(self) -> bool:
        """Whether its coordinates are natural ones, so that it may turn far."""
        return bool(self.rows[0].any())

    @property
    def has_motor(self) -> bool:
        """Whether its torque is a motor's."""
        return self.given is not None

    @property
    def coordinate(self) -> FloatArray:
        """Of the frames' coordinates (size,) that by which it turns: as a row of them."""
        row = np.zeros(self.frames.size)
        target = self.frames.targets[self.link]
        row[target[target >= 0]] = self.rows[1, target >= 0]
        return row

    def torque(
        self, time: FloatArray, motion: RigidMotion, force: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The torque (m,) of the motor; or that balances forces on the rigid linkage.

        And the torque where the coordinates are zero, of which the matrices make that.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        motion : RigidMotion
            Batch of shape (m,).
        force : ndarray, shape (m, size)
            On the coordinates of the frames, of all that acts, inertia included.
        """
        if self.given is not None:
            return self.given.on_shaft(time)
        torque = self.balance(motion, force)
        return torque, torque

    def balance(self, motion: RigidMotion, force: FloatArray) -> FloatArray:
        """The torque (m,) that balances forces (m, size) on the rigid linkage."""
        return np.asarray(-np.sum(self.turn(motion) * force, axis=1))

    def force(self, motion: RigidMotion, torque: FloatArray) -> FloatArray:
        """Force (m, size) of a torque (m,) on the coordinates of the frames."""
        loads = [np.zeros((len(torque), link.size)) for link in self.frames.links]
        loads[self.link] += torque[:, None] * self.rows[1]
        return self.frames.gather(motion, loads)

    def stiffness(self, torque: FloatArray) -> FloatArray:
        """Stiffness of a torque (m,) on the link that turns with it, (m, n_link, n_link)."""
        product = np.outer(self.rows[0], self.rows[1])
        return np.asarray(torque[:, None, None] * (product - product.T))

    def turn(self, motion: RigidMotion) -> FloatArray:
        """Coordinates of the frames as the rigid linkage turns by 1 rad of the shaft, (m, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        """
        fields = self._fields_of_turn(motion)[0]
        moved = [(c @ f.T)[..., None] for c, f in zip(fields, self.fields, strict=True)]
        return self.frames.independent(motion, moved)[..., 0]

    def carried(
        self, block: StepBlock, motion: RigidMotion, rotor: Sequence[FloatArray] = ()
    ) -> StepBlock:
        """Steps with the torque that the shaft is given, and its motion.

        Those of linear equations are carried into the frames of the rigid linkage at the angle
        that the shaft has, to first order; for others see :meth:`turned_back`.

        Parameters
        ----------
        block : StepBlock
            In the frames of the prescribed motion.
        motion : RigidMotion
            That, batch of shape (m,).
        rotor : sequence of ndarray, shape (m,)
            Coordinate and rate of a rotor on a coupling; empty without one.

        Returns
        -------
        StepBlock
        """
        shaft = self._motion(block.displacement[self.link], block.rate[self.link])
        shaft.refuse_runaway(self.drive, block.time)
        prescribed = block.crank_speed
        block = replace(
            block,
            crank_speed=prescribed + shaft.rate,
            driving_torque=self._given_torque(block, shaft, rotor),
            shaft=shaft,
        )
        if self.given is not None and block.frame is not None:
            torque, turned = block.driving_torque, (shaft.rotation, shaft.rate)
            if rotor:
                torque, turned = self.given.beside(block.time, *rotor), (rotor[0], rotor[1])
            twist, speed = turned[0] - shaft.rotation, prescribed + turned[1]
            block = with_rotor(block, self.given.motor, twist, speed, torque)
        if self.is_natural:
            return block
        displacement, rate = [], []
        turn, change = self._fields_of_turn(motion)
        phi, speed = shaft.rotation[:, None], shaft.rate[:, None]
        for number, shape in enumerate(self.fields):
            displacement.append(block.displacement[number] - phi * turn[number] @ shape.T)
            moving = speed * turn[number] + phi * change[number]
            rate.append(block.rate[number] - moving @ shape.T)
        return replace(block, displacement=displacement, rate=rate)

    def _given_torque(
        self, block: StepBlock, shaft: ShaftMotion, rotor: Sequence[FloatArray]
    ) -> FloatArray:
        """Torque on the shaft at the steps of a block, which a motor's is recorded for."""
        if self.given is None:
            return rigid_torque(self.engine.mechanism, self.drive, block.time)
        across = self.rows[1] @ block.displacement[self.link].T
        turning = self.rows[1] @ block.rate[self.link].T
        self.given.record(block.time, across, turning, shaft.rotation, shaft.rate, *rotor)
        if self.given.coupling is None:
            return self.given.beside(block.time, across, turning)
        twist = rotor[0] - shaft.rotation, rotor[1] - shaft.rate
        return self.given.motor.coupling_torque(*twist)

    def turned_back(self, run: Trajectory) -> Trajectory:
        """A run in the frames of the rigid linkage at the angle that the shaft has.

        Parameters
        ----------
        run : Trajectory
            Run of the engine's links; where the shaft may turn far in the frames of the prescribed
            motion, elsewhere in those frames already.

        Returns
        -------
        Trajectory
        """
        shaft = run.shaft
        if not self.is_natural or shaft is None:
            return run
        linkage, links = self.engine.mechanism.linkage, self.engine.links
        mean = self.drive.motion(linkage, run.time)
        turned = linkage.motion(mean.crank_angle + shaft.rotation, mean.crank_speed + shaft.rate)
        angle = turned.angle - mean.angle
        spin = turned.angular_velocity - mean.angular_velocity
        back = np.exp(-1j * turned.angle)
        shift = back * _complex(mean.origin - turned.origin)
        drift = back * _complex(mean.origin_velocity - turned.origin_velocity)
        drift -= 1j * turned.angular_velocity * shift
        places, rates = ([values.copy() for values in q] for q in (run.displacement, run.rate))
        for number, (link, q, rate) in enumerate(zip(links, places, rates, strict=True)):
            (x, y), field, along = link.vectors, link.fields.tangential, link.fields.along
            turn, faster = np.exp(-1j * angle[:, number, None]), spin[:, number, None]
            # Vectors of the straight link, of which those to nodes have an origin.
            straight, has_origin = field[y] - 1j * field[x], along[x]
            vector = straight + q[:, x] + 1j * q[:, y]
            moving = rate[:, x] + 1j * rate[:, y] - 1j * faster * vector
            section = np.setdiff1d(np.flatnonzero(field), np.concatenate([x, y]))
            sine = q[:, section]
            cosine = np.copysign(np.sqrt(np.abs(1.0 - sine**2)), turn.real)
            sections = (cosine + 1j * sine) * turn
            vector = vector * turn + shift[:, number, None] * has_origin - straight
            moving = moving * turn + drift[:, number, None] * has_origin
            q[:, x], q[:, y], rate[:, x], rate[:, y] = (
                vector.real,
                vector.imag,
                moving.real,
                moving.imag,
            )
            q[:, section] = sections.imag
            rate[:, section] = sections.real * (rate[:, section] / cosine - faster)
        return replace(run, displacement=places, rate=rates)

    def _motion(self, place: FloatArray, rate: FloatArray) -> ShaftMotion:
        """The shaft's, by the coordinates (m, n_link) of the link that it drives."""
        (along, across), (receding, turning) = self.rows @ place.T, self.rows @ rate.T
        if not self.is_natural:
            return ShaftMotion(across, turning)
        rotation = np.arctan2(across, 1.0 + along)
        return ShaftMotion(rotation, (1.0 + along) * turning - across * receding)

    def _fields_of_turn(self, motion: RigidMotion) -> tuple[list[FloatArray], list[FloatArray]]:
        """Rigid displacement of each link as the shaft turns by 1 rad, and its rate; (m, 3)."""
        linkage = self.engine.mechanism.linkage
        unit = linkage.motion(motion.crank_angle, 1.0)
        speed, nothing = motion.crank_speed[:, None], np.zeros_like(motion.crank_speed)
        turn, change = [], []
        for link in range(len(self.fields)):
            angle, spin = unit.angle[:, link], unit.angular_velocity[:, link]
            moved = field_coefficients(angle, unit.origin_velocity[:, link], spin, nothing)[:, :3]
            faster, spinning = unit.origin_acceleration, unit.angular_acceleration[:, link]
            rates = field_coefficients(angle, faster[:, link], spinning, nothing)[:, :3]
            rates += np.stack([spin * moved[:, 1], -spin * moved[:, 0], nothing], axis=1)
            turn.append(moved)
            change.append(speed * rates)
        return turn, change


def _complex(vector: FloatArray) -> NDArray[np.complex128]:
    """Vectors (..., 2) of the plane as complex numbers."""
    return np.asarray(vector[..., 0] + 1j * vector[..., 1])
