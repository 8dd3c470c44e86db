"""Where a link's nodes are, and the stations at which its displacement is read."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError

STATIONS = 21
"""Along a link: ends, middle and quarters are among them, and the fifth bending mode, which has two
and a half waves, eight to each wave."""


def pieces(length: float, point_positions: Sequence[float]) -> FloatArray:
    """Lengths of the pieces into which point masses divide a link."""
    slack = SAME_PLACE * length
    breaks = [0.0]
    for x in sorted(point_positions):
        if breaks[-1] + slack < x < length - slack:
            breaks.append(x)
    return np.diff([*breaks, length])


def node_positions(
    length: float, elements: int, point_positions: Sequence[float] = ()
) -> FloatArray:
    """Nodes along a link, one at each point mass.

    A point mass inside an element would put a kink into the shear force that the element
    cannot follow, and cost an order of convergence.

    Parameters
    ----------
    length : float
        In m.
    elements : int
        Total number of elements.
    point_positions : sequence of float
        Where point masses sit, m from the start; ends and repetitions do no harm.

    Returns
    -------
    ndarray, shape (elements + 1,)

    Raises
    ------
    InputError
        If there are fewer elements than pieces between point masses.
    """
    if not point_positions:
        return np.linspace(0.0, length, elements + 1)
    parts = pieces(length, point_positions)
    if elements < len(parts):
        raise InputError(
            f"{elements} elements cannot put a node at each of {len(parts) - 1} point masses "
            f"along a link; ask for {len(parts)} elements or more"
        )
    counts = np.ones(len(parts), dtype=int)
    for _ in range(elements - len(parts)):
        counts[np.argmax(parts / counts)] += 1
    element_lengths = np.repeat(parts / counts, counts)
    return np.concatenate([[0.0], np.cumsum(element_lengths)[:-1], [length]])


def station_shapes(
    nodes: FloatArray,
    per_node: int,
    shape_functions: Callable[[FloatArray, FloatArray], FloatArray],
    element_maps: FloatArray | None = None,
) -> FloatArray:
    """Displacement at evenly spaced stations along a link from its nodal coordinates.

    Parameters
    ----------
    nodes : ndarray, shape (k,)
        Node positions in m.
    per_node : int
        Coordinates a node.
    shape_functions : callable
        ``shape_functions(fraction, length)`` gives the displacement inside elements,
        (s, 2, 2 per_node), at places from 0 to 1 in elements of given length, both (s,).
    element_maps : ndarray, shape (k - 1, 2 per_node, 2 per_node), optional
        Coordinates of each element by those of its two nodes, where they are not the same.

    Returns
    -------
    ndarray, shape (STATIONS, 2, k * per_node)
    """
    places = np.linspace(0.0, nodes[-1], STATIONS)
    return shapes_at(places, nodes, per_node, shape_functions, element_maps)


def shapes_at(
    places: FloatArray,
    nodes: FloatArray,
    per_node: int,
    shape_functions: Callable[[FloatArray, FloatArray], FloatArray],
    element_maps: FloatArray | None = None,
) -> FloatArray:
    """Displacement anywhere along a link from its nodal coordinates.

    Parameters
    ----------
    places : ndarray, shape (s,)
        In m from the link's start.
    nodes : ndarray, shape (k,)
        Node positions in m.
    per_node : int
        Coordinates a node.
    shape_functions : callable
    element_maps : ndarray, shape (k - 1, 2 per_node, 2 per_node), optional
        See :func:`station_shapes` for both.

    Returns
    -------
    ndarray, shape (s, 2, k * per_node)
    """
    element = np.clip(np.searchsorted(nodes, places, side="right") - 1, 0, len(nodes) - 2)
    length = np.diff(nodes)[element]
    values = shape_functions((places - nodes[element]) / length, length)
    if element_maps is not None:
        values = values @ element_maps[element]
    shapes = np.zeros((len(places), 2, per_node * len(nodes)))
    columns = per_node * element[:, None] + np.arange(2 * per_node)
    np.put_along_axis(shapes, np.repeat(columns[:, None, :], 2, axis=1), values, axis=2)
    return shapes


def curvature_at(
    place: float, nodes: FloatArray, per_node: int, slope: int, deflection: int | None = None
) -> FloatArray:
    """Bending curvature at a place of a link from its nodal coordinates.

    The curvature of a polynomial through the three nodes nearest to the place, which
    takes their deflections and slopes (a quintic; two orders better than the second
    derivative of a cubic element) or, where the element shears, their rotations alone.

    Parameters
    ----------
    place : float
        In m from the link's start.
    nodes : ndarray, shape (k,)
        Node positions in m.
    per_node : int
        Coordinates a node.
    slope, deflection : int
        Which of a node's coordinates are its slope (or rotation) and its deflection.

    Returns
    -------
    ndarray, shape (k * per_node,)
        Multiplies the coordinates; 1/m for coordinates in m and rad.
    """
    # Round-off must not choose between two nodes that are equally near.
    distance = np.round(np.abs(nodes - place) / nodes[-1], 9)
    nearest = np.sort(np.argsort(distance, kind="stable")[:3])
    scale = float(np.ptp(nodes[nearest]))
    places = (nodes[nearest] - place) / scale
    row = np.zeros(per_node * len(nodes))
    if deflection is None:
        powers = places[:, None] ** np.arange(len(nearest))
        row[per_node * nearest + slope] = np.linalg.inv(powers)[1] / scale
        return row
    degree = np.arange(2 * len(nearest))
    values = places[:, None] ** degree
    slopes = degree * places[:, None] ** np.maximum(degree - 1, 0) / scale
    second = 2 * np.linalg.inv(np.concatenate([values, slopes]))[2] / scale**2
    row[per_node * nearest + deflection] = second[: len(nearest)]
    row[per_node * nearest + slope] = second[len(nearest) :]
    return row
