"""Finite volumes of Fick's law, in the water that has passed each face of their cells.

The saturation of a cell follows from what has come in and gone out of it, so that no water is
lost or made whatever a solver does in time; that is left to SciPy. Water flows from cell to cell
by the difference of their saturations, which do not jump where materials meet, over the
resistances of the two half cells between the centres. Rows are the waves that the saturation
across the width is made of (one row, without sides, in a slab); each loses water through the
sides at a rate of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.materials.moisture.cells import DiffusionMesh, Waves
from flexmech.materials.moisture.history import Ambient, Period
from flexmech.materials.moisture.slab import Faces

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
        Of the relative humidity in the saturation that it leads to.
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
            Of the solver in time, relative.

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
            found = self._solve(period, state, wanted, initial, tolerance)
            passed[inside] = found[np.searchsorted(wanted, times[inside])]
            state = found[-1]
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
        """What the lag of the cells drives through each face upward, and out of each side."""
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
        own = np.zeros(2 * n + 1 if self._has_sides else n + 1)
        own[0], own[n], own[n + 1 :] = 1.0, -1.0, -1.0
        return np.outer(self.waves.mean, own).ravel()

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
