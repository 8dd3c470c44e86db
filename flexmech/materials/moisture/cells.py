"""Cells of layers that water diffuses through, fine where it moves first; waves across a bar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.materials.moisture.diffusivity import Diffusivity
from flexmech.materials.moisture.slab import Faces
from flexmech.validation import POSITIVE, check_fields

# Of a layer: both faces are fine, and a parabola between them needs two cells each side.
FEWEST_CELLS = 4
# Cells at a fine end are cosh(2)^2 = 14 times smaller than in the middle: with more, the error in
# the middle grows faster than that of the first instants falls.
GRADING = 2.0


@dataclass(frozen=True)
class DiffusionLayer:
    """A layer that takes up water.

    Parameters
    ----------
    thickness : float
        In m.
    diffusivity : Diffusivity
        Through the thickness.
    capacity : float
        Water in equilibrium with a relative humidity of 100 % in kg per m^3 of the layer.
    diffusivity_across : Diffusivity, optional
        Along the width; only a bar whose sides are exposed needs it.

    Raises
    ------
    InputError
        If the thickness or the capacity is not positive.
    """

    thickness: float
    diffusivity: Diffusivity
    capacity: float
    diffusivity_across: Diffusivity | None = None

    def __post_init__(self) -> None:
        numbers = {"thickness": "m", "capacity": "kg/m^3"}
        check_fields(self, numbers, POSITIVE, "of a layer that takes up water")

    def same_material(self, other: DiffusionLayer) -> bool:
        """Whether water moves in another layer as it does in this one."""
        return replace(self, thickness=other.thickness) == other


@dataclass(frozen=True, eq=False)
class DiffusionMesh:
    """Cells through the thickness.

    Parameters
    ----------
    materials : tuple of DiffusionLayer
        Neighbours of one material made one.
    boundaries : ndarray, shape (n + 1,)
        Of the cells from the mid-plane in m.
    material : ndarray of int, shape (n,)
        Which of the materials each cell is of.
    """

    materials: tuple[DiffusionLayer, ...]
    boundaries: FloatArray
    material: IntArray

    @cached_property
    def sizes(self) -> FloatArray:
        """Of the cells in m, (n,)."""
        return np.diff(self.boundaries)

    @property
    def centres(self) -> FloatArray:
        """Of the cells in m, (n,)."""
        return np.asarray((self.boundaries[1:] + self.boundaries[:-1]) / 2)

    @cached_property
    def capacity(self) -> FloatArray:
        """Water in each cell at 100 % relative humidity in kg/m^2, (n,)."""
        capacities = np.array([layer.capacity for layer in self.materials])
        return np.asarray(capacities[self.material] * self.sizes)


def layer_mesh(layers: Sequence[DiffusionLayer], faces: Faces, cells: int) -> DiffusionMesh:
    """Cells for layers, lowest first: finest at exposed faces and where materials meet.

    Parameters
    ----------
    layers : sequence of DiffusionLayer
    faces : {"both", "lower", "upper"}
        Those exposed.
    cells : int
        Through the whole thickness; each material gets a part, by the time that the water
        takes through it (thickness over the root of the diffusivity).

    Returns
    -------
    DiffusionMesh

    Raises
    ------
    InputError
        If there is no layer or too few cells.
    """
    materials = _merged(layers)
    least = FEWEST_CELLS * len(materials)
    if cells < least:
        raise InputError(
            f"{len(materials)} different layers need {least} cells or more, got {cells}"
        )
    resistance = np.array([m.thickness / np.sqrt(m.diffusivity.value) for m in materials])
    spare = cells - least
    counts = FEWEST_CELLS + np.round(spare * resistance / resistance.sum()).astype(int)
    last = len(materials) - 1
    pieces, start = [np.zeros(1)], 0.0
    for i, (material, count) in enumerate(zip(materials, counts, strict=True)):
        fine = (i > 0 or faces != "upper", i < last or faces != "lower")
        pieces.append(start + material.thickness * graded(int(count), fine)[1:])
        start = float(pieces[-1][-1])
    boundaries = np.concatenate(pieces)
    return DiffusionMesh(
        materials, boundaries - boundaries[-1] / 2, np.repeat(np.arange(last + 1), counts)
    )


def graded(cells: int, fine: tuple[bool, bool]) -> FloatArray:
    """Boundaries of cells from 0 to 1 that shrink smoothly towards the ends that are fine.

    A smooth map of equal cells keeps the second order of finite volumes on them.

    Parameters
    ----------
    cells : int
    fine : tuple of bool
        At 0, at 1.

    Returns
    -------
    ndarray, shape (cells + 1,)
    """
    # The map is a hyperbolic tangent; where one end is sealed, one half of it.
    start, stop = (-1.0 if fine[0] else 0.0), (1.0 if fine[1] else 0.0)
    if start == stop:
        return np.linspace(0.0, 1.0, cells + 1)
    y = np.tanh(GRADING * np.linspace(start, stop, cells + 1)) / np.tanh(GRADING)
    return np.asarray((y - start) / (stop - start))


def _merged(layers: Sequence[DiffusionLayer]) -> tuple[DiffusionLayer, ...]:
    if not layers:
        raise InputError("diffusion needs one layer or more, got none")
    merged = [layers[0]]
    for layer in layers[1:]:
        below = merged[-1]
        if below.same_material(layer):
            merged[-1] = replace(below, thickness=below.thickness + layer.thickness)
        else:
            merged.append(layer)
    return tuple(merged)


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves across the width of a bar whose sides are in the same ambient conditions.

    Parameters
    ----------
    rate : ndarray, shape (m,)
        Decay over the diffusivity across the width in 1/m^2; 0 for a slab.
    mean : ndarray, shape (m,)
        Mean of each wave over the width; also the part of a uniform saturation in it.
    shape : ndarray, shape (m, k)
        The waves in the cells of half the width, from the middle to the side.
    boundaries : ndarray, shape (k + 1,)
        Of those cells in m, from the middle.
    """

    rate: FloatArray
    mean: FloatArray
    shape: FloatArray
    boundaries: FloatArray

    @classmethod
    def none(cls) -> Waves:
        """Those of a slab: the same all over the width."""
        one = np.ones(1)
        return cls(np.zeros(1), one, one[:, None], np.array([0.0, np.inf]))


def side_waves(boundaries: FloatArray) -> Waves:
    """Waves in half a width whose side is exposed, exact for its finite volumes.

    They are the singular vectors of the differences between cells, which keeps small rates as
    accurate as large ones.

    Parameters
    ----------
    boundaries : ndarray, shape (k + 1,)
        Of the cells in m, from the middle at 0 to the side.

    Returns
    -------
    Waves
    """
    sizes = np.diff(boundaries)
    half = boundaries[-1]
    weights = sizes / half
    # Conductance over the half width from each cell outward, the last one to the side itself.
    outward = 1 / (half * np.append((sizes[1:] + sizes[:-1]) / 2, sizes[-1] / 2))
    cells = sizes.size
    difference = np.diag(np.ones(cells)) - np.diag(np.ones(cells - 1), 1)
    scaled = np.sqrt(outward)[:, None] * difference / np.sqrt(weights)
    _, values, vectors = np.linalg.svd(scaled)
    shape = vectors / np.sqrt(weights)
    return Waves(values**2, shape @ weights, shape, boundaries)
