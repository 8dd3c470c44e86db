"""A record beside a model with free parameters: what every kind of record has in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.comparison.fit import Fit, Parameter
from flexmech.analyses.crank_speeds import RAD_S, asked_speeds, in_unit, one_rad_per_s
from flexmech.analyses.damping_ratios import with_damping_times
from flexmech.analyses.options import ComparisonOptions
from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.crank_values import GREATEST
from flexmech.errors import InputError, suggestion
from flexmech.measured_data import MeasuredRecord
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.sections import stiffened_section
from flexmech.validation import check_angle, check_instance, checked_tuple

SPEED_OR_ANGLE = (
    "speed, angle: give one of them: the crank speed at which the record was taken, or the angle "
    "at which the crank was locked"
)


class ComparisonRequest(ComparisonOptions):
    """How a record was taken, and what of the model is fitted to it, checked.

    Parameters as for :class:`flexmech.analyses.options.ComparisonOptions`.

    Raises
    ------
    InputError
        If a value is impossible, or speed and angle are given.

    Examples
    --------
    >>> asked = {"speed": 20.0, "fit": ["damping", "stiffness:coupler"]}
    >>> ComparisonRequest("strain.csv", **asked).fit
    ('damping', 'stiffness:coupler')
    """

    fit: tuple[str, ...] | None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.speed is not None and self.angle is not None:
            raise InputError(SPEED_OR_ANGLE)
        _ = self.crank_speed
        if self.angle is not None:
            check_angle(self.angle, "angle")
        if self.quantity is not None:
            check_instance(self.quantity, str, "quantity", "write the name of a column")
        if self.fit is not None:
            remedy = "it must be a tuple of names, as ('damping',), or ('none',) to fit nothing"
            object.__setattr__(self, "fit", checked_tuple(self.fit, str, "fit", remedy))
            if not self.fit:
                raise InputError(f"fit is empty; {remedy}")

    def of(self, mechanism: Mechanism, record: MeasuredRecord) -> ComparisonRequest:
        """The request with a mechanism's greatest speed for a record over time that says none."""
        if self.speed is not None or self.angle is not None:
            return self
        if record.abscissa != "time":
            raise InputError(SPEED_OR_ANGLE)
        speeds, unit = asked_speeds(None, self.speed_unit, mechanism, GREATEST)
        return replace(self, speed=float(in_unit(speeds, unit)[0]), speed_unit=unit)

    @cached_property
    def crank_speed(self) -> float | None:
        """Crank speed in rad/s."""
        speed = self.speed
        return None if speed is None else one_rad_per_s(speed, self.speed_unit, "speed")


DAMPING, STIFFNESS, OFFSET, GAIN, NOTHING = "damping", "stiffness", "offset", "gain", "none"
# Crank angle of a record's first sample, where the record does not tell it.
START_ANGLE = "start_angle"
# What a computed record is linear in, and the factor where it is not fitted.
LINEAR = {GAIN: 1.0, OFFSET: 0.0}
# Damping ratio of the first mode that the unit of a fitted damping time stands for.
USUAL_RATIO = 0.005
# Damping ratios from which the fit may begin, of steel to polymers.
RATIOS = (0.001, 0.003, 0.01, 0.03)
# Crank angles at which a record may begin: every 2.5 deg, a fraction of the first mode's period.
_ANGLES = 144
# Part of the model's stiffness below which no measured link is.
_LEAST_STIFFNESS = 0.05
# Usual changes, which scale the fit's steps: of a stiffness or a gain, and of an angle in deg.
_STIFFNESS_STEP, _GAIN_STEP, _ANGLE_STEP = 0.1, 0.1, 10.0


def fitted_names(names: Sequence[str], links: Sequence[str]) -> tuple[str, ...]:
    """Read what is asked to be fitted.

    Parameters
    ----------
    names : sequence of str
        Such as ``("damping", "damping:coupler", "stiffness:coupler")``. ``damping`` is one
        Kelvin-Voigt time of all links that have none of their own here, ``offset`` the gauge's
        zero, ``gain`` a factor on the computed record.
    links : sequence of str
        Names of the linkage's links.

    Returns
    -------
    tuple of str
        In the order of the parameters; empty for ``("none",)``.

    Raises
    ------
    InputError
        If a name is unknown or stands twice, or ``none`` stands beside others.
    """
    own = [f"{what}:{link}" for what in (DAMPING, STIFFNESS) for link in links]
    known = [DAMPING, *own, OFFSET, GAIN, NOTHING]
    for name in names:
        if name not in known:
            raise InputError(f"fit: {name!r} cannot be fitted; {suggestion(name, known)}")
        if names.count(name) > 1:
            raise InputError(f"fit: {name!r} stands twice; name each once")
    if NOTHING in names and len(names) > 1:
        raise InputError(f"fit: {NOTHING!r} stands beside others; write it alone, or leave it out")
    if DAMPING in names and all(f"{DAMPING}:{link}" in names for link in links):
        raise InputError(
            "fit: every link has a damping time of its own, and none is left for 'damping'; leave "
            "that out, or one of the links"
        )
    return tuple(name for name in known[:-1] if name in names)


def damping_times(links: Sequence[str], values: Mapping[str, float]) -> dict[str, float]:
    """Damping time in s of each link that has one among values by name.

    Parameters
    ----------
    links : sequence of str
        Names of all links.
    values : mapping of str to float

    Returns
    -------
    dict of str to float
    """
    common = dict.fromkeys(links, values[DAMPING]) if DAMPING in values else {}
    return common | {link: values[key] for link in links if (key := f"{DAMPING}:{link}") in values}


def stiffness_factors(values: Mapping[str, float]) -> dict[str, float]:
    """Stiffness factor of each link that has one among values by name."""
    kinds = {name: name.partition(":") for name in values}
    return {link: values[name] for name, (kind, _, link) in kinds.items() if kind == STIFFNESS}


def fitted_engine(engine: Engine, values: Mapping[str, float]) -> Engine:
    """The engine with damping times and stiffness factors of links; it keeps its element.

    Parameters
    ----------
    engine : Engine
    values : mapping of str to float
        By the names of the parameters. A factor is of the axial, bending and shear stiffness
        together, and of all that the layers of a laminate have.

    Returns
    -------
    Engine
    """
    times = damping_times(engine.mechanism.linkage.topology.link_names, values)
    if times:
        engine = with_damping_times(engine.with_(element=engine.element), times)
    factors = stiffness_factors(values)
    if not factors:
        return engine
    mechanism = engine.mechanism
    sections = {
        name: stiffened_section(section, factors[name]) if name in factors else section
        for name, section in mechanism.sections.items()
    }
    return engine.with_(mechanism=replace(mechanism, sections=sections), element=engine.element)


# Where less than the other part of a record is explained, another gain or sign is tried.
LITTLE_EXPLAINED = 0.5
CURVES = ("measured", "computed", "residual")


@dataclass(frozen=True)
class LinearTerms:
    """Terms of a computed record.

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
        """Part of a curve (N,) that the free motions cannot follow."""
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
            Names of the factors that are free.
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
        # Terms of like size, so that their units do not decide which ones can be separated.
        size = np.maximum(np.linalg.norm(matrix, axis=0), np.finfo(float).tiny)
        solution = np.linalg.lstsq(matrix / size, wanted, rcond=None)[0] / size
        return dict(zip(names, solution.tolist(), strict=True))


@dataclass(frozen=True, kw_only=True)
class RecordProblem(ABC):
    """The residual of a record by the free parameters of a model.

    Parameters
    ----------
    engine : Engine
        Engine of the mechanism as its model says.
    record : ndarray, shape (N,)
        Real, or complex for a frequency-response function.
    names : tuple of str
        Names of what is fitted.
    column : str
        Column of the record.
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
    """Abscissa of the record."""

    @abstractmethod
    def linear_terms(self, values: Mapping[str, float]) -> LinearTerms:
        """Terms of the computed record, for values by name but gain and offset."""

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
        """Fitted parameters, from the best of the crank angles and damping times tried."""
        unit_time, size = self.unit_time, float(np.std(self.record))
        kinds = {
            DAMPING: Parameter("", "s", unit_time, unit_time),
            STIFFNESS: Parameter("", "", 1.0, _STIFFNESS_STEP, _LEAST_STIFFNESS),
            OFFSET: Parameter("", self.unit, LINEAR[OFFSET], size, linear=True),
            GAIN: Parameter("", "", LINEAR[GAIN], _GAIN_STEP, linear=True),
            START_ANGLE: Parameter("", "deg", 0.0, _ANGLE_STEP),
        }
        trials = {
            START_ANGLE: (360 / _ANGLES * np.arange(_ANGLES)).tolist(),
            DAMPING: [unit_time * ratio / USUAL_RATIO for ratio in self.damping_ratios],
        }
        names = self.parameter_names
        found = {name: replace(kinds[name.partition(":")[0]], name=name) for name in names}
        for kind, choices in trials.items():
            if which := [name for name in names if name.startswith(kind)]:
                start = {name: parameter.start for name, parameter in found.items()}
                misfits = [self.misfit(start | dict.fromkeys(which, values)) for values in choices]
                best = choices[int(np.argmin(misfits))]
                found |= {name: replace(found[name], start=best) for name in which}
        return tuple(found.values())

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
        nearest = terms.nearest(names, values, self.record) if names else {}
        return {**values, **nearest}, terms


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
            values,
            {"units": problem.unit or "1", "long_name": f"{name}{ending}".replace("_", " ")},
        )
        for name, curve in zip(CURVES, curves, strict=True)
        for ending, values in zip(endings, curve, strict=True)
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
        Quantity asked for, as messages name it.
    option : {"speed", "angle"}
    unit : str
        Unit of both, for messages.

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
