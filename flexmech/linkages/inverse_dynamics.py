"""Inverse dynamics of the rigid linkage: inertia forces, joint reactions, driving torque.

Kumar & Chandrakar, eqs. 1.43-1.44 (link inertia force and moment) and 1.64-1.65 (lumped
masses). All results are batched over the positions of a :class:`RigidMotion`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.linkages.applied_forces import ForceOnLink, applied_forces
from flexmech.linkages.attachments import JointSpring, Load, Spring
from flexmech.linkages.connection_forces import (
    connection_matrix,
    connection_vectors,
    connections,
    guide_place,
    solve_connections,
)
from flexmech.linkages.internal_forces import LinkForces
from flexmech.linkages.link_mass import LinkMass
from flexmech.linkages.motion import RigidMotion, cross, direction, normal
from flexmech.linkages.topology import Topology
from flexmech.model_text import shapes, short_repr


@dataclass(frozen=True)
class InverseDynamics(LinkForces):
    """Joint and internal forces of the rigid linkage in its motion.

    Parameters
    ----------
    motion : RigidMotion
    masses : tuple of LinkMass
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.
    start_force : ndarray, shape (..., n_links, 2)
        Sum of joint forces on the start of each link, ground axes, N.
    start_moment : ndarray, shape (..., n_links)
        Sum of joint couples on the start of each link, N m.
    applied : tuple of ForceOnLink
        Loads and forces of springs.
    on_guides : tuple of ForceOnLink
        Forces of sliders on their guides.
    inertia_force : ndarray, shape (..., n_links, 2)
        Resultant of inertia and weight on each link, ground axes, N.
    inertia_moment : ndarray, shape (..., n_links)
        Its moment about the link's start, N m.
    joint_force : dict of str to ndarray, shape (..., 2)
        Force on the grounded or following link at each joint, ground axes, N. A slider's is
        across its line.
    joint_moment : dict of str to ndarray, shape (...)
        Couple on the grounded or following link at each joint, N m: of clamps and welds, zero at
        the others. A torsional spring in a joint is not part of it.
    driving_torque : ndarray, shape (...)
        Torque of the shaft on the clamped link about the shaft's axis, N m. The inertia of
        the shaft itself is not in it.
    """

    inertia_force: FloatArray
    inertia_moment: FloatArray
    joint_force: dict[str, FloatArray]
    joint_moment: dict[str, FloatArray]
    driving_torque: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))

    @property
    def driving_power(self) -> FloatArray:
        """Power of the driving torque in W; shape (...)."""
        return np.asarray(self.driving_torque * self.motion.crank_speed)


def inverse_dynamics(
    topology: Topology,
    motion: RigidMotion,
    masses: Sequence[LinkMass],
    gravity: tuple[float, float] = (0.0, 0.0),
    *,
    loads: Sequence[Load] = (),
    springs: Sequence[Spring] = (),
    joint_springs: Sequence[JointSpring] = (),
    time: ArrayLike = 0.0,
    continuous_angles: FloatArray | None = None,
) -> InverseDynamics:
    """Solve the rigid linkage's equations of motion for its joint forces.

    Parameters
    ----------
    topology : Topology
        With as many constraint forces as unknown, once the shaft is fixed.
    motion : RigidMotion
        Positions at which to solve.
    masses : sequence of LinkMass
        One a link, in order.
    gravity : tuple of float
        Gravitational acceleration in ground axes, m/s^2.
    loads : sequence of Load
    springs : sequence of Spring
    joint_springs : sequence of JointSpring
    time : array_like, shape (...)
        Of each position in s, for loads over time.
    continuous_angles : ndarray, shape (..., n_links), optional
        Angles of the links counted on as the linkage turns, for springs in joints; those of
        ``motion`` if left out. :func:`continuous_angles` gives them.

    Returns
    -------
    InverseDynamics

    Raises
    ------
    InputError
        If the connections do not determine the forces, or a spring has no direction.
    """
    force, moment = _inertia_loads(motion, masses, gravity)
    angles = motion.angle if continuous_angles is None else continuous_angles
    applied = tuple(applied_forces(topology, motion, loads, springs, joint_springs, angles, time))
    rows = np.concatenate([force, moment[..., None]], axis=-1)
    _add_forces(rows, motion, applied)
    matrix = connection_matrix(topology, motion)
    unknown = solve_connections(topology, motion, rows.reshape(*rows.shape[:-2], -1), matrix)
    vectors = unknown[..., None] * connection_vectors(topology, matrix)
    return _collect(
        topology, motion, tuple(masses), gravity, force, moment, applied, unknown, vectors
    )


def _add_forces(rows: FloatArray, motion: RigidMotion, forces: Iterable[ForceOnLink]) -> None:
    for one in forces:
        rows[..., one.link, :2] += one.force
        rows[..., one.link, 2] += one.moment(motion)


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
    force = -(mass[..., None] * pull + first[..., None] * turning + beside[..., None] * quarter)
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
    applied: tuple[ForceOnLink, ...],
    unknown: FloatArray,
    vectors: FloatArray,
) -> InverseDynamics:
    batch = unknown.shape[:-1]
    joint_force = {name: np.zeros((*batch, 2)) for name in topology.joint_names}
    joint_moment = {name: np.zeros(batch) for name in topology.joint_names}
    is_couple = np.array([one.component == 2 for one in connections(topology)])
    couples = np.where(is_couple, unknown, 0.0)
    for number, one in enumerate(connections(topology)):
        joint_force[one.joint] += vectors[..., number, :]
        joint_moment[one.joint] += couples[..., number]
    start_force, start_moment, on_guides = _on_links(topology, motion, vectors, couples)
    return InverseDynamics(
        motion=motion,
        masses=masses,
        gravity=gravity,
        inertia_force=force,
        inertia_moment=moment,
        joint_force=joint_force,
        driving_torque=_driving_torque(topology, motion, joint_force, joint_moment),
        start_force=start_force,
        joint_moment=joint_moment,
        start_moment=start_moment,
        applied=applied,
        on_guides=on_guides,
    )


def _on_links(
    topology: Topology, motion: RigidMotion, vectors: FloatArray, couples: FloatArray
) -> tuple[FloatArray, FloatArray, tuple[ForceOnLink, ...]]:
    """Sums of forces (..., c, 2) and couples (..., c) of connections on the links.

    Returns
    -------
    start_force : ndarray, shape (..., n_links, 2)
    start_moment : ndarray, shape (..., n_links)
    on_guides : tuple of ForceOnLink
    """
    start_force = np.zeros((*couples.shape[:-1], len(topology.links), 2))
    start_moment = np.zeros(start_force.shape[:-1])
    on_guides = []
    for number, one in enumerate(connections(topology)):
        vector, couple = vectors[..., number, :], couples[..., number]
        if one.slider is not None and one.slider.guide:
            x, y = guide_place(topology, motion, one.slider)
            guide = topology.index(one.slider.guide)
            on_guides.append(ForceOnLink(guide, x, -vector, couple, y))
        for place, sign in ((one.place, 1.0), (one.other, -1.0)):
            if place is not None and place.end == "start":
                link = topology.index(place.link)
                start_force[..., link, :] += sign * vector
                start_moment[..., link] += sign * couple
    return start_force, start_moment, tuple(on_guides)


def forces_by_joints(
    topology: Topology,
    motion: RigidMotion,
    masses: Sequence[LinkMass],
    gravity: tuple[float, float],
    joint_force: FloatArray,
    applied: Iterable[ForceOnLink] = (),
) -> LinkForces:
    """Internal forces of links whose joint forces are known, as of a run of elastic links.

    Links move as rigid ones: what their elastic motion adds to the inertia along them is of the
    second order.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    masses : sequence of LinkMass
        One a link, in order.
    gravity : tuple of float
        In ground axes, m/s^2.
    joint_force : ndarray, shape (..., n_joints, 2)
        On the grounded or following link, ground axes, N; across its line at a slider.
    applied : iterable of ForceOnLink
        Loads and forces of springs.

    Returns
    -------
    LinkForces
        Couples at clamps and welds are not known: bending moments of the links that start there
        are not numbers.
    """
    joints = list(topology.joint_names)
    every = connections(topology)
    # A force along x, one along y, a couple, and a force that is across a line already.
    share = np.array([[[1, 0], [0, 1], [0, 0], [1, 1]][one.component] for one in every])
    vectors = joint_force[..., [joints.index(one.joint) for one in every], :] * share
    couples = np.where([one.component == 2 for one in every], np.nan, 0.0)
    start_force, start_moment, on_guides = _on_links(
        topology, motion, vectors, np.broadcast_to(couples, vectors.shape[:-1])
    )
    return LinkForces(
        motion, tuple(masses), gravity, start_force, start_moment, tuple(applied), on_guides
    )


def _driving_torque(
    topology: Topology,
    motion: RigidMotion,
    joint_force: dict[str, FloatArray],
    joint_moment: dict[str, FloatArray],
) -> FloatArray:
    """Torque of all clamps about the shaft's axis; that of a clamp on a hub has an arm."""
    torque = np.zeros(motion.crank_angle.shape)
    for clamp in topology.clamps:
        torque = torque + joint_moment[clamp.joint]
        if clamp.hub:
            arm = clamp.hub * direction(motion.angle[..., topology.index(clamp.link_end.link)])
            torque = torque + cross(arm, joint_force[clamp.joint])
    return torque
