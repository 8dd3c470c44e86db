"""Curvature of links that bend by finite angles.

Across the link's frame an axis of arc length s is displaced by v(s), with ``v' = sin(theta)`` where
it does not stretch, so that ``kappa = theta' = v'' / cos(theta)``; Antman, *Nonlinear Problems of
Elasticity*, 2nd ed. 2005, ch. 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.link_readings import LinkReadings
from flexmech.mechanism import Mechanism

# Nodes that determine the curvature at a place.
_NODES = 3


def kinks_of(mechanism: Mechanism, link: str) -> list[float]:
    """Where masses, bodies, loads and springs act on a link, m from its start."""
    mass = mechanism.link_mass(link)
    bodies = (body.position for body in mass.bodies)
    return [*mass.point_positions, *bodies, *mechanism.acting_at(link)]


def bent_curvature(
    link: LinkModel, displacement: FloatArray, place: FloatArray, kinks: Sequence[float] = ()
) -> FloatArray:
    """Bending curvature along a link, as far as its axis turns in its frame.

    Parameters
    ----------
    link : LinkModel
        Elastic.
    displacement : ndarray, shape (B, n_link)
    place : ndarray, shape (k,)
        From the link's start in m.
    kinks : sequence of float
        Places in m at which something acts, and the slope of the curvature jumps: it is read from
        nodes on one side of them.

    Returns
    -------
    ndarray, shape (B, k)
        In 1/m, positive where it curves the link towards the y axis of its frame.
    """
    readings, q = link.readings, displacement
    if (basis := readings.basis) is not None:
        readings, q = replace(readings, basis=None), q @ basis.T
    q = readings.with_slope_vectors(q)
    rows = _rows(readings, place, kinks)
    if readings.deflection is None:
        # Of sections that shear: by their rotations alone, which are angles.
        return np.asarray(q @ rows.T)
    turned = q @ readings.rotations_at(place / readings.nodes[-1]).T
    if readings.slope in link.vectors[1]:
        # Slope vectors have the sine itself, but for the strain.
        cosine = np.sqrt(1.0 - np.clip(turned, -1.0, 1.0) ** 2)
    else:
        q = q.copy()
        slopes = q[:, readings.slope :: readings.per_node]
        q[:, readings.slope :: readings.per_node] = np.sin(slopes)
        cosine = np.cos(turned)
    return np.asarray(q @ rows.T / cosine)


def _rows(readings: LinkReadings, place: FloatArray, kinks: Sequence[float]) -> FloatArray:
    """Second derivative across the frame at places (k,) by nodal coordinates, (k, n)."""
    nodes, per_node = readings.nodes, readings.per_node
    near = SAME_PLACE * float(nodes[-1])
    ends = np.unique([0.0, *kinks, float(nodes[-1])])
    part = np.clip(np.searchsorted(ends, place, side="right") - 1, 0, len(ends) - 2)
    rows = np.empty((len(place), per_node * len(nodes)))
    for number in np.unique(part):
        there = part == number
        (own,) = np.nonzero((nodes >= ends[number] - near) & (nodes <= ends[number + 1] + near))
        if len(own) < _NODES:
            rows[there] = readings.curvatures_at(place[there])
            continue
        columns = slice(per_node * own[0], per_node * (own[-1] + 1))
        rows[there] = 0.0
        start = nodes[own[0]]
        among = replace(readings, nodes=nodes[own] - start)
        rows[there, columns] = among.curvatures_at(place[there] - start)
    return rows
