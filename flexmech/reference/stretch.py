"""Second-order stretch of a chain of beam elements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.beams.elements import BeamElements
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
    elements, to_neutral = chain.elements, chain.elements.to_neutral_axis
    values, directions = _squares(elements.arch, elements.arch)
    kept = np.abs(values) > _NO_SLOPE * np.abs(values).max(axis=1, keepdims=True)
    stiffness = float(elements.neutral_stiffness[0, 0, 0] * elements.length[0])
    scale = np.sqrt(stiffness * elements.length)
    number = np.nonzero(kept)[0]
    weights = np.zeros((len(kept), len(number)))
    weights[number, np.arange(len(number))] = (scale[:, None] * values)[kept]
    axis = sum(elements.shapes.arms(elements.section))
    # Two arms of a symmetric section leave their round-off.
    axis *= abs(axis) > SAME_PLACE * chain.nodes[-1]
    axial = LinkStretch(
        scale[:, None] * _elongations(elements),
        _of_link(directions @ to_neutral)[kept],
        weights,
        np.full(len(kept), elements.section.damping.axial),
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
    elements, longer = chain.elements, _longer(chain.elements)
    stretching = elements.neutral_stiffness @ longer
    bending = elements.neutral_stiffness - stretching[..., None] * longer / 2
    values, directions = _squares(bending, elements.neutral_stiffness)
    kept = values > _NO_BENDING * values.max(axis=1, keepdims=True)
    root = np.sqrt(values[kept])[:, None]
    bent = _of_link(directions @ elements.to_neutral_axis)[kept]
    stretched = _elongations(elements)[np.nonzero(kept)[0]]
    slopes = np.stack([bent + stretched, bent - stretched], axis=1)
    # Of the second order alone is the damping of all bending that of curvature.
    time = np.full(len(root), elements.section.damping.bending)
    return replace(
        axial,
        gradient=np.concatenate([axial.gradient, root * bent]),
        slopes=np.concatenate([axial.slopes, slopes.reshape(-1, bent.shape[1])]),
        weights=scipy.linalg.block_diag(axial.weights, np.kron(np.diag(root[:, 0]), [-0.5, 0.5])),
        damping_time=np.append(axial.damping_time, time),
    )


def _longer(elements: BeamElements) -> FloatArray:
    """Elongation of an element by its nodes' coordinates, (2 p,)."""
    longer = np.zeros(2 * elements.shapes.per_node)
    longer[[0, elements.shapes.per_node]] = -1.0, 1.0
    return longer


def _elongations(elements: BeamElements) -> FloatArray:
    """Strain of each element by its nodes' displacements along the link, (e, n)."""
    strain = _longer(elements) @ elements.to_neutral_axis / elements.length[:, None]
    return _of_link(strain[:, None])[:, 0]


def _of_link(rows: FloatArray) -> FloatArray:
    """Rows (e, k, 2 p) by the coordinates of elements as rows (e, k, n) by those of the link."""
    count, kinds, both = rows.shape
    total = np.zeros((count, kinds, both // 2 * (count + 1)))
    for number in range(count):
        first = both // 2 * number
        total[number, :, first : first + both] = rows[number]
    return total


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
