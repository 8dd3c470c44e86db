"""Second-order stretch of a chain of beam elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.beams.link_matrices import Chain
from flexmech.linear_system import LinkStretch

# Directions in which an element's slopes are none but for round-off, to the greatest.
_NO_SLOPE = 1e-12
# Ways of an element to move without bending, to the stiffest: round-off.
_NO_BENDING = 1e-10


def chain_stretch(chain: Chain, *, turns_far: bool = False) -> LinkStretch:
    """Mean axial strain of each element of a link, to second order about the straight link.

    The strain of a corotational element (:mod:`flexmech.reference.corotational`) for small
    turns: the elongation of the chord and half the mean of the squared slope. That mean is a
    weighted sum of the squares of some slopes.

    Parameters
    ----------
    chain : Chain
    turns_far : bool
        Whether the link turns so far against its frame that bending must not depend on it.

    Returns
    -------
    LinkStretch
    """
    elements, size = chain.elements, chain.model.size
    count, per_node = len(elements.length), elements.shapes.per_node
    values, directions = _squares(elements.arch, elements.arch)
    kept = np.abs(values) > _NO_SLOPE * np.abs(values).max(axis=1, keepdims=True)
    to_neutral = elements.to_neutral_axis
    stiffness = float(elements.neutral_stiffness[0, 0, 0] * elements.length[0])
    scale = np.sqrt(stiffness * elements.length)
    gradient, slopes, weights = np.zeros((count, size)), [], []
    for number in range(count):
        own = slice(per_node * number, per_node * (number + 2))
        elongation = np.zeros(2 * per_node)
        elongation[[0, per_node]] = -1.0, 1.0
        gradient[number, own] = scale[number] / elements.length[number] * elongation @ to_neutral
        for direction in np.flatnonzero(kept[number]):
            row = np.zeros(size)
            row[own] = directions[number, direction] @ to_neutral
            slopes.append(row)
            weights.append((number, scale[number] * values[number, direction]))
    spread = np.zeros((count, len(slopes)))
    for column, (number, weight) in enumerate(weights):
        spread[number, column] = weight
    axis = sum(elements.shapes.arms(elements.section))
    # Two arms of a symmetric section leave their round-off.
    axis *= abs(axis) > SAME_PLACE * chain.nodes[-1]
    axial = LinkStretch(
        gradient,
        np.stack(slopes),
        spread,
        np.full(count, elements.section.damping.axial),
        neutral_axis=float(axis),
    )
    return _with_bending(chain, axial) if turns_far else axial


def _with_bending(chain: Chain, axial: LinkStretch) -> LinkStretch:
    """Strains of a chain with large rotation against its frame.

    Where an element's chord is at the angle beta, its ends turn against it by the difference of
    their sines over ``cos(beta)``, which to second order is less than one by what the chord is
    shorter along the frame. A product is a difference of squares:
    ``4 b u = (b + u)^2 - (b - u)^2``.
    """
    elements, size = chain.elements, chain.model.size
    per_node, to_neutral = elements.shapes.per_node, elements.to_neutral_axis
    gradient, slopes, weights = [], [], []
    for number, length in enumerate(elements.length):
        own = slice(per_node * number, per_node * (number + 2))
        longer = np.zeros(2 * per_node)
        longer[[0, per_node]] = -1.0, 1.0
        stretching = elements.neutral_stiffness[number] @ longer
        bending = elements.neutral_stiffness[number] - np.outer(stretching, longer) / 2
        values, directions = _squares(bending, elements.neutral_stiffness[number])
        rows = np.zeros((1 + 2 * per_node, size))
        rows[0, own] = longer @ to_neutral / length
        rows[1:, own] = directions @ to_neutral
        for bent in np.flatnonzero(values > _NO_BENDING * values.max()):
            root = float(np.sqrt(values[bent]))
            gradient.append(root * rows[1 + bent])
            slopes += [rows[1 + bent] + rows[0], rows[1 + bent] - rows[0]]
            weights.append(root / 2 * np.array([[-1.0, 1.0]]))
    # Of the second order alone is the damping of all bending that of curvature.
    time = np.full(len(gradient), elements.section.damping.bending)
    return replace(
        axial,
        gradient=np.concatenate([axial.gradient, gradient]),
        slopes=np.concatenate([axial.slopes, slopes]),
        weights=scipy.linalg.block_diag(axial.weights, *weights),
        damping_time=np.append(axial.damping_time, time),
    )


def _squares(matrices: FloatArray, alike: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Quadratic forms as sums of weighted squares, whatever the units of the coordinates.

    Parameters
    ----------
    matrices : ndarray, shape (..., n, n)
        Symmetric.
    alike : ndarray, shape (..., n, n)
        Whose diagonal tells how large each coordinate's entries are.

    Returns
    -------
    ndarray, shape (..., n)
        Weights, ascending.
    ndarray, shape (..., n, n)
        A row for each weight, whose product with the coordinates is squared.
    """
    size = np.sqrt(np.abs(np.diagonal(alike, axis1=-2, axis2=-1)))
    size = np.where(size > 0, size, 1.0)
    weights, vectors = np.linalg.eigh(matrices / (size[..., :, None] * size[..., None, :]))
    return weights, np.swapaxes(vectors, -1, -2) * size[..., None, :]
