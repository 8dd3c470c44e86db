"""Loads and springs on the links of a driven linkage.

Their forces are linear in the elastic displacement about the rigid motion, as the equations of
the links are: the energy of a spring is exact to second order
(:class:`flexmech.mechanics.Connectors`). Terms that are smooth in the crank angle are
interpolated between positions. Loads over a table of crank angles or of times have kinks: they
are evaluated at every step.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import RigidMotion, continuous_angles
from flexmech.linkages.applied_forces import forces_of_loads
from flexmech.linkages.motion import cross
from flexmech.mechanics import (
    AttachedPoint,
    Connectors,
    Engine,
    LinkFrames,
    PointForce,
    RotationTerms,
    SystemMatrices,
    deformations,
)

LinkMotion = Sequence[tuple[FloatArray, FloatArray, FloatArray]]
"""Displacement of each link in its frame and its two time derivatives, (m, n_link) each."""


@dataclass(frozen=True)
class ConnectorWork:
    """Energy of springs in J, dissipated power and power of loads in W; each (m,)."""

    stored: FloatArray
    dissipation: FloatArray
    power: FloatArray

    @classmethod
    def of(
        cls, springs: Iterable[tuple[float, FloatArray, float, FloatArray]], power: FloatArray
    ) -> Self:
        """Work of springs and loads at m instants.

        Parameters
        ----------
        springs : iterable of (float, ndarray, float, ndarray)
            Stiffness, deformation (m,), damping and rate of the deformation (m,) of each.
        power : ndarray, shape (m,)
            That loads give.

        Returns
        -------
        ConnectorWork
        """
        stored, dissipation = np.zeros((2, len(power)))
        for stiffness, deformation, damping, rate in springs:
            stored += stiffness * deformation**2 / 2
            dissipation += damping * rate**2
        return cls(stored, dissipation, power)


class DrivenConnectors:
    """Loads and springs of a driven linkage.

    Parameters
    ----------
    engine : Engine
    frames : LinkFrames
        Frames of the reduced links.
    follower_torque : bool
        Whether the torque that balances them turns with a free shaft.
    """

    def __init__(
        self, engine: Engine, frames: LinkFrames, *, follower_torque: bool = False
    ) -> None:
        mechanism = engine.mechanism
        self._mechanism, self._frames = mechanism, frames
        self._all = Connectors(mechanism, frames.links)
        constant = tuple(load for load in mechanism.loads if load.over == "constant")
        tables = tuple(load for load in mechanism.loads if load.over != "constant")
        self.winds = _winds(engine)
        # A load or torque that varies and turns against what it acts on changes the stiffness; a
        # spring that is wound up is not periodic: neither is interpolated.
        follower_torque |= mechanism.frame is not None
        turns = any(load.axes == "link" or follower_torque for load in tables)
        self.is_interpolated = not (self.winds or turns)
        self._parts: tuple[Connectors | None, ...] = (self._all, None)
        if tables and self.is_interpolated:
            alone = replace(mechanism, loads=tables, springs=(), joint_springs=())
            smooth = replace(mechanism, loads=constant)
            self._parts = tuple(Connectors(acting, frames.links) for acting in (smooth, alone))

    @property
    def has_tables(self) -> bool:
        """Whether loads over tables are left to every step, while all else is interpolated."""
        return self._parts[1] is not None

    @property
    def any(self) -> bool:
        """Whether there is a load or a spring."""
        mechanism = self._mechanism
        return bool(mechanism.loads or mechanism.springs or mechanism.joint_springs)

    def require_periodic(self) -> None:
        """Refuse loads and springs that are not periodic with the turn.

        Raises
        ------
        InputError
            If loads over time act, or the spring of a joint is wound up turn by turn.
        """
        if any(load.over == "time" for load in self._mechanism.loads):
            raise InputError(
                "under a load over time no motion repeats itself every turn; choose start "
                "equilibrium or rigid, or give the load over the crank angle"
            )
        if self.winds:
            raise InputError(
                "the torsional spring of a joint is wound up further with every turn, so that no "
                "motion repeats itself; choose start equilibrium or rigid"
            )

    def added(
        self, motion: RigidMotion, matrices: SystemMatrices, terms: RotationTerms, time: FloatArray
    ) -> SystemMatrices:
        """Matrices of the linkage with those of the connectors added.

        Parameters
        ----------
        motion : RigidMotion
            At times of shape (m,).
        matrices : SystemMatrices
        terms : RotationTerms
        time : ndarray, shape (m,)

        Returns
        -------
        SystemMatrices
        """
        # Forces of a run have their true directions, whatever the prestress of the links.
        return self._all.added(self._frames, motion, matrices, terms, "equilibrium", None, time)

    def force(
        self, motion: RigidMotion, time: FloatArray, *, smooth: bool = True, tables: bool = True
    ) -> FloatArray:
        """Generalized force on the coordinates of the frames at zero displacement.

        Parameters
        ----------
        motion : RigidMotion
            At times of shape (m,).
        time : ndarray, shape (m,)
        smooth, tables : bool
            Whether what is interpolated counts, and loads over tables that are not.

        Returns
        -------
        ndarray, shape (m, size)
        """
        total = np.zeros((len(time), self._frames.size))
        for counts, connectors in zip((smooth, tables), self._parts, strict=True):
            if counts and connectors is not None:
                total += self._frames.gather(motion, connectors.forces(motion, None, time))
        return total

    def acting(
        self,
        time: FloatArray,
        motion: RigidMotion,
        elastic: LinkMotion,
        unit_motion: RigidMotion,
        place: FloatArray,
        carried: RigidMotion | None = None,
    ) -> tuple[list[FloatArray], list[FloatArray], FloatArray, ConnectorWork]:
        """Generalized forces, virtual power and work on the moving linkage.

        Parameters
        ----------
        time : ndarray, shape (m,)
        motion : RigidMotion
            At these times.
        elastic : sequence of tuple of ndarray, shape (m, n_link)
            Displacement and its rates in the frame of each reduced link.
        unit_motion : RigidMotion
            At unit crank speed.
        place : ndarray, shape (m, size)
            Coordinates of the frames, which rest there as the linkage turns at unit crank speed.
        carried : RigidMotion, optional
            The motion in ground axes, where ``motion`` is in those of a frame on springs.

        Returns
        -------
        list of ndarray, shape (m, n_link)
            On the coordinates of each link, without radial forces of sprung joints.
        list of ndarray, shape (m, 4)
            On the rigid fields of each link, likewise; moments with the arms of the displaced link.
        ndarray, shape (m,)
            Virtual power of all of them as the linkage turns at unit crank speed, displaced as it
            is.
        ConnectorWork
        """
        on_ground = motion if carried is None else carried
        links = self._frames.links
        shapes = [np.zeros((len(time), link.size)) for link in links]
        fields = [np.zeros((len(time), 4)) for _ in links]
        virtual, power = np.zeros((2, len(time)))
        if not self.any:
            return shapes, fields, virtual, ConnectorWork.of((), power)
        rest = np.zeros_like(place)
        unit_elastic = self._frames.link_motion(unit_motion, place, rest, rest)
        turn = on_ground.angle[:, 0] - motion.angle[:, 0]
        for push, in_joint in self._point_forces(time, motion, elastic, turn):
            point, number = push.point, push.point.link
            virtual += _power(push, unit_motion, unit_elastic)
            if in_joint:
                continue
            shapes[number] += point.force(motion, push.force, push.torque)
            fields[number] += _on_fields(push, motion, elastic[number][0])
        for push in self._loads(time, on_ground, elastic):
            power += _power(push, on_ground, elastic)
        displacement, rate, _ = zip(*elastic, strict=True)
        displaced = self._all.moved(motion, displacement, rate, finite=False)
        work = ConnectorWork.of(deformations(self._mechanism, motion, displaced), power)
        return shapes, fields, virtual, work

    def _point_forces(
        self, time: FloatArray, motion: RigidMotion, elastic: LinkMotion, turn: FloatArray
    ) -> list[tuple[PointForce, bool]]:
        """Forces one by one, and whether each is the radial force of a sprung joint.

        In axes that have turned with a frame; see :meth:`Connectors.point_forces`.
        """
        straight = self._all.point_forces(motion, None, time, turn=turn)
        forces = [(push, False) for push in straight]
        for tangent in self._all.tangents(motion, None, time):
            ends = ((tangent.second, 1.0), (tangent.first, -1.0))
            deformation, opening = np.zeros((2, len(time), 3, 1))
            for point, sign in ends:
                if point is not None:
                    q, rate, _ = elastic[point.link]
                    deformation += sign * point.displacement(motion, q)[..., None]
                    opening += sign * point.displacement_rate(motion, q, rate)[..., None]
            back = (tangent.stiffness @ deformation + tangent.damping @ opening)[..., 0]
            for point, sign in ends:
                if point is not None:
                    force, torque = -sign * back[:, :2], -sign * back[:, 2]
                    forces.append(
                        (PointForce(point, force, np.zeros_like(torque)), tangent.in_joint)
                    )
                    forces.append((PointForce(point, np.zeros_like(force), torque), False))
        return forces

    def _loads(
        self, time: FloatArray, motion: RigidMotion, elastic: LinkMotion
    ) -> Iterator[PointForce]:
        """Force of each load, a follower's to first order in the rotation of its section."""
        loads, topology = self._mechanism.loads, self._frames.topology
        straight = forces_of_loads(topology, motion, loads, time)
        for load, push in zip(loads, straight, strict=True):
            point, force = self._all.at(push.link, float(push.x)), push.force
            if load.axes == "link":
                rotation = (elastic[push.link][0] @ point.rows[2])[:, None]
                force = force + rotation * np.stack([-force[:, 1], force[:, 0]], axis=1)
            yield PointForce(point, force, push.torque)


def _power(push: PointForce, motion: RigidMotion, elastic: LinkMotion) -> FloatArray:
    """Power of a force on the displaced, moving link, (m,)."""
    point = push.point
    q, rate, _ = elastic[point.link]
    velocity = point.displacement_rate(motion, q, rate)
    velocity[:, :2] += motion.velocity(point.link, point.x)
    velocity[:, 2] += motion.angular_velocity[:, point.link]
    return np.asarray(np.sum(push.force * velocity[:, :2], axis=1) + push.torque * velocity[:, 2])


def _on_fields(push: PointForce, motion: RigidMotion, displacement: FloatArray) -> FloatArray:
    """Generalized force on the rigid fields of its link: two translations, rotation, extension."""
    place = push.point
    unit = AttachedPoint(place.link, place.x, np.eye(3), np.eye(3))
    along, across, torque = unit.force(motion, push.force, push.torque).T
    torque = torque + cross(place.displacement(motion, displacement)[:, :2], push.force)
    return np.stack([along, across, place.x * across + torque, place.x * along], axis=1)


def _winds(engine: Engine) -> bool:
    """Whether a turn of the crank winds up the torsional spring of a joint."""
    mechanism = engine.mechanism
    stiff = [spring for spring in mechanism.joint_springs if spring.torsional_stiffness]
    if not stiff:
        return False
    linkage, topology = mechanism.linkage, mechanism.linkage.topology
    angles = continuous_angles(linkage, linkage.motion(np.array([0.0, 2 * np.pi])))
    gained = angles[1] - angles[0]
    return any(abs(topology.joint_angle(spring.joint, gained)) > 1.0 for spring in stiff)
