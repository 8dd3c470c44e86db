"""Inverse dynamics of the rigid linkage: joint forces, driving torque, forces inside the links.

Kumar & Chandrakar, eqs. 1.43-1.44 (link inertia force and moment) and 1.64-1.65 (lumped
masses). All results are batched over the positions of a :class:`RigidMotion`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages.applied_forces import ForceOnLink, JointSpring, Load, Spring, applied_forces
from flexmech.linkages.connection_forces import (
    connection_matrix,
    connection_vectors,
    connections,
    guide_place,
    solve_connections,
)
from flexmech.linkages.link_mass import LinkMass, MassMoments
from flexmech.linkages.motion import RigidMotion, cross, direction
from flexmech.linkages.topology import Topology
from flexmech.model_text import shapes, short_repr

AnyArray = NDArray[Any]


@dataclass(frozen=True)
class LinkForces:
    """Forces on the links of a moving linkage, and internal forces at cuts.

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
    """

    motion: RigidMotion
    masses: tuple[LinkMass, ...]
    gravity: tuple[float, float]
    start_force: FloatArray
    start_moment: FloatArray
    applied: tuple[ForceOnLink, ...]
    on_guides: tuple[ForceOnLink, ...]

    def axial_force(self, link: int, x: float | FloatArray) -> FloatArray:
        """Tension along a link in N.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            Distances from the link's start in m. A point mass, body or load exactly there
            counts to the far side of the cut.

        Returns
        -------
        ndarray, shape (...) or (..., k)
        """
        return np.asarray(self._beyond(link, x)[0].real)

    def shear_force(self, link: int, x: float | FloatArray) -> FloatArray:
        """Force across a link in N that the part beyond a cut exerts on the part before it.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            As in :meth:`axial_force`.

        Returns
        -------
        ndarray, shape (...) or (..., k)
            Positive along the y axis of the link's frame. Where the mass lies on the axis and
            the link turns at constant speed, it is the slope of :meth:`bending_moment` with the
            other sign; an angular acceleration adds to that slope by the rotary inertia of the
            sections.
        """
        return np.asarray(self._beyond(link, x)[0].imag)

    def bending_moment(self, link: int, x: float | FloatArray) -> FloatArray:
        """Moment in N m that the part beyond a cut exerts on the part before it.

        Parameters
        ----------
        link : int
        x : float or ndarray, shape (k,)
            As in :meth:`axial_force`.

        Returns
        -------
        ndarray, shape (...) or (..., k)
            Positive where it curves the link towards the y axis of its frame.
        """
        force, moment = self._beyond(link, x)
        return np.asarray(moment - np.asarray(x) * force.imag)

    def _beyond(self, link: int, x: float | FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Force in the link's axes and moment about its start that act from beyond cuts."""
        place, motion = np.asarray(x, dtype=float), self.motion

        def at_cuts(values: AnyArray) -> AnyArray:
            return values[..., None] if place.ndim else values

        back = np.exp(-1j * motion.angle[..., link])
        force, moment = needed_by_inertia(
            motion, self.gravity, link, self.masses[link].before(place), at_cuts
        )
        force = force - at_cuts(back * _complex(self.start_force[..., link, :]))
        moment = moment - at_cuts(self.start_moment[..., link])
        for one in (*self.applied, *self.on_guides):
            if one.link == link:
                passed = at_cuts(np.broadcast_to(one.x, back.shape)) < place
                force = force - passed * at_cuts(back * _complex(one.force))
                moment = moment - passed * at_cuts(one.moment(motion))
        return force, moment


def needed_by_inertia(
    motion: RigidMotion,
    gravity: tuple[float, float],
    link: int,
    moments: MassMoments,
    spread: Callable[[AnyArray], AnyArray] = np.asarray,
) -> tuple[ComplexArray, FloatArray]:
    """Force and moment that accelerate mass of a link against its weight.

    Kumar & Chandrakar, eqs. 1.43 and 1.44.

    Parameters
    ----------
    motion : RigidMotion
    gravity : tuple of float
        In ground axes, m/s^2.
    link : int
    moments : tuple
        See :meth:`LinkMass.before`.
    spread : callable
        Gives values (...) of positions the dimensions of the moments.

    Returns
    -------
    force : ndarray of complex
        Along and across the link's frame, N.
    moment : ndarray
        About the link's start, N m.
    """
    mass, first, second = moments
    speed, change = motion.angular_velocity[..., link], motion.angular_acceleration[..., link]
    ground_pull = _complex(motion.origin_acceleration[..., link, :] - np.asarray(gravity))
    pull = spread(ground_pull * np.exp(-1j * motion.angle[..., link]))
    force = mass * pull + first * spread(1j * change - speed**2)
    moment = np.imag(np.conj(first) * pull) + second * spread(change)
    return force, moment


def _complex(vector: FloatArray) -> ComplexArray:
    """Vectors (..., 2) as complex numbers (...)."""
    return vector[..., 0] + 1j * vector[..., 1]


@dataclass(frozen=True)
class InverseDynamics(LinkForces):
    """Joint and internal forces of the rigid linkage in its motion.

    Parameters
    ----------
    motion, masses, gravity, start_force, start_moment, applied, on_guides
        As in :class:`LinkForces`.
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
    needed = [needed_by_inertia(motion, gravity, n, own.moments) for n, own in enumerate(masses)]
    force = np.stack([-own for own, _ in needed], axis=-1) * np.exp(1j * motion.angle)
    moment = np.stack([-own for _, own in needed], axis=-1)
    load = np.stack([force.real, force.imag, moment], axis=-1)
    angles = motion.angle if continuous_angles is None else continuous_angles
    applied = tuple(applied_forces(topology, motion, loads, springs, joint_springs, angles, time))
    for one in applied:
        load[..., one.link, :2] += one.force
        load[..., one.link, 2] += one.moment(motion)
    matrix = connection_matrix(topology, motion)
    unknown = solve_connections(topology, motion, load.reshape(*load.shape[:-2], -1), matrix)
    vectors = unknown[..., None] * connection_vectors(topology, matrix)
    every = connections(topology)
    couples = np.where([one.component == 2 for one in every], unknown, 0.0)
    joint_force = {name: np.zeros((*unknown.shape[:-1], 2)) for name in topology.joint_names}
    joint_moment = {name: np.zeros(unknown.shape[:-1]) for name in topology.joint_names}
    for number, connection in enumerate(every):
        joint_force[connection.joint] += vectors[..., number, :]
        joint_moment[connection.joint] += couples[..., number]
    start_force, start_moment, on_guides = _on_links(topology, motion, vectors, couples)
    return InverseDynamics(
        motion=motion,
        masses=tuple(masses),
        gravity=gravity,
        start_force=start_force,
        start_moment=start_moment,
        applied=applied,
        on_guides=on_guides,
        joint_force=joint_force,
        joint_moment=joint_moment,
        driving_torque=_driving_torque(topology, motion, joint_force, joint_moment),
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
