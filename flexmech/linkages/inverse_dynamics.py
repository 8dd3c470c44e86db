"""Inverse dynamics of the rigid linkage: joint forces, driving torque, forces inside the links.

Kumar & Chandrakar, eqs. 1.43-1.44 (link inertia force and moment) and 1.64-1.65 (lumped
masses). All results are batched over the positions of a :class:`RigidMotion`.

Joint forces are the constraint forces of clamps, pivots, pins, welds and sliders in the equations
of motion.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.applied_forces import ForceOnLink, JointSpring, Load, Spring, applied_forces
from flexmech.linkages.body_motion import (
    GROUND_AFTER_LINKS,
    BodyMotion,
    BodyPoint,
    Coincidence,
    Condition,
    Constraints,
    EqualAngle,
)
from flexmech.linkages.link_mass import LinkMass, MassMoments
from flexmech.linkages.motion import RigidMotion, cross, direction
from flexmech.linkages.topology import LinkEnd, Slider, Topology
from flexmech.model_text import shapes, short_repr

# Singular values of conditions and equations, with moments divided by the longest link, that count
# as none, over the largest: above what round-off leaves of them, 1e-12 near a dead point.
RANK_TOLERANCE = 1e-9
# Above this ratio of connection forces to what they carry, the equations may be singular: levers
# of links make ratios of some thousands, and round-off in place of zero makes 1e12 and more.
SUSPICIOUS_FORCE = 1e8


@dataclass(frozen=True)
class Connection:
    """One unknown: a force along a ground axis, a couple, or a force across a slider's line.

    Parameters
    ----------
    joint : str
    component : {0, 1, 2, 3}
        Force along ground x or y, couple, force along the left normal of a slider's line.
    place : LinkEnd
        The grounded or following end, on which it acts.
    other : LinkEnd or None
        The leading end, on which its opposite acts; None where that is the ground or a guide.
    slider : Slider or None
        Whose line carries the force.
    """

    joint: str
    component: int
    place: LinkEnd
    other: LinkEnd | None = None
    slider: Slider | None = None


@lru_cache(maxsize=64)
def connections(topology: Topology) -> tuple[Connection, ...]:
    """Every unknown of a linkage: clamps and welds have 3, pivots and pins 2, sliders 1."""
    unknowns = []
    for clamp in topology.clamps:
        unknowns += [Connection(clamp.joint, i, clamp.link_end) for i in (0, 1, 2)]
    for pivot in topology.pivots:
        unknowns += [Connection(pivot.joint, i, pivot.link_end) for i in (0, 1)]
    for pin in topology.pins:
        unknowns += [Connection(pin.joint, i, pin.follower, pin.leader) for i in (0, 1)]
    for weld in topology.welds:
        unknowns += [Connection(weld.joint, i, weld.follower, weld.leader) for i in (0, 1, 2)]
    for slider in topology.sliders:
        unknowns.append(Connection(slider.joint, 3, slider.link_end, slider=slider))
    return tuple(unknowns)


def end_point(topology: Topology, end: LinkEnd) -> BodyPoint:
    """Point of a link end, by the link's number."""
    return BodyPoint(*topology.end_place(end))


class SliderLine(NamedTuple):
    """A point of a link that slides on a line through a point of another one.

    Parameters
    ----------
    first, second : BodyPoint
        The point, and one through which the line passes.
    along : complex
        Unit vector of the line in the axes of the body that carries it.
    """

    first: BodyPoint
    second: BodyPoint
    along: complex


def slider_line(topology: Topology, slider: Slider) -> SliderLine:
    """Line of a slider; links are numbered as in the topology."""
    guide = topology.index(slider.guide) if slider.guide else GROUND_AFTER_LINKS
    along = cmath.rect(1.0, slider.direction)
    line = BodyPoint(guide, 1j * slider.offset * along)
    return SliderLine(end_point(topology, slider.link_end), line, along)


@lru_cache(maxsize=64)
def _constraints(topology: Topology) -> Constraints:
    """Constraints of all joints in the order of the connections.

    The places of ends are numbered link by link, that of its start first, and after them those of
    sliders on their lines.
    """

    def point(end: LinkEnd | None) -> BodyPoint:
        if end is None:
            return BodyPoint(GROUND_AFTER_LINKS)
        link = topology.index(end.link)
        return BodyPoint(link, slide=2 * link + (end.end == "end"))

    conditions: list[Condition] = []
    slides = count(2 * len(topology.links))
    for one in connections(topology):
        if one.slider is not None:
            guide = slider_line(topology, one.slider).second.body
            conditions.append(Coincidence(point(one.place), BodyPoint(guide, slide=next(slides))))
        elif one.component == 0:
            conditions.append(Coincidence(point(one.place), point(one.other)))
        elif one.component == 2:
            conditions.append(EqualAngle(point(one.place).body, point(one.other).body))
    return Constraints(conditions, range(len(topology.links)))


def guide_place(
    topology: Topology, motion: RigidMotion, slider: Slider
) -> tuple[FloatArray, FloatArray]:
    """Position of a sliding point in the frame of its guide.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    slider : Slider
        With a guide.

    Returns
    -------
    tuple of ndarray, shape (...)
        Along and across the guide's frame in m.
    """
    line, guide = end_point(topology, slider.link_end), topology.index(slider.guide)
    vector = motion.position(line.body, line.place.real) - motion.origin[..., guide, :]
    place = (vector[..., 0] + 1j * vector[..., 1]) * np.exp(-1j * motion.angle[..., guide])
    return place.real, place.imag


def connection_matrix(
    topology: Topology, motion: RigidMotion, displaced: ComplexArray | None = None
) -> FloatArray:
    """Transposed constraint Jacobian: forces and moments on the links by unit connection forces.

    A moment is about the link's start in the rigid motion.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    displaced : ndarray of complex, shape (m, n_links, 2), optional
        Displacements of the links' starts and ends in ground axes in m, with which rigid links
        turn; for a batch of shape (m,).

    Returns
    -------
    ndarray, shape (..., 3 * n_links, n_unknowns)
        Rows of a link: force along ground x and y, moment.
    """
    batch = motion.crank_angle.shape
    flat = motion.at(np.ones(batch, dtype=bool))
    bodies = BodyMotion.of_links(flat)
    arms = bodies.turn[:, :-1, None] * [[0.0, link.length] for link in topology.links]
    if displaced is not None:
        arms = arms + displaced
        rigid = [number for number, link in enumerate(topology.links) if link.rigid]
        chord = arms[:, rigid, 1] - arms[:, rigid, 0]
        bodies.turn[:, rigid] = chord / np.abs(chord)
    columns = [np.conj(bodies.turn[:, :-1, None]) * arms]
    sliders = topology.sliders
    guides = [slider_line(topology, slider).second.body for slider in sliders]
    for slider, guide in zip(sliders, guides, strict=True):
        link = topology.index(slider.link_end.link)
        here = bodies.place[:, link] + arms[:, link, int(slider.link_end.end == "end")]
        columns.append(np.conj(bodies.turn[:, guide]) * (here - bodies.place[:, guide]))
    places = np.concatenate([column.reshape(len(arms), -1) for column in columns], axis=1)
    matrix = _constraints(topology).jacobian(bodies, None, places)
    if sliders:
        # A line carries force across it alone; connections at sliders are the last ones.
        across = 1j * np.exp([1j * slider.direction for slider in sliders]) * bodies.turn[:, guides]
        held, on_lines = np.split(matrix, [-2 * len(sliders)], axis=1)
        across_x, across_y = across.real[..., None], across.imag[..., None]
        carried = across_x * on_lines[:, ::2] + across_y * on_lines[:, 1::2]
        matrix = np.concatenate([held, carried], axis=1)
    return np.swapaxes(matrix, -1, -2).reshape(*batch, -1, matrix.shape[-2])


def connection_vectors(topology: Topology, matrix: FloatArray) -> FloatArray:
    """Force on the link that is held or follows by each unit connection force; none by a couple.

    Parameters
    ----------
    topology : Topology
    matrix : ndarray, shape (..., 3 * n_links, n_unknowns)
        Matrix of :func:`connection_matrix`.

    Returns
    -------
    ndarray, shape (..., n_unknowns, 2)
        In ground axes.
    """
    links = [topology.index(one.place.link) for one in connections(topology)]
    rows = 3 * np.array(links)[:, None] + np.arange(2)
    return np.asarray(matrix[..., rows, np.arange(len(links))[:, None]])


def solve_connections(
    topology: Topology,
    motion: RigidMotion,
    load: FloatArray,
    matrix: FloatArray | None = None,
) -> FloatArray:
    """Connection forces from the force and moment balance of the links.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    load : ndarray, shape (..., 3 * n_links)
        Forces and moments about the links' starts in the rigid motion, inertia among them.
    matrix : ndarray, shape (..., 3 * n_links, n_unknowns), optional
        Matrix of :func:`connection_matrix`; at the places of the rigid motion by default.

    Returns
    -------
    ndarray, shape (..., 3 * n_links)
        In the order of :func:`connections`.

    Raises
    ------
    InputError
        If the linkage is over- or underconstrained; names a joint.
    """
    if matrix is None:
        matrix = connection_matrix(topology, motion)
    if matrix.shape[-1] != matrix.shape[-2]:
        raise InputError(_what_is_wrong(topology, motion, matrix))
    try:
        solved = np.asarray(-np.linalg.solve(matrix, load[..., None])[..., 0], dtype=float)
    except np.linalg.LinAlgError:
        raise InputError(_what_is_wrong(topology, motion, matrix)) from None
    # Round-off makes a singular matrix regular; what it gives is then far too large.
    shortest = min(link.length for link in topology.links)
    load_scale = np.abs(load).max(initial=0.0) * max(1.0, 1.0 / shortest)
    if not np.abs(solved).max(initial=0.0) <= SUSPICIOUS_FORCE * load_scale:
        words = _what_is_wrong(topology, motion, matrix)
        if words:
            raise InputError(words)
    return solved


def _what_is_wrong(topology: Topology, motion: RigidMotion, matrix: FloatArray) -> str:
    """Joint that constrains too much or too little, in the first position where one does."""
    equations, unknowns = matrix.shape[-2:]
    longest = max(link.length for link in topology.links)
    scaled = matrix.reshape(-1, equations, unknowns).copy()
    scaled[:, 2::3] /= longest
    couples = [number for number, c in enumerate(connections(topology)) if c.component == 2]
    scaled[:, :, couples] *= longest
    for angle, case in zip(motion.crank_angle.ravel(), scaled, strict=True):
        left, values, _ = np.linalg.svd(case)
        rank = int(np.sum(values > RANK_TOLERANCE * values[0])) if len(values) else 0
        if rank == unknowns == equations:
            continue
        faults = []
        if rank < unknowns:
            joint = _first_dependent(topology, case)
            faults.append(
                f"joint {joint} repeats constraints of the other joints; make it a pin, a "
                "slider or a free end"
            )
        if rank < equations:
            link = int(np.argmax(np.abs(left[:, rank:]).max(axis=-1).reshape(-1, 3).max(axis=-1)))
            joints = ", ".join(_joints_of(topology, topology.links[link].name)) or "none"
            faults.append(
                f"the {topology.links[link].name} can move although the shaft is fixed; constrain "
                f"it at one of its joints (it has {joints})"
            )
        return (
            f"{unknowns} connection forces for {equations} equations of motion: the linkage is "
            f"not held exactly once at crank angle {np.degrees(angle):.6g} deg: "
            + ", and ".join(faults)
        )
    return ""


def _first_dependent(topology: Topology, matrix: FloatArray) -> str:
    """Joint of the first unknown that depends linearly on those before it."""
    unknowns = connections(topology)
    for columns in range(1, len(unknowns)):
        values = np.linalg.svd(matrix[:, :columns], compute_uv=False)
        if len(values) < columns or values[-1] <= RANK_TOLERANCE * values[0]:
            return unknowns[columns - 1].joint
    return unknowns[-1].joint


def _joints_of(topology: Topology, link: str) -> list[str]:
    """Joints of a link, in order and each once."""
    unknowns = connections(topology)
    joints = [c.joint for c in unknowns if c.place.link == link]
    joints += [c.joint for c in unknowns if c.other is not None and c.other.link == link]
    joints += [slider.joint for slider in topology.sliders if slider.guide == link]
    return list(dict.fromkeys(joints))


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
        Loads, forces of springs, and those of sliders on their guides.
    """

    motion: RigidMotion
    masses: tuple[LinkMass, ...]
    gravity: tuple[float, float]
    start_force: FloatArray
    start_moment: FloatArray
    applied: tuple[ForceOnLink, ...]

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
        for one in self.applied:
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
    motion, masses, gravity, start_force, start_moment, applied
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
        Time of each position in s, for loads over time.
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
    needed = [needed_by_inertia(motion, gravity, n, mass.moments) for n, mass in enumerate(masses)]
    force = np.stack([-force for force, _ in needed], axis=-1) * np.exp(1j * motion.angle)
    moment = np.stack([-moment for _, moment in needed], axis=-1)
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
        applied=(*applied, *on_guides),
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
    acting = (*applied, *on_guides)
    return LinkForces(motion, tuple(masses), gravity, start_force, start_moment, acting)


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
