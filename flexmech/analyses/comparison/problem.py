"""A record beside a model with free parameters: what every kind of record has in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.comparison.fit import Fit, Parameter
from flexmech.analyses.comparison.parameters import (
    LINEAR,
    RATIOS,
    USUAL_RATIO,
    free_parameters,
)
from flexmech.analyses.comparison.request import ComparisonRequest
from flexmech.analyses.crank_speeds import RAD_S
from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.measured_data import MeasuredRecord

# Where less than the other part of a record is explained, another gain or sign is tried.
LITTLE_EXPLAINED = 0.5
CURVES = ("measured", "computed", "residual")


@dataclass(frozen=True)
class LinearTerms:
    """What a computed record is a sum of.

    Parameters
    ----------
    terms : mapping of str to ndarray, shape (N,)
        By the names of the factors that they are multiplied by: the gain and the offset.
    free : ndarray, shape (N, k), optional
        Orthonormal motions whose factors are those nearest to the record.
    """

    terms: Mapping[str, FloatArray | ComplexArray]
    free: FloatArray | None = None

    def bound(self, values: FloatArray | ComplexArray) -> FloatArray | ComplexArray:
        """What of a curve (N,) the free motions cannot follow."""
        return values if self.free is None else values - self.free @ (self.free.T @ values)

    def curve(
        self, factors: Mapping[str, float], record: FloatArray | ComplexArray
    ) -> FloatArray | ComplexArray:
        """Sum of the terms for factors by name, with the free motions nearest to a record (N,).

        A factor without a value is its usual one.
        """
        total = sum(
            factors.get(name, LINEAR[name]) * np.asarray(term) for name, term in self.terms.items()
        )
        return record - self.bound(np.asarray(record - total))

    def nearest(
        self,
        names: Sequence[str],
        factors: Mapping[str, float],
        record: FloatArray | ComplexArray,
    ) -> dict[str, float]:
        """Factors at which the sum is nearest to a record, by least squares.

        Parameters
        ----------
        names : sequence of str
            Of the factors that are free.
        factors : mapping of str to float
            The others.
        record : ndarray, shape (N,)

        Returns
        -------
        dict of str to float
        """
        rest = dict(factors) | dict.fromkeys(names, 0.0)
        wanted = _parts(self.bound(record - self.curve(rest, record))).ravel()
        columns = [_parts(self.bound(self.terms[name])).ravel() for name in names]
        matrix = np.stack(columns, axis=1)
        # Terms of like size, so that their units do not decide which ones are told apart.
        size = np.maximum(np.linalg.norm(matrix, axis=0), np.finfo(float).tiny)
        solution = np.linalg.lstsq(matrix / size, wanted, rcond=None)[0] / size
        return dict(zip(names, solution.tolist(), strict=True))


@dataclass(frozen=True, kw_only=True)
class RecordProblem(ABC):
    """The residual of a record by the free parameters of a model.

    Parameters
    ----------
    engine : Engine
        Of the mechanism as its model says.
    record : ndarray, shape (N,)
        Real, or complex for a frequency-response function.
    names : tuple of str
        Of what is fitted.
    column : str
        Of the record.
    unit : str
        SI unit of the record; empty for a ratio.
    quantity : str
        What is computed, in words or by its column.
    """

    engine: Engine
    record: FloatArray | ComplexArray
    names: tuple[str, ...]
    column: str = ""
    unit: str = ""
    quantity: str = ""

    dimension: ClassVar[str]
    """What the record is written over."""

    @abstractmethod
    def linear_terms(self, values: Mapping[str, float]) -> LinearTerms:
        """What the computed record is a sum of, for values by name but gain and offset."""

    def curve(self, values: Mapping[str, float]) -> FloatArray | ComplexArray:
        """Computed record (N,) for values by name, nearest to the measured one."""
        return self.linear_terms(values).curve(values, self.record)

    @abstractmethod
    def labelled(self, dataset: xr.Dataset, fit: Fit) -> xr.Dataset:
        """The dataset with the coordinates of the record, and what else is known of its kind."""

    @property
    def first_frequency(self) -> float:
        """First natural frequency in rad/s, by which damping times become ratios; NaN: none do."""
        return float("nan")

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links."""
        return self.engine.mechanism.linkage.topology.link_names

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of all free parameters."""
        return self.names

    @property
    def unit_time(self) -> float:
        """Kelvin-Voigt time in s that damps the first mode by the usual ratio."""
        return 2 * USUAL_RATIO / self.first_frequency

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is fitted, and from where."""
        size = float(np.std(self.record))
        names, ratios = self.parameter_names, self.damping_ratios
        return free_parameters(names, self.misfit, self.unit_time, self.unit, size, ratios)

    @property
    def damping_ratios(self) -> tuple[float, ...]:
        """Damping ratios of the first mode from which the fit may begin."""
        return RATIOS

    @property
    def linear_unknowns(self) -> int:
        """None: the model has no unknown state."""
        return 0

    @property
    def measured(self) -> FloatArray:
        """Record, (1, N), or its real and imaginary part, (2, N)."""
        return _parts(self.record)

    def computed(self, values: Sequence[float]) -> FloatArray:
        """Computed record in the form of the measured one, for values of the parameters."""
        return _parts(self.curve(self.by_name(values)))

    def by_name(self, values: Sequence[float]) -> dict[str, float]:
        """Values of the parameters by their names."""
        return dict(zip(self.parameter_names, values, strict=True))

    def with_linear(self, values: Sequence[float]) -> list[float]:
        """Values of the parameters with the gain and the offset nearest to the record."""
        return list(self._solved(self.by_name(values))[0].values())

    def misfit(self, values: Mapping[str, float]) -> float:
        """Least sum of squares of the residual for values by name, by what gain and offset fit."""
        solved, terms = self._solved(values)
        return float(np.sum(np.abs(self.record - terms.curve(solved, self.record)) ** 2))

    def _solved(self, values: Mapping[str, float]) -> tuple[dict[str, float], LinearTerms]:
        """Values with the gain and the offset fitted, and the terms that they are factors of."""
        terms = self.linear_terms(values)
        names = [name for name in self.parameter_names if name in LINEAR]
        found = terms.nearest(names, values, self.record) if names else {}
        return {**values, **found}, terms


def comparison_dataset(
    problem: RecordProblem, record: MeasuredRecord, request: ComparisonRequest, fit: Fit
) -> xr.Dataset:
    """Label measured and computed curves, and the fit.

    Parameters
    ----------
    problem : RecordProblem
    record : MeasuredRecord
    request : ComparisonRequest
    fit : Fit

    Returns
    -------
    xarray.Dataset
    """
    # NetCDF has no complex numbers.
    endings = ("_real", "_imag") if len(fit.computed) > 1 else ("",)
    curves = (problem.measured, fit.computed, problem.measured - fit.computed)
    variables: dict[str, Any] = {
        f"{name}{ending}": (
            problem.dimension,
            part,
            {"units": problem.unit or "1", "long_name": f"{name}{ending}".replace("_", " ")},
        )
        for name, curve in zip(CURVES, curves, strict=True)
        for ending, part in zip(endings, curve, strict=True)
    }
    for name in ("values", "standard_error", "lower", "upper"):
        variables["fitted" if name == "values" else name] = ("parameter", getattr(fit, name))
    variables["correlation"] = (("parameter", "with_parameter"), fit.correlation)
    names = np.array([parameter.name for parameter in fit.parameters], dtype=str)
    units = np.array([parameter.unit or "1" for parameter in fit.parameters], dtype=str)
    dataset = xr.Dataset(
        variables,
        {"parameter": names, "with_parameter": names, "parameter_unit": ("parameter", units)},
    )
    where = (
        {"crank_angle_locked": request.angle}
        if request.crank_speed is None
        else {"crank_speed": request.crank_speed}
    )
    dataset = dataset.assign_attrs(
        abscissa=record.abscissa,
        record=Path(record.source).name.encode(errors="backslashreplace").decode(),
        column=problem.column,
        quantity=problem.quantity,
        unit=problem.unit,
        engine=problem.engine.name,
        element=problem.engine.element,
        speed_unit=request.speed_unit or RAD_S,
        unexplained=fit.unexplained,
        residual_order=fit.order,
        widened=fit.widened,
        first_frequency=problem.first_frequency / (2 * np.pi),
        **where,
    )
    return problem.labelled(dataset, fit)


def rows_taken_at(
    record: MeasuredRecord,
    near: NDArray[np.bool_],
    own: FloatArray,
    asked: float,
    option: str,
    unit: str,
) -> IntArray:
    """Rows of a record that were taken where the request says.

    Parameters
    ----------
    record : MeasuredRecord
    near : ndarray of bool, shape (N,)
        Which rows were.
    own : ndarray, shape (N,)
        Where each row was taken, as messages name it.
    asked : float
        Of the request, as messages name it.
    option : {"speed", "angle"}
    unit : str
        Of both, for messages.

    Returns
    -------
    ndarray of int

    Raises
    ------
    InputError
        If there is none.
    """
    rows = np.flatnonzero(near)
    if not len(rows):
        known = ", ".join(f"{value:g}" for value in np.unique(own)[:10])
        raise InputError(
            f"{record.source}: was taken at crank {option}s of {known} {unit}, not {asked:g}; "
            f"give one of these with --{option}"
        )
    return rows


def _parts(values: FloatArray | ComplexArray) -> FloatArray:
    if np.iscomplexobj(values):
        return np.stack([values.real, values.imag])
    return np.asarray(values, dtype=float)[None]
