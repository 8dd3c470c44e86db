"""Polar coordinates of cable nodes, stretch and angle of the slope, where the angle is needed.

A cable's node has a slope vector ``(1 + s_x, s_y)``. A weld keeps the angle between two such
vectors, and a body on a node turns with one; the stretch of each is the link's own. By stretch e
and angle phi,

    s_x = (1 + e) cos(phi) - 1,    s_y = (1 + e) sin(phi),

such a condition is linear: two angles differ by a constant. Its forces then add nothing to the
tangent stiffness but what this map adds, second derivatives of the slope times the forces on it.
To first order about the straight link both pairs of coordinates are the same.

Places at which links need a node, or a cable's node an angle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import LinkBody, LinkEnd, LinkMass, Load, Topology
from flexmech.linkages.link_mass import LEAST_DISTANCE
from flexmech.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class PolarSlopes:
    """Nodes of one link with stretch and angle of the slope as coordinates.

    Parameters
    ----------
    first : ndarray of int, shape (k,)
        Coordinate of the link that is the stretch of each; the angle comes next to it.
    """

    first: IntArray

    @property
    def inverse(self) -> _CartesianSlopes:
        """Inverse map, from slope vectors to stretch and angle."""
        return _CartesianSlopes(self.first)

    def to_nodes(self, polar: FloatArray) -> FloatArray:
        """Coordinates of the nodes, less the reference ones.

        Parameters
        ----------
        polar : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        nodes = polar.copy()
        stretch, cosine, sine = self._slope(polar)
        own, half = polar[..., self.first], polar[..., self.first + 1] / 2
        # (1 + e) cos(phi) - 1, whose digits a difference of ones would lose.
        nodes[..., self.first] = own * cosine - 2 * np.sin(half) ** 2
        nodes[..., self.first + 1] = stretch * sine
        return nodes

    def rate_to_nodes(self, polar: FloatArray, rate: FloatArray) -> FloatArray:
        """Velocities of the nodes.

        Parameters
        ----------
        polar, rate : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        nodes = rate.copy()
        stretch, cosine, sine = self._slope(polar)
        growing, turning = rate[..., self.first], stretch * rate[..., self.first + 1]
        nodes[..., self.first] = growing * cosine - turning * sine
        nodes[..., self.first + 1] = growing * sine + turning * cosine
        return nodes

    def force(self, polar: FloatArray, force: FloatArray) -> FloatArray:
        """Forces on the nodes as those on stretch and angle, ``J' f``.

        Parameters
        ----------
        polar, force : ndarray, shape (..., n)

        Returns
        -------
        ndarray, shape (..., n)
        """
        result = force.copy()
        stretch, cosine, sine = self._slope(polar)
        x, y = force[..., self.first], force[..., self.first + 1]
        result[..., self.first] = x * cosine + y * sine
        result[..., self.first + 1] = stretch * (y * cosine - x * sine)
        return result

    def matrix(self, polar: FloatArray, matrix: FloatArray) -> FloatArray:
        """A matrix of the nodes' coordinates in stretch and angle, ``J' X J``.

        Parameters
        ----------
        polar : ndarray, shape (..., n)
        matrix : ndarray, shape (..., n, n)

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        size = polar.shape[-1]
        gradient = np.zeros((*polar.shape, size))
        every = np.arange(size)
        gradient[..., every, every] = 1.0
        stretch, cosine, sine = self._slope(polar)
        e, phi = self.first, self.first + 1
        gradient[..., e, e], gradient[..., e, phi] = cosine, -stretch * sine
        gradient[..., phi, e], gradient[..., phi, phi] = sine, stretch * cosine
        return np.asarray(np.swapaxes(gradient, -1, -2) @ matrix @ gradient)

    def tangent(self, polar: FloatArray, stiffness: FloatArray, force: FloatArray) -> FloatArray:
        """Tangent stiffness in stretch and angle.

        Parameters
        ----------
        polar : ndarray, shape (..., n)
        stiffness : ndarray, shape (..., n, n)
            Of the nodes.
        force : ndarray, shape (..., n)
            Internal forces on the nodes, less outer ones that keep their direction.

        Returns
        -------
        ndarray, shape (..., n, n)
        """
        tangent = self.matrix(polar, stiffness)
        stretch, cosine, sine = self._slope(polar)
        e, phi = self.first, self.first + 1
        x, y = force[..., e], force[..., phi]
        along, across = x * cosine + y * sine, y * cosine - x * sine
        tangent[..., e, phi] += across
        tangent[..., phi, e] += across
        tangent[..., phi, phi] -= stretch * along
        return tangent

    def _slope(self, polar: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Length, cosine and sine of the slope vectors."""
        angle = polar[..., self.first + 1]
        return 1 + polar[..., self.first], np.cos(angle), np.sin(angle)


@dataclass(frozen=True, eq=False)
class _CartesianSlopes:
    """Inverse map; see :class:`PolarSlopes`."""

    first: IntArray

    @property
    def inverse(self) -> PolarSlopes:
        """Map from stretch and angle to slope vectors."""
        return PolarSlopes(self.first)

    def to_nodes(self, nodes: FloatArray) -> FloatArray:
        """Stretch and angle, the angle within half a turn."""
        polar = nodes.copy()
        x, y = 1 + nodes[..., self.first], nodes[..., self.first + 1]
        polar[..., self.first] = np.hypot(x, y) - 1
        polar[..., self.first + 1] = np.arctan2(y, x)
        return polar

    def rate_to_nodes(self, nodes: FloatArray, rate: FloatArray) -> FloatArray:
        """Rates of stretch and angle."""
        polar = rate.copy()
        x, y = 1 + nodes[..., self.first], nodes[..., self.first + 1]
        dx, dy = rate[..., self.first], rate[..., self.first + 1]
        length = np.hypot(x, y)
        polar[..., self.first] = (x * dx + y * dy) / length
        polar[..., self.first + 1] = (x * dy - y * dx) / length**2
        return polar


def required_nodes(mechanism: Mechanism, mass: LinkMass, link: str, exact: bool) -> list[float]:
    """Places along a link that need a node.

    Point masses and bodies, and on exact beams points at which loads or springs act: a cable
    takes forces anywhere, but a torque and what turns with the link at nodes alone.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    exact : bool
        Whether it is of exact beams.

    Returns
    -------
    list of float
        In m.
    """
    places = [*mass.point_positions, *(body.position for body in mass.bodies)]
    points = [load.point.x for load in _turned_loads(mechanism, link)]
    if exact:
        points += [load.point.x for load in mechanism.loads if load.point.link == link]
        for spring in mechanism.springs:
            points += [end.x for end in (spring.first, spring.second) if end.link == link]
    least = LEAST_DISTANCE * mass.length
    for point in points:
        if all(abs(point - place) >= least for place in (0.0, mass.length, *places)):
            places.append(point)
    return places


def places_with_angles(mechanism: Mechanism, mass: LinkMass, link: str) -> list[float]:
    """Places along a link of cables in m at which the angle is a coordinate.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    """
    topology = mechanism.linkage.topology
    ends = [end for weld in topology.welds for end in (weld.leader, weld.follower)]
    ends += [clamp.link_end for clamp in topology.clamps[1:]]
    places = [0.0 if end.end == "start" else mass.length for end in ends if end.link == link]
    places += [load.point.x for load in _turned_loads(mechanism, link)]
    bodies = [*mass.bodies, *turned_bodies(mechanism, mass, link)]
    return [*places, *(body.position for body in bodies)]


def turned_bodies(mechanism: Mechanism, mass: LinkMass, link: str) -> list[LinkBody]:
    """Massless bodies at ends of a link of cables on which torsional springs act.

    Parameters
    ----------
    mechanism : Mechanism
    mass : LinkMass
        Of the link.
    link : str
    """
    ends: set[LinkEnd] = set()
    for own in mechanism.joint_springs:
        if own.torsional_stiffness or own.torsional_damping:
            pair = mechanism.linkage.topology.pinned_ends[own.joint]
            ends |= {end for end in pair if end is not None and end.link == link}
    places = sorted(0.0 if end.end == "start" else mass.length for end in ends)
    return [LinkBody(place, 0.0) for place in places]


def dependent_joints(topology: Topology, end: LinkEnd) -> list[str]:
    """Joints whose leader is, through other joints, a given follower.

    Their forces on the end of the leader act on the follower's link.

    Parameters
    ----------
    topology : Topology
    end : LinkEnd
        Follower of a rigid pin or weld.

    Returns
    -------
    list of str
    """
    leaders = {tie.follower: tie.leader for tie in topology.rigid_ties}
    found = []
    for tie in topology.ties:
        place: LinkEnd | None = tie.leader
        while place is not None and place != end:
            place = leaders.get(place)
        if place is not None:
            found.append(tie.joint)
    return found


def _turned_loads(mechanism: Mechanism, link: str) -> Iterator[Load]:
    """Follower forces on a link, and loads with a torque."""
    for load in mechanism.loads:
        if load.point.link == link and (load.axes == "link" or any(load.torque)):
            yield load
