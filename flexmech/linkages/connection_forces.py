"""Constraint forces of clamps, pivots, pins, welds and sliders in the equations of motion."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from typing import NamedTuple

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.body_motion import (
    GROUND_AFTER_LINKS,
    BodyMotion,
    BodyPoint,
    Coincidence,
    Condition,
    Constraints,
    EqualAngle,
)
from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.topology import LinkEnd, Slider, Topology

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
        Of :func:`connection_matrix`.

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
        Of :func:`connection_matrix`; at the places of the rigid motion by default.

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
    """Which joint constrains too much or too little, in the first position where one does."""
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
                f"joint {joint} constrains what the other joints already do; make it a pin, a "
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
