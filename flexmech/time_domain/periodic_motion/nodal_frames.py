"""Links with nodal displacements in ground axes, and the rates of these.

Each vector of a link, the displacement of a node or its slope vector, is turned by the link's
angle: ``d = R q``. With J the quarter turn of all vectors, the rate seen in the link's axes is
``v = R' d. = q. + omega J q``, and what the kinetic energy of the link has besides
``v' M v / 2`` is ``omega v' S* q + omega^2 q' M_t* q / 2`` with::

    S* = S - M J
    M_t* = M_t + J' M J - J' S - S' J

Both vanish where the shape functions turn with the nodes, as those of ANCF cables do: then the
inertia has no terms of turning frames in ground axes. Along beams whose displacements along and
across are of different degree a small rest remains, of the element's length.
"""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FourierSeries
from flexmech.linear_system import LinkModel


def inertia_in_ground_axes(link: LinkModel) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass matrix, ``S*`` and ``M_t*`` of a link, each (n, n).

    Parameters
    ----------
    link : LinkModel
        Unreduced.
    """
    turn = quarter_turn(link)
    crossed = turn.T @ link.gyroscopic
    turned = turn.T @ link.mass @ turn
    gyroscopic = link.gyroscopic - link.mass @ turn
    return link.mass, gyroscopic, link.centrifugal_mass + turned - crossed - crossed.T


def ground_rates(
    link: LinkModel, shapes: FloatArray, angle: FloatArray, period: float
) -> FloatArray:
    """Rates ``v`` of shapes along a turn, in the link's axes.

    Parameters
    ----------
    link : LinkModel
        Unreduced.
    shapes : ndarray, shape (N, n, m)
        In the link's frame at evenly spaced times of a turn.
    angle : ndarray, shape (N,)
        Of the link in rad.
    period : float
        In s.

    Returns
    -------
    ndarray, shape (N, n, m)
    """
    ground = _vectors_turned(link, shapes, angle)
    rates = FourierSeries.through(ground).rate().samples(len(shapes)) / period
    return _vectors_turned(link, rates, -angle)


def quarter_turn(link: LinkModel) -> FloatArray:
    """Matrix that rotates all vectors of a link by 90 deg and drops other coordinates.

    Parameters
    ----------
    link : LinkModel

    Returns
    -------
    ndarray, shape (n, n)
    """
    turn = np.zeros((link.size, link.size))
    x, y = link.vectors
    turn[x, y], turn[y, x] = -1.0, 1.0
    return turn


def _vectors_turned(link: LinkModel, shapes: FloatArray, angle: FloatArray) -> FloatArray:
    """Shapes (N, n, m) whose vectors are turned by angles (N,); other coordinates stay."""
    x, y = link.vectors
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    turned = shapes.copy()
    turned[:, x] = cosine * shapes[:, x] - sine * shapes[:, y]
    turned[:, y] = sine * shapes[:, x] + cosine * shapes[:, y]
    return turned
