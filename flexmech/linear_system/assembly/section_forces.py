"""Internal forces of displaced links at their quasi-static equilibrium.

All forces of that equilibrium are dead ones: inertia forces of the rigid motion, weight, loads and
springs, at the displaced places of the matter that they act on. The joint forces balance the
displaced links, and those between two parts of a link balance either part. So internal forces need
an engine's displacements alone, not its stresses, and both engines are treated alike. With N along
and V across the link's frame they obey ``dM/dx = N v' - V (1 + u')``, the equation of a rod at
finite displacements (u, v); Antman, *Nonlinear Problems of Elasticity*, 2nd ed. 2005, ch. 4.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linear_system.assembly.engine import Engine
from flexmech.linear_system.links.body_forces import turns_as_one_body
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.link_readings import LinkReadings
from flexmech.linear_system.loads.connector_forces import PointForce
from flexmech.linkages import LinkBody, RigidMotion
from flexmech.linkages.connection_forces import (
    connection_matrix,
    connections,
    guide_place,
    solve_connections,
)
from flexmech.linkages.motion import direction, normal
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
    force : ndarray, shape (B, j, 2)
        Along and across the link's frame, N.
    moment : ndarray, shape (B, j)
        About the start of the undisplaced link, N m.
    """

    place: FloatArray
    force: FloatArray
    moment: FloatArray

    def before(self, place: FloatArray) -> FloatArray:
        """Sums of forces and moments (B, k, 3) before cuts at places (k,)."""
        all_three = np.concatenate([self.force, self.moment[..., None]], axis=2)
        passed = (self.place[..., None, :] < place[:, None]).astype(float)
        return np.asarray(passed @ all_three)


@dataclass(frozen=True)
class DisplacedLinks:
    """Links of a mechanism at a quasi-static equilibrium.

    Parameters
    ----------
    mechanism : Mechanism
    links : tuple of LinkModel
        Unreduced.
    motion : RigidMotion
        Of the rigid linkage, for a batch of shape (B,).
    displacement : list of ndarray, shape (B, n_link)
    acting : tuple of PointForce
        Loads and springs at these displacements.
    """

    mechanism: Mechanism
    links: tuple[LinkModel, ...]
    motion: RigidMotion
    displacement: list[FloatArray]
    acting: tuple[PointForce, ...]

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
        engine.require_standing_frame("the strength of links")
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
        passed = sum(
            one.before(place) for one in (*self._dead(link, place), *self._joint_forces[link])
        )
        along, across, moment = np.moveaxis(np.asarray(passed), -1, 0)
        moved = self._moved(link, place)
        x, y = place + moved[..., 0], moved[..., 1]
        cosine, sine = np.cos(moved[..., 2]), np.sin(moved[..., 2])
        return np.stack(
            [
                -cosine * along - sine * across,
                x * across - y * along - moment,
                sine * along - cosine * across,
            ],
            axis=-1,
        )

    def axial_force(self, link: int, x: FloatArray) -> FloatArray:
        """Tension along the turned axis (B, k) at places (k,); see :meth:`section_forces`."""
        return self.section_forces(link, x)[..., 0]

    def bending_moment(self, link: int, x: FloatArray) -> FloatArray:
        """Bending moment (B, k) at places (k,); see :meth:`section_forces`."""
        return self.section_forces(link, x)[..., 1]

    def shear_force(self, link: int, x: FloatArray) -> FloatArray:
        """Shear force across the turned axis (B, k) at places (k,); see :meth:`section_forces`."""
        return self.section_forces(link, x)[..., 2]

    def _moved(self, link: int, place: FloatArray) -> FloatArray:
        """Displacement in the link's frame and rotation, (B, k, 3), at places (k,)."""
        model, q = self.links[link], self.displacement[link]
        if model.rigid:
            turn = q[:, 2, None]
            back, rise = np.cos(turn) - 1.0, np.sin(turn)
            shift = np.stack([back * place, rise * place], axis=-1) + q[:, None, :2]
            return np.concatenate([shift, np.broadcast_to(turn, shift.shape[:2])[..., None]], -1)
        readings = model.readings
        q = readings.with_slope_vectors(q)
        length = readings.nodes[-1]
        turned = readings.rotations_at(place / length)
        rows = np.concatenate([readings.displacement_at(place / length), turned[:, None]], axis=1)
        moved = np.asarray(np.einsum("kcn,bn->bkc", rows, q))
        if readings.slope in model.vectors[1]:
            # Of a slope vector, which is of unit length but for the strain.
            moved[..., 2] = np.arcsin(np.clip(moved[..., 2], -1.0, 1.0))
            return moved
        return _with_finite_chords(readings, place, rows, moved, q)

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
            each, arm = (half * weight).ravel(), np.array([0.0, mass.offset])
            rotary = mass.rotary_inertia * each
            vibrates = not self.links[link].uncounted_rotary_inertia
            yield self._inertia(link, x, mass.mass_per_length * each, arm, rotary, vibrates)
        for body in lumps:
            one = np.array([body.position]), np.array([body.mass])
            yield self._inertia(link, *one, np.array(body.offset), body.inertia)
        for push in self.acting:
            if push.point.link == link:
                angle = self.motion.angle[:, link]
                force = np.stack(
                    [np.sum(push.force * axis(angle), axis=-1) for axis in (direction, normal)], -1
                )
                at = self._arms(link, np.array([push.point.x]), np.zeros(2))
                moment = cross(at, force[:, None]) + push.torque[:, None]
                yield ForcesAlong(np.array([push.point.x]), force[:, None], moment)

    def _inertia(
        self,
        link: int,
        place: FloatArray,
        mass: FloatArray,
        arm: FloatArray,
        inertia: FloatArray | float = 0.0,
        vibrates: bool = True,
    ) -> ForcesAlong:
        """Inertia forces and weight of masses (j,) on arms (2,) fixed to places (j,) of a link.

        ``inertia`` (j,) is that about their own centres; ``vibrates`` says whether the rotation of
        sections in the link's frame has it too, besides that of the frame.
        """
        motion, angle = self.motion, self.motion.angle[:, link]
        x, y = place + arm[0], np.full_like(place, arm[1])
        pull = motion.origin_acceleration[:, link] - np.asarray(self.mechanism.gravity)
        along, across = (np.sum(pull * axis(angle), axis=-1) for axis in (direction, normal))
        squared = motion.angular_velocity[:, link, None] ** 2
        change = motion.angular_acceleration[:, link, None]
        at = self._arms(link, place, arm)
        if turns_as_one_body(self.mechanism.linkage.topology):
            # At rest in the frame, where it is displaced to.
            x, y = at[..., 0], at[..., 1]
        force = -mass[:, None] * np.stack(
            [along[:, None] - squared * x - change * y, across[:, None] - squared * y + change * x],
            axis=-1,
        )
        return ForcesAlong(place, force, cross(at, force) - inertia * change)

    def _arms(self, link: int, place: FloatArray, arm: FloatArray) -> FloatArray:
        """Displaced points (B, j, 2) on arms (2,) that turn with their sections at places (j,)."""
        moved = self._moved(link, place)
        cosine, sine = np.cos(moved[..., 2]), np.sin(moved[..., 2])
        x = place + moved[..., 0] + cosine * arm[0] - sine * arm[1]
        return np.stack([x, moved[..., 1] + sine * arm[0] + cosine * arm[1]], axis=-1)

    @cached_property
    def _by_connections(self) -> FloatArray:
        """Force in ground axes and moment of each connection on each link, (B, n_links, 3, c).

        Moments are about the starts of the undisplaced links. All links are in balance, displaced
        as they are.
        """
        topology, motion = self.mechanism.linkage.topology, self.motion
        angle = motion.angle
        outside = np.zeros((len(motion.crank_angle), len(self.links), 3))
        ends = np.zeros((*outside.shape[:2], 2), dtype=complex)
        for number, body in enumerate(topology.links):
            beyond = np.array([2 * body.length])
            outside[:, number] = sum(
                one.before(beyond)[:, 0] for one in self._dead(number, np.zeros(0))
            )
            moved = self._moved(number, np.array([0.0, body.length]))
            ends[:, number] = (moved[..., 0] + 1j * moved[..., 1]) * np.exp(1j * angle[:, [number]])
        outside[..., :2] = _turned(outside[..., :2], angle)
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
        found = {name: np.zeros((batch, 2)) for name in topology.joint_names}
        for number, one in enumerate(connections(topology)):
            own = self._by_connections[:, topology.index(one.place.link), :2, number]
            found[one.joint] = found[one.joint] + own
        return found

    @cached_property
    def _joint_forces(self) -> list[list[ForcesAlong]]:
        """Of each link."""
        topology, motion = self.mechanism.linkage.topology, self.motion
        found: list[list[ForcesAlong]] = [[] for _ in topology.links]
        for number, one in enumerate(connections(topology)):
            on_ends = [each for each in (one.place, one.other) if each is not None]
            places: list[tuple[int, FloatArray]] = []
            for end in on_ends:
                link, x = topology.end_place(end)
                places.append((link, np.array([x])))
            if one.slider is not None and one.slider.guide:
                along, _ = guide_place(topology, motion, one.slider)
                places.append((topology.index(one.slider.guide), along[:, None]))
            for link, place in places:
                own = self._by_connections[:, link, :, number]
                force = _turned(own[:, None, :2], -motion.angle[:, [link]])
                found[link].append(ForcesAlong(place, force, own[:, None, 2]))
        return found


def _with_finite_chords(
    readings: LinkReadings, place: FloatArray, rows: FloatArray, moved: FloatArray, q: FloatArray
) -> FloatArray:
    """Displacement and rotation (B, k, 3) inside elements whose chords turn by finite angles.

    An element's shapes are of small rotations; against its chord those of its nodes are small.
    """
    nodes, per_node = readings.nodes, readings.per_node
    at_nodes = np.einsum("kcn,bn->bkc", readings.displacement_at(nodes / nodes[-1]), q)
    chord = np.diff(at_nodes, axis=1) / np.diff(nodes)[:, None]
    angle = np.arctan2(chord[..., 1], 1.0 + chord[..., 0])
    excess = angle - chord[..., 1]
    # By equal rotations of the nodes of an element that do not move.
    equal = np.zeros(per_node * len(nodes))
    equal[readings.slope :: per_node] = 1.0
    _, deflected, turned = (rows @ equal).T
    element = np.clip(np.searchsorted(nodes, place, side="right") - 1, 0, len(nodes) - 2)
    on_chord = at_nodes[:, element] + (place - nodes[element])[:, None] * chord[:, element]
    rotation = moved[..., 2] + excess[:, element] * (1.0 - turned)
    if readings.deflection is None:
        # Of sections that shear: between those of the nodes.
        at_nodes = q @ np.eye(len(equal))[readings.slope :: per_node].T
        part = (place - nodes[element]) / np.diff(nodes)[element]
        rotation = (1.0 - part) * at_nodes[:, element] + part * at_nodes[:, element + 1]
    across = moved[..., 1] - on_chord[..., 1] - excess[:, element] * deflected
    return np.stack(
        [
            on_chord[..., 0] - across * np.sin(angle[:, element]),
            on_chord[..., 1] + across * np.cos(angle[:, element]),
            rotation,
        ],
        axis=-1,
    )


def cross(arm: FloatArray, force: FloatArray) -> FloatArray:
    """Moments (...) of forces (..., 2) on arms (..., 2)."""
    return np.asarray(arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0])


def _turned(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by angles (...)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
