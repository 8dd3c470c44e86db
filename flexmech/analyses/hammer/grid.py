"""The impact roves over points of all links: mode shapes, as a laboratory finds them.

The response point stays. By reciprocity the residues of one mode over the impact points are its
shape there, times what the mode moves at the response point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.choices import LinkDirection
from flexmech.linear_system import Engine, LinkPoint
from flexmech.modal_testing import IdentifiedModes, complexity_factor, mac
from flexmech.types import ComplexArray, FloatArray

Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]
OVER_MODES, OVER_POINTS = ("crank_angle", "mode"), ("crank_angle", "point", "mode")


@dataclass(frozen=True, eq=False)
class GridShapes:
    """Shapes of the modes of one crank angle at the points of a grid.

    Parameters
    ----------
    shape : ndarray of complex, shape (P, k)
        Identified; the point that moves most has 1. Not a number for modes that were not found.
    eigen_shape : ndarray of complex, shape (P, k)
        Of the eigen model, scaled to the identified one.
    mac : ndarray, shape (k,)
        Of both.
    complexity_factor, eigen_complexity_factor : ndarray, shape (k,)
    """

    shape: ComplexArray
    eigen_shape: ComplexArray
    mac: FloatArray
    complexity_factor: FloatArray
    eigen_complexity_factor: FloatArray


def grid_points(engine: Engine, count: int) -> list[LinkPoint]:
    """Points at the middles of as many equal parts of each link: none is held by a joint.

    Parameters
    ----------
    engine : Engine
    count : int
        Points a link.

    Returns
    -------
    list of LinkPoint
        Link by link, from its first joint.
    """
    fractions = (np.arange(count) + 0.5) / count
    names = engine.mechanism.linkage.topology.link_names
    return [LinkPoint(name, float(fraction)) for name in names for fraction in fractions]


def grid_shapes(
    locked: LockedLinkage,
    points: Sequence[LinkPoint],
    direction: LinkDirection,
    poles: ComplexArray,
    modes: IdentifiedModes,
) -> GridShapes:
    """Compare identified shapes with those of the eigen model.

    Parameters
    ----------
    locked : LockedLinkage
    points : sequence of LinkPoint
        P of them.
    direction : {"transverse", "axial"}
    poles : ndarray of complex, shape (k,)
        Of the eigen model, among those of ``locked``.
    modes : IdentifiedModes
        In the order of ``poles``; its last P rows of residues are those of the points.

    Returns
    -------
    GridShapes
    """
    identified = modes.residue[-len(points) :]
    column = [int(np.argmin(np.abs(locked.modes.poles - pole))) for pole in poles]
    eigen = locked.rows(points, direction) @ locked.modes.right[:, column]
    shape = _scaled(identified)
    likeness = np.array([mac(a, b)[0, 0] for a, b in zip(shape.T, eigen.T, strict=True)])
    return GridShapes(
        shape,
        _fitted(eigen, shape),
        likeness,
        complexity_factor(identified),
        complexity_factor(eigen),
    )


def grid_variables(found: Sequence[GridShapes], modes: int) -> Variables:
    """Variables of a dataset over crank angle, point and mode.

    Parameters
    ----------
    found : sequence of GridShapes
        One for each crank angle.
    modes : int
        Of the dataset; an angle may have fewer.

    Returns
    -------
    dict of str to tuple
        ``shape_real``, ``shape_imag``, ``eigen_shape_real`` and ``eigen_shape_imag`` over
        (crank_angle, point, mode); ``mac``, ``complexity_factor`` and
        ``eigen_complexity_factor`` over (crank_angle, mode).
    """
    of_points: dict[str, Callable[[GridShapes], FloatArray]] = {
        "shape_real": lambda each: np.asarray(each.shape.real, dtype=float),
        "shape_imag": lambda each: np.asarray(each.shape.imag, dtype=float),
        "eigen_shape_real": lambda each: np.asarray(each.eigen_shape.real, dtype=float),
        "eigen_shape_imag": lambda each: np.asarray(each.eigen_shape.imag, dtype=float),
    }
    of_modes: dict[str, Callable[[GridShapes], FloatArray]] = {
        "mac": lambda each: each.mac,
        "complexity_factor": lambda each: each.complexity_factor,
        "eigen_complexity_factor": lambda each: each.eigen_complexity_factor,
    }
    variables: Variables = {
        name: (OVER_POINTS, np.stack([_widened(values(each), modes) for each in found]))
        for name, values in of_points.items()
    }
    return variables | {
        name: (OVER_MODES, np.stack([_widened(values(each), modes) for each in found]))
        for name, values in of_modes.items()
    }


def _scaled(shapes: ComplexArray) -> ComplexArray:
    """Columns over their greatest entry."""
    greatest = np.argmax(np.abs(shapes), axis=0)
    # Modes that were not found are not numbers.
    with np.errstate(invalid="ignore"):
        return np.asarray(shapes / shapes[greatest, np.arange(shapes.shape[1])])


def _fitted(shapes: ComplexArray, wanted: ComplexArray) -> ComplexArray:
    """Columns scaled to others by least squares; over their greatest entry where those are none."""
    known = np.isfinite(wanted).all(axis=0)
    target = np.where(known, wanted, _scaled(shapes))
    factor = np.sum(shapes.conj() * target, axis=0) / np.sum(np.abs(shapes) ** 2, axis=0)
    return np.asarray(shapes * factor)


def _widened(values: FloatArray, modes: int) -> FloatArray:
    """Not a number for the modes that an angle has not."""
    missing = modes - values.shape[-1]
    return np.pad(values, [(0, 0)] * (values.ndim - 1) + [(0, missing)], constant_values=np.nan)
