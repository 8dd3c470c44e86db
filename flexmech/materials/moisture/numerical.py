"""Diffusion through layers in changing ambient conditions, by finite volumes and SciPy's BDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.materials.moisture.cells import DiffusionLayer, Waves, graded, layer_mesh, side_waves
from flexmech.materials.moisture.fluxes import Fluxes
from flexmech.materials.moisture.history import Ambient
from flexmech.materials.moisture.slab import Faces, checked_faces
from flexmech.validation import POSITIVE, check_number


@dataclass(frozen=True, eq=False)
class MoistureHistory:
    """How water has spread through a part.

    Parameters
    ----------
    time : ndarray, shape (t,)
        In s.
    boundaries : ndarray, shape (n + 1,)
        Of the cells through the thickness from the mid-plane in m.
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
        Of the relative humidity in the saturation that it leads to.
    cells : int
        Through the thickness; the error falls with their square.
    tolerance : float
        Of SciPy's solver in time, relative.

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
        Of the relative humidity in the saturation that it leads to.
    cells : tuple of int
        Through the thickness and across the width, the latter even.
    tolerance : float
        Of SciPy's solver in time, relative.

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
