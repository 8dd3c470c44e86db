"""Free edges of a narrow link of plies at different angles.

Plies at angles against the link's axis shear and contract each in its own way as they are
stretched. Inside a wide laminate they restrain each other: of all plies together, no force acts
across and no shear. At the edges of its width each ply is free, and the stress between plies that
brings one state into the other acts within about the thickness of equal plies (Pipes & Pagano,
*J. Composite Materials* 4 (1970) 538). A link as wide as thick is mostly edge: its bending
stiffness is well below that of classical laminate theory.

Between the two, plies that restrain each other and plies that are free, the cross-section in three
dimensions tells the stiffness (:mod:`flexmech.sections.solid_section`). ``R`` of the strains
along the link, mid-plane strain and gradient, belongs to free plies such that it comes out::

    K = K_joined (1 - R) + K_free R

Plies along and across the link alone, and one angle alone, need none of it. What a torque along
the link adds where it takes the twist of bending back comes from the same section.

A laminate with plies off the link's axis twists as it bends (``D16``). Where pins along the joint
axes restrain both ends, the ends cannot turn about the link's axis: a torque along the whole link,
the same everywhere, takes the twist back on the average. It adds the energy
``c^2 GJ (phi_2 - phi_1)^2 / (2 L)``, with c the twist that a unit of curvature brings, GJ the
torsional stiffness and phi the rotations of the ends. A half sine, the first mode between pins,
meets ``8 / pi^2`` of ``c^2 GJ``; the second mode, which turns both ends alike, nothing.

c and GJ are those of the cross-section in three dimensions: the shear stress of torsion turns
round at the edges of the width, within a layer of about the thickness. A link as wide as thick
has little of the plate's torsional stiffness, a wide one all.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import scipy.linalg

from flexmech.arrays import ROUND_OFF, FloatArray, IntArray
from flexmech.materials import Laminate, solid_stiffness
from flexmech.sections.beam_reduction import ALONG, OTHERS, UNTWISTED, layer_powers
from flexmech.sections.solid_section import (
    CURVATURE,
    STRETCH,
    TWIST,
    SolidSection,
    lines_of_rows,
    solid_section,
)

Twist = Literal["free", "held"]
TWISTS: tuple[Twist, ...] = get_args(Twist)

FIRST_MODE = 8 / np.pi**2
"""Share of the twist's energy that a half sine between two joints meets."""

# Strains x, z and xz among those of a solid.
IN_PLANE = np.array([0, 2, 4])
# Elements along the width, narrow towards the edges: twice as many change the bending stiffness of
# angle plies by 4e-5 at most, over all widths.
COLUMNS = 12
# Rows of elements in each run of equal plies, where so many runs are few; and through the whole
# thickness at least. Twice as many change the bending stiffness by 6e-4 where a link is as wide as
# thick, and by 1e-3 where it is half as wide.
ROWS, FEW_RUNS, ROWS_IN_ALL = 2, 8, 8
# Widths over the thickness that are computed. In wider links the edges stay as they are; of
# narrower ones every ply is free.
NARROWEST, WIDEST = 0.01, 12.0
# Layers at one angle that differ less belong to one run: the slices of a moist ply, whose resin
# softens by less from one to the next; plies of other fibres differ by more.
ALIKE = 0.2
# Part of the joined plies' stiffness that free ones lack, below which both are the same. Rounding
# leaves 2e-14 for equal plies, and a millionth changes no frequency that is printed.
NEGLIGIBLE = 1e-6


def is_off_axis(laminate: Laminate) -> bool:
    """Whether a ply is neither along nor across the link.

    Parameters
    ----------
    laminate : Laminate

    Returns
    -------
    bool
    """
    turned = [layer for layer in laminate.layers if abs(np.sin(2 * layer.angle)) > ROUND_OFF]
    plies = np.reshape([layer.transformed_stiffness for layer in turned], (-1, 3, 3))
    sheared = np.abs(plies[:, 0, 2]) + np.abs(plies[:, 1, 2])
    return bool(np.any(sheared > ROUND_OFF * (plies[:, 0, 0] + plies[:, 1, 1])))


def free_edges(laminate: Laminate, width: float) -> tuple[FloatArray, float]:
    """Find what the free edges of a section do whose plies are at angles against the link.

    Parameters
    ----------
    laminate : Laminate
    width : float
        In m.

    Returns
    -------
    relaxation : ndarray, shape (2, 2)
        R by mid-plane strain and its gradient in y; zero where all plies are along or across the
        link.
    torsion : float
        What a torque that takes the twist back adds to the bending stiffness, of what no twist
        at all adds: from 0, also where bending does not twist, to 1.

    Raises
    ------
    ComputationError
        If the cross-section cannot be solved.
    """
    if not is_off_axis(laminate):
        return np.zeros((2, 2)), 0.0
    ratio = width / laminate.thickness
    relaxation, torsion = _free_edges(laminate, float(np.clip(ratio, NARROWEST, WIDEST)))
    rest = min(1.0, WIDEST / ratio)
    return rest * relaxation, 1 - rest * (1 - torsion) if torsion else 0.0


@lru_cache(maxsize=256)
def _free_edges(laminate: Laminate, ratio: float) -> tuple[FloatArray, float]:
    """Free edges of a laminate whose width over the thickness is given."""
    faces, solids = layer_runs(laminate)
    width = ratio * laminate.thickness
    edges = _meshed(faces, solids, width)
    # From the curvature to the gradient of the strain.
    signs = np.array([[1.0, -1.0], [-1.0, 1.0]]) / width
    free = signs * edges.stiffness_of([STRETCH, CURVATURE])
    untwisted = signs * edges.stiffness_of([STRETCH, CURVATURE, TWIST])[:2, :2]
    plate = _plate(faces, _plane_stress(solids))
    bending, resisted, none = (
        _about_neutral_axis(m) for m in (free, untwisted, _by_strains_along(plate, UNTWISTED))
    )
    twists = resisted > bending and none > bending
    torsion = min(1.0, (resisted - bending) / (none - bending)) if twists else 0.0
    lacking = _by_strains_along(plate, OTHERS) - free
    return _relaxation(laminate, lacking), torsion


def laminate_solid(laminate: Laminate, width: float) -> SolidSection:
    """Cross-section of a laminate in three dimensions.

    Parameters
    ----------
    laminate : Laminate
    width : float
        In m.

    Returns
    -------
    SolidSection

    Raises
    ------
    ComputationError
        If the cross-section cannot be solved.
    """
    return _meshed(*layer_runs(laminate), width)


def _meshed(faces: FloatArray, solids: FloatArray, width: float) -> SolidSection:
    """Section of runs (n) between faces (n + 1,)."""
    least = ROWS if len(solids) <= FEW_RUNS else 1
    shares = np.diff(faces) / (faces[-1] - faces[0])
    rows = np.maximum(least, np.ceil(ROWS_IN_ALL * shares * (1 - NEGLIGIBLE)).astype(int))
    sides = width / 2 * np.sin(np.pi / 2 * np.linspace(-1, 1, COLUMNS + 1))
    return solid_section(lines_of_rows(faces, rows), np.repeat(solids, rows, axis=0), sides)


def _about_neutral_axis(stiffness: FloatArray) -> float:
    return float(stiffness[1, 1] - stiffness[0, 1] ** 2 / stiffness[0, 0])


def layer_runs(laminate: Laminate) -> tuple[FloatArray, FloatArray]:
    """Runs of like layers.

    Parameters
    ----------
    laminate : Laminate

    Returns
    -------
    faces : ndarray, shape (n + 1,)
        In m.
    stiffness : ndarray, shape (n, 6, 6)
        By strains x, y, z, yz, xz and xy in Pa.
    """
    stiffness = np.stack([solid_stiffness(layer) for layer in laminate.layers])
    angles = np.array([layer.angle for layer in laminate.layers])
    change = np.abs(np.diff(stiffness, axis=0)).max(axis=(1, 2), initial=0.0)
    size = np.abs(stiffness).max(axis=(1, 2))
    differ = (change > ALIKE * np.minimum(size[1:], size[:-1])) | (np.diff(angles) != 0)
    starts = np.concatenate([[0], 1 + np.flatnonzero(differ)])
    faces = laminate.boundaries
    sums = np.add.reduceat(np.diff(faces)[:, None, None] * stiffness, starts)
    faces = faces[[*starts, len(stiffness)]]
    return faces, sums / np.diff(faces)[:, None, None]


def _plane_stress(solids: FloatArray) -> FloatArray:
    """Stiffness (n, 3, 3) by strains x, z and xz where nothing presses through the thickness."""
    planes = solids[:, IN_PLANE[:, None], IN_PLANE]
    through = solids[:, IN_PLANE, 1, None]
    return np.asarray(planes - through @ np.swapaxes(through, 1, 2) / solids[:, 1, 1, None, None])


def _plate(faces: FloatArray, planes: FloatArray) -> FloatArray:
    """By strains x, z and xz at the mid-plane and their gradients in y, (6, 6)."""
    moments = np.einsum("kn,nij->kij", layer_powers(faces), planes)
    return np.block([[moments[0], moments[1]], [moments[1], moments[2]]])


def _by_strains_along(plate: FloatArray, others: IntArray) -> FloatArray:
    """Stiffness (2, 2) along the link where some other strains are free."""
    coupling = plate[np.ix_(others, ALONG)]
    moved = np.linalg.solve(plate[np.ix_(others, others)], coupling)
    return np.asarray(plate[np.ix_(ALONG, ALONG)] - coupling.T @ moved)


def _relaxation(laminate: Laminate, lacking: FloatArray) -> FloatArray:
    """R (2, 2) with which joined plies lack so much stiffness (2, 2) for each metre of width."""
    joined = _by_strains_along(laminate.plate_stiffness, OTHERS)
    alone = 1 / np.linalg.inv(laminate.transformed_stiffness)[:, 0, 0]
    sums = layer_powers(laminate.boundaries) @ alone
    most, vectors = scipy.linalg.eigh(joined - sums[[[0, 1], [1, 2]]], joined)
    matters = most > NEGLIGIBLE
    vectors = vectors[:, matters]
    parts = vectors.T @ lacking @ vectors / most[matters, None]
    return np.asarray(vectors @ parts @ vectors.T @ joined)
