"""Inverse dynamics of the rigid linkage: inertia forces, joint reactions, driving torque.

Kumar & Chandrakar, eqs. 1.43-1.44 (link inertia force and moment) and 1.64-1.65 (lumped
masses). All results are batched over the positions of a :class:`RigidMotion`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.motion import RigidMotion, direction, normal
from flexmech.linkages.topology import LinkEnd, Topology
from flexmech.short_repr import shapes, short_repr
from flexmech.types import FloatArray

__all__ = ["InverseDynamics", "LinkMass", "inverse_dynamics"]

# Of point masses, in lengths of their link.
LEAST_DISTANCE = 1 / 500


@dataclass(frozen=True)
class LinkMass:
    """Mass of one link: point masses on the line between its ends, and distributed mass.

    Parameters
    ----------
    length : float
        In m.
    mass_per_length : float
        Distributed mass in kg/m.
    point_positions, point_masses : tuple of float
        Point masses in kg and their distances from the link's start in m.
    offset : float
        Distance of the distributed mass from the line between the ends in m.
    """

    length: float
    mass_per_length: float
    point_positions: tuple[float, ...] = ()
    point_masses: tuple[float, ...] = ()
    offset: float = 0.0

    @classmethod
    def of_points(
        cls,
        length: float,
        mass_per_length: float,
        points: Sequence[tuple[float, float]],
        offset: float = 0.0,
    ) -> LinkMass:
        """Mass of a link with points far enough apart for a beam element between them.

        Points nearer to each other than 1/500 of the link's length become one at their centre of
        mass, and one nearer to an end is shared between the end and that distance as a lever
        would. Mass and first moment stay; the polar second moment changes by less than 1e-6 of
        the points' mass times the length squared. A shorter element would be more than 1e8 times
        as stiff as the link, and round-off of its stiffness would blur the lowest frequencies.

        Parameters
        ----------
        length, mass_per_length, offset : float
            As in :class:`LinkMass`.
        points : sequence of (float, float)
            Distance from the link's start in m and mass in kg, in any order.
        """
        least = LEAST_DISTANCE * length
        apart: list[tuple[float, float]] = []
        for position, mass in sorted(_away_from_ends(points, length, least)):
            where, total = position, mass
            inside = apart and apart[-1][0] > 0 and position < length
            if inside and position - apart[-1][0] < least:
                before, other = apart.pop()
                total = other + mass
                where = (before * other + position * mass) / total
            apart.append((where, total))
        positions, masses = zip(*apart, strict=True) if apart else ((), ())
        return cls(length, mass_per_length, positions, masses, offset)

    @property
    def moment_across(self) -> float:
        """Integral of the distance from the line between the ends over the mass in kg m."""
        return self.mass_per_length * self.length * self.offset

    def moment(self, order: int) -> float:
        """Integral of ``x**order`` over the mass: mass, first or polar second moment."""
        distributed = self.mass_per_length * self.length ** (order + 1) / (order + 1)
        if order == 2:
            distributed += self.moment_across * self.offset
        points = zip(self.point_positions, self.point_masses, strict=True)
        return distributed + sum(mass * x**order for x, mass in points)


def _away_from_ends(
    points: Sequence[tuple[float, float]], length: float, least: float
) -> Iterator[tuple[float, float]]:
    """Points, of which those near an end act at the end and at the least distance from it."""
    for position, mass in points:
        for end, inner in ((0.0, least), (length, length - least)):
            share = (position - end) / (inner - end)
            if 0 < share < 1:
                yield end, mass * (1 - share)
                yield inner, mass * share
                break
        else:
            yield position, mass


@dataclass(frozen=True)
class InverseDynamics:
    """Forces in the rigid linkage that its motion asks for.

    Parameters
    ----------
    motion : RigidMotion
    masses : tuple of LinkMass
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.
    inertia_force : ndarray, shape (..., n_links, 2)
        Resultant of inertia and weight on each link, ground axes, N.
    inertia_moment : ndarray, shape (..., n_links)
        Its moment about the link's start, N m.
    joint_force : dict of str to ndarray, shape (..., 2)
        Force on the held or following link at each joint, ground axes, N.
    driving_torque : ndarray, shape (...)
        Torque of the shaft on the clamped link about the shaft's axis, N m.
    start_force : ndarray, shape (..., n_links, 2)
        Sum of joint forces on the start of each link, ground axes, N.
    """

    motion: RigidMotion
    masses: tuple[LinkMass, ...]
    gravity: tuple[float, float]
    inertia_force: FloatArray
    inertia_moment: FloatArray
    joint_force: dict[str, FloatArray]
    driving_torque: FloatArray
    start_force: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))

    def axial_force(self, link: int, x: float | FloatArray) -> FloatArray:
        """Tension along a link in N.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            Distances from the link's start in m. A point mass exactly there counts to the far
            side of the cut.

        Returns
        -------
        ndarray, shape (...) or (..., k)
        """
        mass, place = self.masses[link], np.asarray(x, dtype=float)
        angle = self.motion.angle[..., link]
        along = direction(angle)
        pull = self.motion.origin_acceleration[..., link, :] - np.asarray(self.gravity)
        start = np.sum(pull * along, axis=-1)
        turning = self.motion.angular_velocity[..., link] ** 2
        at_start = np.sum(self.start_force[..., link, :] * along, axis=-1)
        change = self.motion.angular_acceleration[..., link]
        mass_before = mass.mass_per_length * place
        first_before = mass_before * place / 2
        beside = mass_before * mass.offset
        for position, point in zip(mass.point_positions, mass.point_masses, strict=True):
            passed = point * (position < place)
            mass_before, first_before = mass_before + passed, first_before + passed * position
        tension: FloatArray = (
            np.multiply.outer(start, mass_before)
            - np.multiply.outer(turning, first_before)
            - np.multiply.outer(change, beside)
            - at_start[(..., *[None] * place.ndim)]
        )
        return tension


def inverse_dynamics(
    topology: Topology,
    motion: RigidMotion,
    masses: Sequence[LinkMass],
    gravity: tuple[float, float] = (0.0, 0.0),
) -> InverseDynamics:
    """Solve the rigid linkage's equations of motion for its joint forces.

    Parameters
    ----------
    topology : Topology
        With as many connections as hold the linkage once the shaft is held.
    motion : RigidMotion
        Positions at which to solve.
    masses : sequence of LinkMass
        One a link, in order.
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.

    Returns
    -------
    InverseDynamics

    Raises
    ------
    InputError
        If the connections do not determine the forces.
    """
    force, moment = _inertia_loads(motion, masses, gravity)
    columns = _connection_columns(topology)
    n_links = len(topology.links)
    if len(columns) != 3 * n_links:
        raise InputError(
            f"{len(columns)} connection forces for {3 * n_links} equations of motion: the "
            "linkage is not held exactly once; check clamps, pivots and pins"
        )
    batch = motion.angle.shape[:-1]
    matrix = np.zeros((*batch, 3 * n_links, 3 * n_links))
    for number, column in enumerate(columns):
        for place, sign, component in column.acts:
            _add_unit_load(matrix[..., number], topology, motion, place, sign, component)
    rows = np.concatenate([force, moment[..., None]], axis=-1).reshape(*batch, 3 * n_links)
    unknown = -np.linalg.solve(matrix, rows[..., None])[..., 0]
    return _collect(topology, motion, tuple(masses), gravity, force, moment, columns, unknown)


@dataclass(frozen=True)
class _Column:
    """One unknown: component 0, 1 (force in ground axes) or 2 (torque) at a joint."""

    joint: str
    component: int
    acts: tuple[tuple[LinkEnd, float, int], ...]


def _connection_columns(topology: Topology) -> list[_Column]:
    columns = []
    for clamp in topology.clamps:
        columns += [_Column(clamp.joint, i, ((clamp.held, 1.0, i),)) for i in (0, 1, 2)]
    for pivot in topology.pivots:
        columns += [_Column(pivot.joint, i, ((pivot.held, 1.0, i),)) for i in (0, 1)]
    for pin in topology.pins:
        acts = [((pin.follower, 1.0, i), (pin.leader, -1.0, i)) for i in (0, 1)]
        columns += [_Column(pin.joint, i, acts[i]) for i in (0, 1)]
    return columns


def _add_unit_load(
    column: FloatArray,
    topology: Topology,
    motion: RigidMotion,
    place: LinkEnd,
    sign: float,
    component: int,
) -> None:
    """Add a unit force or torque at a link end to a column of the equations of motion."""
    link = topology.index(place.link)
    column[..., 3 * link + component] += sign
    if component < 2 and place.end == "end":
        arm = topology.links[link].length * direction(motion.angle[..., link])
        lever = -arm[..., 1] if component == 0 else arm[..., 0]
        column[..., 3 * link + 2] += sign * lever


def _inertia_loads(
    motion: RigidMotion, masses: Sequence[LinkMass], gravity: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Inertia force and moment about each link's start, weight included."""
    mass, first, second = (np.array([m.moment(order) for m in masses]) for order in (0, 1, 2))
    beside = np.array([m.moment_across for m in masses])
    pull = motion.origin_acceleration - np.asarray(gravity)
    along, across = direction(motion.angle), normal(motion.angle)
    turning = motion.angular_acceleration[..., None] * across
    turning = turning - motion.angular_velocity[..., None] ** 2 * along
    quarter = np.stack([-turning[..., 1], turning[..., 0]], axis=-1)
    force = -(mass[:, None] * pull + first[:, None] * turning + beside[:, None] * quarter)
    lever = first * np.sum(pull * across, axis=-1) - beside * np.sum(pull * along, axis=-1)
    moment = -(lever + second * motion.angular_acceleration)
    return force, moment


def _collect(
    topology: Topology,
    motion: RigidMotion,
    masses: tuple[LinkMass, ...],
    gravity: tuple[float, float],
    force: FloatArray,
    moment: FloatArray,
    columns: list[_Column],
    unknown: FloatArray,
) -> InverseDynamics:
    batch = unknown.shape[:-1]
    joint_force = {name: np.zeros((*batch, 2)) for name in topology.joint_names}
    start_force = np.zeros((*batch, len(topology.links), 2))
    torque = np.zeros(batch)
    for number, column in enumerate(columns):
        value = unknown[..., number]
        if column.component < 2:
            joint_force[column.joint][..., column.component] = value
            for place, sign, component in column.acts:
                if place.end == "start":
                    start_force[..., topology.index(place.link), component] += sign * value
        else:
            # The clamp's couple acts at the link's start; about the shaft's axis the clamp
            # force has a lever too when the link sits on a hub.
            link = topology.index(column.acts[0][0].link)
            lever = motion.origin[..., link, :]
            clamp = joint_force[column.joint]
            torque = value + lever[..., 0] * clamp[..., 1] - lever[..., 1] * clamp[..., 0]
    return InverseDynamics(
        motion=motion,
        masses=masses,
        gravity=gravity,
        inertia_force=force,
        inertia_moment=moment,
        joint_force=joint_force,
        driving_torque=torque,
        start_force=start_force,
    )
