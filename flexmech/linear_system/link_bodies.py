"""Rigid bodies that are fixed to nodes of an elastic link, in the link's matrices.

A body whose centre of mass is at ``e = (a, c)`` from its node moves with it by
``(u - c phi, v + a phi)`` and turns by ``phi``. Its inertia force and weight keep their direction:
with the moment m and the virial V about the node, of a body that is not turned, their moment is
``m cos(phi) - V sin(phi)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.linear_system.chains import LinkMatrix, with_entries
from flexmech.linear_system.link_model import LinkModel
from flexmech.linkages import LinkBody, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class BodyMatrices:
    """What bodies add to the matrices of their link; see :class:`LinkModel` for each.

    Parameters
    ----------
    mass, gyroscopic, translational_mass : ndarray, shape (n, n)
    first_moment : ndarray, shape (2, n)
    """

    mass: FloatArray
    gyroscopic: FloatArray
    translational_mass: FloatArray
    first_moment: FloatArray

    @classmethod
    def of(cls, link: LinkModel, bodies: Sequence[LinkBody]) -> BodyMatrices:
        """Matrices of bodies at nodes of an unreduced link.

        Parameters
        ----------
        link : LinkModel
            With a node at each body's position.
        bodies : sequence of LinkBody

        Returns
        -------
        BodyMatrices
        """
        size, readings = link.size, link.readings
        mass, gyroscopic, translational = np.zeros((3, size, size))
        first_moment = np.zeros((2, size))
        for body, node in zip(bodies, body_nodes(readings.nodes, bodies), strict=True):
            start = readings.per_node * int(node)
            own = start + np.array([0, 1, readings.slope])
            square = np.ix_(own, own)
            m, (a, c) = body.mass, body.offset
            moved = np.array([[1.0, 0.0, -c], [0.0, 1.0, a]])
            quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
            carried = m * moved.T @ moved
            mass[square] += carried
            mass[own[2], own[2]] += body.inertia
            # A body that turns about its node keeps its centrifugal potential.
            carried[2, 2] = 0.0
            translational[square] += carried
            gyroscopic[square] += m * moved.T @ quarter @ moved
            first_moment[:, own[:2]] += m * np.array([[c, -a], [a, c]])
        return cls(mass, gyroscopic, translational, first_moment)


def body_nodes(nodes: FloatArray, bodies: Sequence[LinkBody]) -> IntArray:
    """Number of the node at each body's position.

    Parameters
    ----------
    nodes : ndarray, shape (k,)
        Node positions along the link in m.
    bodies : sequence of LinkBody

    Returns
    -------
    ndarray of int, shape (n_bodies,)
    """
    return np.array([np.argmin(np.abs(nodes - body.position)) for body in bodies], dtype=np.intp)


def with_bodies(link: LinkModel, bodies: Sequence[LinkBody]) -> LinkModel:
    """The unreduced link with bodies fixed to its nodes.

    Parameters
    ----------
    link : LinkModel
        With a node at each body's position.
    bodies : sequence of LinkBody

    Returns
    -------
    LinkModel
    """
    if not bodies:
        return link
    added = BodyMatrices.of(link, bodies)

    def plus(matrix: LinkMatrix, more: FloatArray) -> LinkMatrix:
        rows, columns = np.nonzero(more)
        return with_entries(matrix, rows, columns, more[rows, columns])

    return replace(
        link,
        mass=plus(link.mass, added.mass),
        gyroscopic=plus(link.gyroscopic, added.gyroscopic),
        translational_mass=plus(link.translational_mass, added.translational_mass),
        first_moment=link.first_moment + added.first_moment,
    )


def body_couple(
    body: LinkBody, motion: RigidMotion, link: int, gravity: tuple[float, float]
) -> FloatArray:
    """Virial and moment of a body's inertia force and weight about its node.

    Parameters
    ----------
    body : LinkBody
    motion : RigidMotion
        Batch of shape (B,).
    link : int
        Number of the link that it is fixed to.
    gravity : tuple of float
        In ground axes, m/s^2.

    Returns
    -------
    ndarray, shape (B, 2)
        In N m.
    """
    (a, c), second = body.offset, second_moment(body)
    angle, speed = motion.angle[:, link], motion.angular_velocity[:, link]
    pull = motion.acceleration(link, body.position) - np.asarray(gravity)
    x, y = np.sum(pull * direction(angle), axis=1), np.sum(pull * normal(angle), axis=1)
    virial = second * speed**2 - body.mass * (a * x + c * y)
    moment = body.mass * (c * x - a * y) - second * motion.angular_acceleration[:, link]
    return np.stack([virial, moment], axis=1)


def second_moment(body: LinkBody) -> float:
    """Polar second moment of a body about its node in kg m^2.

    Parameters
    ----------
    body : LinkBody

    Returns
    -------
    float
    """
    a, c = body.offset
    return body.inertia + body.mass * (a**2 + c**2)
