"""Diffusion through layers in changing ambient conditions, by finite volumes and SciPy's BDF.

Cells are fine where water moves first. Fick's law is written in the water that has passed each face
of a cell. The saturation of a cell follows from what has come in and gone out of it, so that no
water is lost or made whatever a solver does in time; that is left to SciPy. Water flows from cell
to cell by the difference of their saturations, which do not jump where materials meet, over the
resistances of the two half cells between the centres. Rows are the waves that the saturation across
the width is made of (one row, without sides, in a slab); each loses water through the sides at a
rate of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import ComputationError, InputError
from flexmech.materials.moisture.diffusivity import Diffusivity
from flexmech.materials.moisture.history import Ambient, Period
from flexmech.materials.moisture.slab import Faces, checked_faces
from flexmech.validation import POSITIVE, check_fields, check_number

# Fewest cells of a layer: both faces are fine, and a parabola between them needs two cells each
# side.
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
        Boundaries of the cells from the mid-plane in m.
    material : ndarray of int, shape (n,)
        Which of the materials each cell is of.
    """

    materials: tuple[DiffusionLayer, ...]
    boundaries: FloatArray
    material: IntArray

    @cached_property
    def sizes(self) -> FloatArray:
        """Sizes of the cells in m, (n,)."""
        return np.diff(self.boundaries)

    @property
    def centres(self) -> FloatArray:
        """Centres of the cells in m, (n,)."""
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
        Boundaries of those cells in m, from the middle.
    """

    rate: FloatArray
    mean: FloatArray
    shape: FloatArray
    boundaries: FloatArray

    @classmethod
    def none(cls) -> Waves:
        """Waves of a slab: one, which is the same all over the width."""
        one = np.ones(1)
        return cls(np.zeros(1), one, one[:, None], np.array([0.0, np.inf]))


def side_waves(boundaries: FloatArray) -> Waves:
    """Waves in half a width whose side is exposed, exact for its finite volumes.

    They are the singular vectors of the differences between cells, which keeps small rates as
    accurate as large ones.

    Parameters
    ----------
    boundaries : ndarray, shape (k + 1,)
        Boundaries of the cells in m, from the middle at 0 to the side.

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


SparseMatrix = Any  # SciPy's sparse arrays, whose types its stubs parametrize differently

# Absolute over relative tolerance of the water through a face: cells at an exposed face hold
# some thousandth of all, and their saturation is a difference of two faces.
ABSOLUTE = 1e-3


@dataclass(frozen=True, eq=False)
class Fluxes:
    """A mesh of n cells in m waves, and the water through their faces and sides.

    Parameters
    ----------
    mesh : DiffusionMesh
    faces : {"both", "lower", "upper"}
        Those exposed.
    waves : Waves
    humidity_exponent : float
        Humidity exponent of the relative humidity in the saturation that it leads to.
    """

    mesh: DiffusionMesh
    faces: Faces
    waves: Waves
    humidity_exponent: float

    def run(
        self, ambient: Ambient, times: FloatArray, initial: float, tolerance: float
    ) -> tuple[FloatArray, FloatArray]:
        """Saturation and influx at times, from a uniform saturation at time zero.

        Parameters
        ----------
        ambient : Ambient
        times : ndarray, shape (t,)
            Rising, in s, from zero on.
        initial : float
        tolerance : float
            Tolerance of the solver in time, relative.

        Returns
        -------
        saturation : ndarray, shape (t, m, n)
            In the waves.
        influx : ndarray, shape (t,)
            Water through all exposed surfaces in kg per m^2 of the faces.

        Raises
        ------
        ComputationError
            If SciPy's solver fails.
        """
        passed = np.zeros((len(times), self._through.shape[0]))
        state = passed[0]
        for period in ambient.periods(0.0, float(times[-1])):
            inside = (times > period.start) & (times <= period.stop)
            wanted = np.unique(np.append(times[inside], period.stop))
            profiles = self._solve(period, state, wanted, initial, tolerance)
            passed[inside] = profiles[np.searchsorted(wanted, times[inside])]
            state = profiles[-1]
        start = initial * self.waves.mean[:, None] * np.ones(self._cells)
        saturation = start + (passed @ self._content.T).reshape(len(times), *start.shape)
        return saturation, passed @ self._inward

    def _solve(
        self,
        period: Period,
        state: FloatArray,
        wanted: FloatArray,
        initial: float,
        tolerance: float,
    ) -> FloatArray:
        """Water through the faces at times of a period, (t, u)."""
        mean = np.repeat(self.waves.mean, self._cells)
        coupling = self._through @ self._content
        # The solver asks for many rates at one temperature.
        conductance = lru_cache(maxsize=1)(self._conductance)

        def rate(since: float, passed: FloatArray) -> FloatArray:
            humidity, temperature = period.at(period.start + since)
            ahead = humidity**self.humidity_exponent - initial
            lag = ahead * mean - self._content @ passed
            return np.asarray(conductance(temperature) * (self._through @ lag))

        def jacobian(since: float, passed: FloatArray) -> SparseMatrix:
            temperature = period.at(period.start + since)[1]
            scale = scipy.sparse.diags_array(conductance(temperature))
            return scipy.sparse.csc_array(-(scale @ coupling))

        # Time counts from the period's start: late in a long history its digits run short.
        problem = (rate, (0.0, period.stop - period.start), state)
        total = float(self.mesh.capacity.sum())
        options = {"rtol": tolerance, "atol": ABSOLUTE * tolerance * total}
        # Its stubs tell its overloads apart by the right side's type.
        solver: Any = scipy.integrate.solve_ivp
        try:
            with np.errstate(all="ignore"):
                solution = solver(
                    *problem, method="BDF", t_eval=wanted - period.start, jac=jacobian, **options
                )
            failure = "" if solution.success else str(solution.message)
        except (RuntimeError, ValueError, OverflowError) as error:
            failure = str(error)
        if failure or not np.all(np.isfinite(solution.y)):
            raise ComputationError(
                f"diffusion cannot be followed from {period.start:g} to {period.stop:g} s "
                f"({failure or 'overflow'}); check the units of thicknesses, diffusivities and "
                "capacities"
            )
        return np.asarray(solution.y.T)

    @property
    def _cells(self) -> int:
        return len(self.mesh.capacity)

    @cached_property
    def _through(self) -> SparseMatrix:
        """Flow through each face upward and out of each side by the lag of the cells."""
        n = self._cells
        one: Any = np.ones(n)  # SciPy's stubs know lists of numbers alone
        faces = scipy.sparse.diags_array([one, -one], offsets=[0, -1], shape=(n + 1, n))
        sides = -scipy.sparse.eye_array(n)
        return self._in_waves(scipy.sparse.vstack([faces, sides]) if self._has_sides else faces)

    @cached_property
    def _content(self) -> SparseMatrix:
        """Saturation of the cells by the water through their faces and sides."""
        n = self._cells
        share: Any = 1 / self.mesh.capacity
        faces = scipy.sparse.diags_array([share, -share], offsets=[0, 1], shape=(n, n + 1))
        sides = -scipy.sparse.diags_array(share)
        return self._in_waves(scipy.sparse.hstack([faces, sides]) if self._has_sides else faces)

    def _in_waves(self, block: SparseMatrix) -> SparseMatrix:
        return scipy.sparse.csr_array(
            scipy.sparse.block_diag([block] * len(self.waves.mean), format="csr")
        )

    @property
    def _has_sides(self) -> bool:
        return bool(self.waves.rate.any())

    @cached_property
    def _inward(self) -> FloatArray:
        """Weights of what came in through all exposed surfaces, (u,)."""
        n = self._cells
        gradient = np.zeros(2 * n + 1 if self._has_sides else n + 1)
        gradient[0], gradient[n], gradient[n + 1 :] = 1.0, -1.0, -1.0
        return np.outer(self.waves.mean, gradient).ravel()

    def _conductance(self, temperature: float) -> FloatArray:
        """Water per time through each face and side by the difference of saturations, (u,)."""
        mesh, materials = self.mesh, self.mesh.materials
        through = np.array([m.capacity * float(m.diffusivity.at(temperature)) for m in materials])
        half = mesh.sizes / 2 / through[mesh.material]
        faces = np.empty(self._cells + 1)
        faces[1:-1] = 1 / (half[1:] + half[:-1])
        faces[0] = 0.0 if self.faces == "upper" else 1 / half[0]
        faces[-1] = 0.0 if self.faces == "lower" else 1 / half[-1]
        if not self._has_sides:
            return faces
        across = np.array(
            [
                m.capacity * float(m.diffusivity_across.at(temperature))
                for m in materials
                if m.diffusivity_across is not None
            ]
        )
        sides = across[mesh.material] * mesh.sizes
        rows = [np.concatenate([faces, rate * sides]) for rate in self.waves.rate]
        return np.concatenate(rows)


@dataclass(frozen=True, eq=False)
class MoistureHistory:
    """How water has spread through a part.

    Parameters
    ----------
    time : ndarray, shape (t,)
        In s.
    boundaries : ndarray, shape (n + 1,)
        Boundaries of the cells through the thickness from the mid-plane in m.
    saturation : ndarray, shape (t, n)
        Mean over each cell, and over the width in a bar: moisture over that in equilibrium with
        100 % relative humidity. It may leave the range from 0 to 1 by the tolerance.
    capacity : ndarray, shape (n,)
        Water in each cell at 100 % relative humidity in kg per m^2 of the faces.
    influx : ndarray, shape (t,)
        Water that has come in through all exposed surfaces in kg per m^2 of the faces.
    across : ndarray, shape (k + 1,), optional
        Boundaries of the cells across the width of a bar from its middle in m.
    field : ndarray, shape (t, n, k), optional
        Saturation in the cells of a bar.
    """

    time: FloatArray
    boundaries: FloatArray
    saturation: FloatArray
    capacity: FloatArray
    influx: FloatArray
    across: FloatArray | None = None
    field: FloatArray | None = None

    @property
    def place(self) -> FloatArray:
        """Centres of the cells from the mid-plane in m, (n,)."""
        return np.asarray((self.boundaries[1:] + self.boundaries[:-1]) / 2)

    @property
    def water(self) -> FloatArray:
        """Water in the part in kg per m^2 of the faces, (t,)."""
        return np.asarray(self.saturation @ self.capacity)

    @property
    def mass_balance_error(self) -> float:
        """Water that is there and did not come in, largest over time, over the capacity."""
        gained = self.water - self.water[0]
        return float(np.abs(gained - (self.influx - self.influx[0])).max() / self.capacity.sum())

    @property
    def uptake(self) -> FloatArray:
        """Water in the part over that in equilibrium with 100 % relative humidity, (t,)."""
        return np.asarray(self.water / self.capacity.sum())


def diffuse(
    layers: Sequence[DiffusionLayer],
    ambient: Ambient,
    times: ArrayLike,
    *,
    faces: Faces = "both",
    initial: float = 0.0,
    humidity_exponent: float = 1.0,
    cells: int = 1500,
    tolerance: float = 1e-7,
) -> MoistureHistory:
    """Spread of water through the thickness of a plate or wide link: Fick's law in each layer.

    With the defaults the profile in one layer is within 1e-6 of the exact one from the time
    0.01 h^2/D after a step on, and the mean within 1e-6 from the start on.

    Parameters
    ----------
    layers : sequence of DiffusionLayer
        Lowest first.
    ambient : Ambient
        The part has their temperature throughout: heat spreads a million times faster.
    times : array_like, shape (t,)
        At which the result is wanted in s, rising; the exposure begins at time zero.
    faces : {"both", "lower", "upper"}
        Those exposed; the other one is sealed.
    initial : float
        Saturation at time zero.
    humidity_exponent : float
        Humidity exponent of the relative humidity in the saturation that it leads to.
    cells : int
        Through the thickness; the error falls with their square.
    tolerance : float
        Tolerance of SciPy's solver in time, relative.

    Returns
    -------
    MoistureHistory

    Raises
    ------
    InputError
        If there is no layer, times do not rise from zero, the initial saturation is not between
        0 and 1, or an option is outside its range.
    ComputationError
        If SciPy's solver fails.
    """
    wanted = _checked(times, faces, initial, humidity_exponent, tolerance)
    mesh = layer_mesh(layers, faces, cells)
    fluxes = Fluxes(mesh, faces, Waves.none(), humidity_exponent)
    saturation, influx = fluxes.run(ambient, wanted, initial, tolerance)
    return MoistureHistory(wanted, mesh.boundaries, saturation[:, 0], mesh.capacity, influx)


def diffuse_bar(
    layers: Sequence[DiffusionLayer],
    width: float,
    ambient: Ambient,
    times: ArrayLike,
    *,
    faces: Faces = "both",
    initial: float = 0.0,
    humidity_exponent: float = 1.0,
    cells: tuple[int, int] = (120, 64),
    tolerance: float = 1e-6,
) -> MoistureHistory:
    """Spread of water through the cross-section of a narrow link whose sides are exposed too.

    Parameters
    ----------
    layers : sequence of DiffusionLayer
        Lowest first, each with its diffusivity across.
    width : float
        In m.
    ambient : Ambient
        The part has their temperature throughout: heat spreads a million times faster.
    times : array_like, shape (t,)
        At which the result is wanted in s, rising; the exposure begins at time zero.
    faces : {"both", "lower", "upper"}
        Faces exposed, of those at the ends of the thickness; both sides are.
    initial : float
        Saturation at time zero.
    humidity_exponent : float
        Humidity exponent of the relative humidity in the saturation that it leads to.
    cells : tuple of int
        Through the thickness and across the width, the latter even.
    tolerance : float
        Tolerance of SciPy's solver in time, relative.

    Returns
    -------
    MoistureHistory

    Raises
    ------
    InputError
        As :func:`diffuse`, or if the width is not positive, the cells across not even, or a
        layer has no diffusivity across.
    ComputationError
        If SciPy's solver fails.
    """
    wanted = _checked(times, faces, initial, humidity_exponent, tolerance)
    check_number(width, "width", "m", POSITIVE)
    if any(layer.diffusivity_across is None for layer in layers):
        raise InputError("exposed sides need a diffusivity_across of each layer")
    if cells[1] < 4 or cells[1] % 2:
        raise InputError(f"cells across the width must be even, 4 or more; got {cells[1]}")
    mesh = layer_mesh(layers, faces, cells[0])
    half = width / 2 * graded(cells[1] // 2, (False, True))
    waves = side_waves(half)
    fluxes = Fluxes(mesh, faces, waves, humidity_exponent)
    rows, influx = fluxes.run(ambient, wanted, initial, tolerance)
    # The waves put together again, on both halves of the width.
    quarter = np.einsum("tmn,mk->tnk", rows, waves.shape, optimize=True)
    return MoistureHistory(
        wanted,
        mesh.boundaries,
        np.einsum("tmn,m->tn", rows, waves.mean),
        mesh.capacity,
        influx,
        np.concatenate([-half[:0:-1], half]),
        np.concatenate([quarter[:, :, ::-1], quarter], axis=2),
    )


def _checked(
    times: ArrayLike, faces: Faces, initial: float, exponent: float, tolerance: float
) -> FloatArray:
    checked_faces(faces)
    wanted = np.atleast_1d(np.asarray(times, dtype=float))
    if wanted.ndim != 1 or not wanted.size or not np.all(np.isfinite(wanted)):
        raise InputError(f"times must be a row of numbers, one or more; got {wanted}")
    if wanted[0] < 0 or np.any(np.diff(wanted) < 0):
        raise InputError(f"times must rise from zero, where the exposure begins; got {wanted}")
    if not 0 <= initial <= 1:
        raise InputError(f"initial saturation must lie between 0 and 1, got {initial}")
    check_number(exponent, "humidity_exponent", bounds=POSITIVE)
    check_number(tolerance, "tolerance", bounds=POSITIVE)
    return wanted
