"""Internal forces of displaced links, at a quasi-static equilibrium and in a run.

At an equilibrium all forces are dead ones: inertia forces of the rigid motion, weight, loads and
springs, at the displaced places of the matter that they act on. In a run the inertia forces of the
motion in the links' frames come to them, by d'Alembert's principle (Shabana, *Dynamics of Multibody
Systems*, 5th ed., ch. 5). The joint forces balance the displaced links, and those between two parts
of a link balance either part. So internal forces need an engine's displacements alone, not its
stresses, and both engines are treated alike. With N along and V across the link's frame they obey
``dM/dx = N v' - V (1 + u')``, the equation of a rod at finite displacements (u, v); Antman,
*Nonlinear Problems of Elasticity*, 2nd ed. 2005, ch. 4.

Forces and places in a link's frame are complex numbers: along it, and across it times i.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.linkages import LinkBody, RigidMotion
from flexmech.linkages.inverse_dynamics import (
    connection_matrix,
    connections,
    guide_place,
    solve_connections,
)
from flexmech.mechanics.engine import Engine
from flexmech.mechanics.links.body_forces import turns_as_one_body
from flexmech.mechanics.links.link_model import LinkModel
from flexmech.mechanics.links.link_readings import LinkReadings
from flexmech.mechanics.loads.connectors import PointForce
from flexmech.mechanism import Mechanism

# Gauss points in each part of a link: forces along it are linear in the place, and their arms
# cubic, or of fifth order times a slope where mass lies off the axis.
POINTS = 4


@dataclass(frozen=True)
class ForcesAlong:
    """Forces on a link, in its frame, at places along it.

    Parameters
    ----------
    place : ndarray, shape (j,) or (B, j)
        From the link's start in m.
    force : ndarray of complex, shape (B, j)
        Along and across the link's frame, N.
    moment : ndarray, shape (B, j)
        About the start of the undisplaced link, N m.
    """

    place: FloatArray
    force: ComplexArray
    moment: FloatArray

    def before(self, place: FloatArray) -> ComplexArray:
        """Sums of forces and of moments (B, k, 2) before cuts at places (k,)."""
        both = np.stack([self.force, self.moment], axis=-1)
        passed = (self.place[..., None, :] < place[:, None]).astype(float)
        return np.asarray(passed @ both)


@dataclass(frozen=True)
class DisplacedLinks:
    """Links of a mechanism at a quasi-static equilibrium or in a run.

    Parameters
    ----------
    mechanism : Mechanism
    links : tuple of LinkModel
        Unreduced.
    motion : RigidMotion
        Motion of the rigid linkage, for a batch of shape (B,).
    displacement : list of ndarray, shape (B, n_link)
    acting : tuple of PointForce
        Loads and springs at these displacements.
    rate, acceleration : list of ndarray, shape (B, n_link), optional
        Rates and accelerations of the links' coordinates, in their frames; left out at an
        equilibrium.
    """

    mechanism: Mechanism
    links: tuple[LinkModel, ...]
    motion: RigidMotion
    displacement: list[FloatArray]
    acting: tuple[PointForce, ...]
    rate: list[FloatArray] | None = None
    acceleration: list[FloatArray] | None = None

    @classmethod
    def at_equilibrium(cls, engine: Engine, motion: RigidMotion) -> DisplacedLinks:
        """Links of an engine at its quasi-static equilibrium.

        Parameters
        ----------
        engine : Engine
            With a prescribed shaft.
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        DisplacedLinks

        Raises
        ------
        InputError
            If the shaft is free, or a load goes over time.
        ComputationError
            If the equilibrium does not converge or is unstable; names the crank angle.
        """
        engine.require_prescribed_shaft("a quasi-static equilibrium")
        for load in engine.mechanism.loads:
            if load.over == "time":
                raise InputError(
                    f"load {load.name}: it goes over time, and a quasi-static equilibrium of "
                    "elastic links has none; leave it out, or let it go over the crank angle"
                )
        moved = engine.stressed_links(motion, "equilibrium").displacement
        if moved is None:
            batch = len(motion.crank_angle)
            moved = [np.zeros((batch, link.size)) for link in engine.links]
        acting = engine.connectors.point_forces(motion, moved) if engine.connectors.any else ()
        return cls(engine.mechanism, engine.links, motion, moved, tuple(acting))

    @classmethod
    def of_run(
        cls,
        engine: Engine,
        motion: RigidMotion,
        time: FloatArray,
        displacement: list[FloatArray],
        rate: list[FloatArray],
        acceleration: list[FloatArray],
        drawn: RigidMotion | None = None,
        turn: FloatArray | None = None,
    ) -> DisplacedLinks:
        """Links of an engine along a run.

        Parameters
        ----------
        engine : Engine
        motion : RigidMotion
            Motion of the rigid linkage at B samples, with what a free shaft has turned.
        time : ndarray, shape (B,)
            In s.
        displacement, rate, acceleration : list of ndarray, shape (B, n_link)
            Displacements of the links in their frames, in m and rad, and their time derivatives.
        drawn : RigidMotion, optional
            By whose velocities springs pull: that on a frame that stands, where ``motion`` has the
            accelerations on one that moves; the same by default.
        turn : ndarray, shape (B,), optional
            By which the axes of ``motion`` have turned against those of loads, in rad.

        Returns
        -------
        DisplacedLinks
        """
        connectors, at = engine.connectors, motion if drawn is None else drawn
        acting: tuple[PointForce, ...] = ()
        if connectors.any:
            acting = tuple(connectors.point_forces(at, displacement, time, turn=turn))
        links = engine.mechanism, engine.links, motion, displacement, acting
        return cls(*links, rate, acceleration)

    def section_forces(self, link: int, place: FloatArray) -> FloatArray:
        """Internal forces at cuts of a link.

        Parameters
        ----------
        link : int
        place : ndarray, shape (k,)
            From the link's start in m, ascending, off its ends. What acts exactly there counts to
            the far side of the cut.

        Returns
        -------
        ndarray, shape (B, k, 3)
            Axial force along the turned axis in N, bending moment in N m that curves the link
            towards the y axis of its frame, and shear force in N across the turned axis, which the
            part beyond the cut exerts on the part before it.
        """
        place = np.asarray(place, dtype=float)
        passed = np.asarray(
            sum(one.before(place) for one in (*self._dead(link, place), *self._joint_forces[link]))
        )
        force, moment = passed[..., 0], passed[..., 1].real
        at, turned = self._displaced(link, place)
        beyond = -force * np.exp(-1j * turned)
        return np.stack([beyond.real, moment_of(at, force) - moment, beyond.imag], axis=-1)

    def axial_force(self, link: int, x: FloatArray) -> FloatArray:
        """Tension along the turned axis (B, k) at places (k,); see :meth:`section_forces`."""
        return self.section_forces(link, x)[..., 0]

    def shear_force(self, link: int, x: FloatArray) -> FloatArray:
        """Shear force across the turned axis (B, k) at places (k,); see :meth:`section_forces`."""
        return self.section_forces(link, x)[..., 2]

    def _displaced(self, link: int, place: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Places on the axis where those at (k,) are displaced to, and rotation there, (B, k)."""
        return displaced_axis(self.links[link], self.displacement[link], place)

    def _in_frame(self, link: int, vectors: FloatArray) -> ComplexArray:
        """Vectors (B, 2) in ground axes, in the link's frame; (B, 1)."""
        turn = np.exp(-1j * self.motion.angle[:, link])
        return np.asarray((vectors[:, 0] + 1j * vectors[:, 1]) * turn)[:, None]

    def _dead(self, link: int, cuts: FloatArray) -> Iterator[ForcesAlong]:
        """All that acts on a link but its joint forces, in parts that end at cuts."""
        mass = self.mechanism.link_masses_in_order[link]
        points = zip(mass.point_positions, mass.point_masses, strict=True)
        lumps = [*(LinkBody(x, lump) for x, lump in points), *mass.bodies]
        if mass.mass_per_length:
            ends = np.concatenate([self.links[link].readings.nodes, cuts, [0.0, mass.length]])
            ends = np.unique(np.clip(ends, 0.0, mass.length))
            gauss, weight = np.polynomial.legendre.leggauss(POINTS)
            half = np.diff(ends)[:, None] / 2
            x = (ends[:-1, None] + half * (1 + gauss)).ravel()
            spans = (half * weight).ravel()
            rotary = mass.rotary_inertia * spans
            vibrates = not self.links[link].uncounted_rotary_inertia
            arm = 1j * mass.offset
            yield self._inertia(link, x, mass.mass_per_length * spans, arm, rotary, vibrates)
        for body in lumps:
            one = np.array([body.position]), np.array([body.mass])
            yield self._inertia(link, *one, complex(*body.offset), body.inertia)
        for push in self.acting:
            if push.point.link == link:
                place, force = np.array([push.point.x]), self._in_frame(link, push.force)
                at = self._displaced(link, place)[0]
                yield ForcesAlong(place, force, moment_of(at, force) + push.torque[:, None])

    def _inertia(
        self,
        link: int,
        place: FloatArray,
        mass: FloatArray,
        arm: complex,
        inertia: FloatArray | float = 0.0,
        vibrates: bool = True,
    ) -> ForcesAlong:
        """Inertia forces and weight of masses (j,) on an arm fixed to places (j,) of a link.

        ``inertia`` (j,) is that about their own centres; ``vibrates`` says whether the rotation of
        sections in the link's frame has it too, besides that of the frame.
        """
        motion = self.motion
        turning, change = (
            rate[:, link, None] for rate in (motion.angular_velocity, motion.angular_acceleration)
        )
        pull = motion.origin_acceleration[:, link] - np.asarray(self.mechanism.gravity)
        axis, turned = self._displaced(link, place)
        lever = arm * np.exp(1j * turned)
        at = carried = axis + lever
        felt, gained = self._in_frame(link, pull), change
        if self.rate is not None and self.acceleration is not None:
            rows = _rows_at(self.links[link], place)
            speed, spin = _read(rows, self.rate[link])
            gain, spin_gain = _read(rows, self.acceleration[link])
            felt = felt + gain + (1j * spin_gain - spin**2) * lever
            felt = felt + 2j * turning * (speed + 1j * spin * lever)
            gained = change + spin_gain if vibrates else change
        # Links that rotate as one body are at rest in the frame where they are displaced to; the
        # equilibrium of others is that under the inertia forces of the rigid motion.
        elif not turns_as_one_body(self.mechanism.linkage.topology):
            carried = np.asarray(place + arm)
        force = -mass * (felt + (1j * change - turning**2) * carried)
        return ForcesAlong(place, force, moment_of(at, force) - inertia * gained)

    @cached_property
    def _by_connections(self) -> FloatArray:
        """Force in ground axes and moment of each connection on each link, (B, n_links, 3, c).

        Moments are about the starts of the undisplaced links. All links are in balance, displaced
        as they are.
        """
        topology, motion = self.mechanism.linkage.topology, self.motion
        outside = np.zeros((*motion.angle.shape, 3))
        ends = np.zeros((*motion.angle.shape, 2), dtype=complex)
        for number, body in enumerate(topology.links):
            turn, beyond = np.exp(1j * motion.angle[:, number]), np.array([2 * body.length])
            total = sum(one.before(beyond)[:, 0] for one in self._dead(number, np.zeros(0)))
            force, moment = np.moveaxis(np.broadcast_to(total, (len(turn), 2)), -1, 0)
            force = force * turn
            outside[:, number] = np.stack([force.real, force.imag, moment.real], axis=-1)
            drawn = np.array([0.0, body.length])
            ends[:, number] = (self._displaced(number, drawn)[0] - drawn) * turn[:, None]
        matrix = connection_matrix(topology, motion, ends)
        load = outside.reshape(len(outside), -1)
        columns = matrix * solve_connections(topology, motion, load, matrix)[:, None]
        return np.asarray(columns.reshape(*outside.shape, -1))

    @cached_property
    def joint_force(self) -> dict[str, FloatArray]:
        """Force on the grounded or following link at each joint, ground axes, N, (B, 2).

        A slider's is across its line.
        """
        topology = self.mechanism.linkage.topology
        batch = len(self.motion.crank_angle)
        forces = {name: np.zeros((batch, 2)) for name in topology.joint_names}
        for number, one in enumerate(connections(topology)):
            at_connection = self._by_connections[:, topology.index(one.place.link), :2, number]
            forces[one.joint] = forces[one.joint] + at_connection
        return forces

    @cached_property
    def _joint_forces(self) -> list[list[ForcesAlong]]:
        """Joint forces of each link."""
        topology, motion = self.mechanism.linkage.topology, self.motion
        forces: list[list[ForcesAlong]] = [[] for _ in topology.links]
        for number, one in enumerate(connections(topology)):
            ends = [topology.end_place(end) for end in (one.place, one.other) if end is not None]
            places = [(link, np.array([x])) for link, x in ends]
            if one.slider is not None and one.slider.guide:
                along, _ = guide_place(topology, motion, one.slider)
                places.append((topology.index(one.slider.guide), along[:, None]))
            for link, place in places:
                on_link = self._by_connections[:, link, :, number]
                force = self._in_frame(link, on_link[:, :2])
                forces[link].append(ForcesAlong(place, force, on_link[:, 2:]))
        return forces


def displaced_axis(
    link: LinkModel, displacement: FloatArray, place: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Where places of a link's axis are displaced to, and how far the section there turns.

    Parameters
    ----------
    link : LinkModel
        Unreduced.
    displacement : ndarray, shape (B, n_link)
        Displacement of the link, at finite rotations.
    place : ndarray, shape (k,)
        From the link's start in m.

    Returns
    -------
    ndarray of complex, shape (B, k)
        In the frame of the link's rigid motion in m: along it, and across it times i.
    ndarray, shape (B, k)
        In rad.
    """
    q = displacement
    if link.rigid:
        turned = np.broadcast_to(q[:, 2, None], (len(q), len(place)))
        return place * np.exp(1j * turned) + q[:, [0]] + 1j * q[:, [1]], turned
    q, rows = link.readings.with_slope_vectors(q), _rows_at(link, place)
    moved, turned = _read(rows, q)
    if link.readings.slope in link.vectors[1]:
        # A slope vector has unit length but for the strain.
        return place + moved, np.arcsin(np.clip(turned, -1.0, 1.0))
    return _with_finite_chords(link.readings, place, rows, q)


def _rows_at(link: LinkModel, place: FloatArray) -> FloatArray:
    """Displacement and rotation (k, 3, n) at places (k,) by a link's coordinates."""
    fraction = place / link.readings.nodes[-1]
    turned = link.readings.rotations_at(fraction)[:, None]
    return np.concatenate([link.readings.displacement_at(fraction), turned], axis=1)


def _read(rows: FloatArray, q: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Displacement and rotation (B, k) by rows (k, 3, n) of coordinates (B, n)."""
    along, across, turned = np.einsum("kcn,bn->cbk", rows, q)
    return along + 1j * across, turned


def _with_finite_chords(
    readings: LinkReadings, place: FloatArray, rows: FloatArray, q: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Displaced places and rotation (B, k) inside elements whose chords turn by finite angles.

    An element's shapes are of small rotations; against its chord those of its nodes are small.
    """
    nodes, per_node = readings.nodes, readings.per_node
    at_nodes = np.einsum("kcn,bn->cbk", readings.displacement_at(nodes / nodes[-1]), q)
    drawn = nodes + at_nodes[0] + 1j * at_nodes[1]
    chord = np.diff(drawn, axis=1) / np.diff(nodes)
    angle = np.angle(chord)
    excess = angle - chord.imag
    # By equal rotations of the nodes of an element that do not move.
    equal = np.zeros(per_node * len(nodes))
    equal[readings.slope :: per_node] = 1.0
    _, deflected, turned = (rows @ equal).T
    moved, rotation = _read(rows, q)
    element = np.clip(np.searchsorted(nodes, place, side="right") - 1, 0, len(nodes) - 2)
    on_chord = drawn[:, element] + (place - nodes[element]) * chord[:, element]
    rotation = rotation + excess[:, element] * (1.0 - turned)
    if readings.deflection is None:
        # With shear deformation: between the rotations of the nodes.
        of_nodes = q[:, readings.slope :: per_node]
        share = (place - nodes[element]) / np.diff(nodes)[element]
        rotation = (1.0 - share) * of_nodes[:, element] + share * of_nodes[:, element + 1]
    across = moved.imag - on_chord.imag - excess[:, element] * deflected
    return on_chord + 1j * across * np.exp(1j * angle[:, element]), rotation


def moment_of(place: ComplexArray, force: ComplexArray) -> FloatArray:
    """Moments (...) about the origin of forces (...) at places (...)."""
    return np.asarray((np.conj(place) * force).imag)
