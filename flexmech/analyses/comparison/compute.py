"""A measured record beside what is computed, and what of the model is fitted to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.comparison.fit import fitted
from flexmech.analyses.comparison.over_angle import frequency_problem
from flexmech.analyses.comparison.over_frequency import receptance_problem
from flexmech.analyses.comparison.over_time import time_problem
from flexmech.analyses.comparison.problem import (
    CURVES,
    ComparisonRequest,
    RecordProblem,
    comparison_dataset,
    damping_times,
)
from flexmech.analyses.comparison.words import summary_of
from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.datasets import provenance, table_of
from flexmech.analyses.requests import asks, engines_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, left_out_attributes
from flexmech.arrays import silent
from flexmech.errors import InputError, suggestion
from flexmech.measured_data import MeasuredRecord, read_record
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.threads import one_thread

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Units behind the names of columns.
_SUFFIXES = {"m": "_m", "Hz": "_Hz", "m/N": "_m_N", "m/(N s)": "_m_Ns", "m/(N s^2)": "_m_Ns2"}

# Columns of the tables, and their variables: of the places by what a record is over, and of the
# fit.
_PLACES = {
    "time": {"time_s": "time"},
    "frequency": {"frequency_Hz": "frequency"},
    "sample": {"crank_angle_deg": "crank_angle", "mode": "mode"},
}
_FIT = {
    "parameter": "parameter",
    "value": "fitted",
    "unit": "parameter_unit",
    "standard_error": "standard_error",
    "p2_5": "lower",
    "p97_5": "upper",
}


@dataclass(frozen=True)
class FittedValue:
    """A fitted parameter and its 95 % interval.

    Parameters
    ----------
    value : float
    unit : str
        ``"1"`` for a ratio.
    standard_error, lower, upper : float
        In this unit.
    """

    value: float
    unit: str
    standard_error: float
    lower: float
    upper: float


class Comparison(Result):
    """A measured record beside what is computed, and what was fitted to it.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``measured``, ``computed`` and ``residual`` over time, or over sample with its crank angle
        and mode, or their real and imaginary parts over frequency; ``fitted``,
        ``standard_error``, ``lower``, ``upper`` and ``correlation`` over parameter. Over time also
        ``periodic``, the part that the linkage drives by itself, and ``spectrum`` of the curves.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "comparison"
    subject = "comparison with a record"
    hallmark = "standard_error"
    files = ("comparison.csv", "fit.csv", "comparison.nc", "comparison.png")

    @property
    def unexplained(self) -> float:
        """Variance of the residual over that of the record."""
        return float(self.dataset.attrs["unexplained"])

    def fitted(self, name: str) -> FittedValue:
        """A fitted parameter.

        Parameters
        ----------
        name : str
            Such as ``"damping"`` or ``"stiffness:coupler"``.

        Returns
        -------
        FittedValue

        Raises
        ------
        InputError
            If it was not fitted.
        """
        names = [str(known) for known in self.dataset["parameter"].values]
        if name not in names:
            known = suggestion(name, names) if names else "nothing was fitted"
            raise InputError(f"{name!r} was not fitted: {known}")
        parameter = self.dataset.isel(parameter=names.index(name))
        return FittedValue(
            value=float(parameter["fitted"]),
            unit=str(parameter["parameter_unit"].item()),
            standard_error=float(parameter["standard_error"]),
            lower=float(parameter["lower"]),
            upper=float(parameter["upper"]),
        )

    def tables(self) -> dict[str, pd.DataFrame]:
        """The curves, and the fitted parameters."""
        data = self.dataset
        suffix = _SUFFIXES.get(str(data.attrs["unit"]), "")
        parts = ("_real", "_imag") if "measured_real" in data else ("",)
        curves = {
            f"{curve}{component}{suffix}": f"{curve}{component}"
            for curve in CURVES
            for component in parts
        }
        dimension, places = next((d, names) for d, names in _PLACES.items() if d in data.dims)
        return {
            self.stem: table_of(data, (dimension,), places | curves),
            "fit": table_of(data, ("parameter",), _FIT),
        }

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw both curves, their spectra and the residual.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            One a panel: over time the curves, the residual and the spectra; over frequency
            amplitude, phase and residual; over the crank angle the frequencies and the residual.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If the axes are too few or too many.
        """
        return plots.plot_comparison(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Fitted parameters, their correlation and what remains; how the record was aligned."""
        return summary_of(self.dataset)


_PROBLEMS: dict[str, Callable[[Engine, MeasuredRecord, ComparisonRequest], RecordProblem]] = {
    "time": time_problem,
    "crank_angle": frequency_problem,
    "frequency": receptance_problem,
}


@asks(ComparisonRequest)
def compare_with_record(mechanism: Engine | Mechanism, request: ComparisonRequest) -> Comparison:
    """Compare a measured record with what is computed, and fit damping or stiffness to it.

    What is computed depends on the record: over time the running linkage, by its linear
    equations about the quasi-static equilibrium in moving modes, aligned with the record; over the
    crank angle natural frequencies; over frequency the response of the locked linkage to a
    force. Nothing that is fitted is written into the mechanism.

    Parameters
    ----------
    mechanism : Mechanism or Engine

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        If the record has gaps, unequal steps, no unit or another quantity, is too short, or was
        not taken as the request says.
    ComputationError
        If the fit does not converge, or the record does not tell what is fitted.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> angle = np.radians([0.0, 90.0, 180.0, 270.0])
    >>> measured = 0.98 * flexmech.natural_frequencies(engine, angle, modes=1)[:, 0]
    >>> frequency = flexmech.MeasuredQuantity("frequency", "Hz", measured)
    >>> record = flexmech.MeasuredRecord("crank_angle", angle, (frequency,))
    >>> found = flexmech.compare_with_record(engine, record, 0.0, fit=["stiffness:coupler"])
    >>> 0.8 < found.fitted("stiffness:coupler").value < 1.0
    True
    """
    [own] = engines_of(mechanism, request)
    record, report = request.record, request.progress or silent
    taken = record if isinstance(record, MeasuredRecord) else read_record(record)
    request = request.of(own.mechanism, taken)
    _check_kind(taken, request)
    with one_thread():
        problem, attributes = _PROBLEMS[taken.abscissa](own, taken, request), provenance([own])
        if taken.abscissa != "crank_angle":
            fitted_links = damping_times(problem.links, dict.fromkeys(problem.names, 0.0))
            locked = () if request.angle is None else (request.angle,)
            loss = CountedLoss.of(own, locked, fitted_links)
            problem = replace(problem, engine=loss.engine(own))
            attributes |= loss.attributes
        fit = fitted(problem, partial(report, "fit"))
        dataset = comparison_dataset(problem, taken, request, fit)
    if "time" not in dataset.dims:
        attributes |= left_out_attributes(own.mechanism)
    return Comparison(Comparison.schema().labelled(dataset.assign_attrs(attributes)))


def _check_kind(record: MeasuredRecord, request: ComparisonRequest) -> None:
    """Refuse a record that cannot have been taken as the request says."""
    if record.abscissa == "frequency" and request.angle is None:
        raise InputError(
            f"{record.source}: a frequency-response function is compared at a locked crank; give "
            "the crank angle with --angle in place of the speed"
        )
    if record.abscissa != "frequency" and request.speed is None:
        what = "the running linkage" if record.abscissa == "time" else "natural frequencies"
        raise InputError(
            f"{record.source}: a record over {record.abscissa.replace('_', ' ')} is compared with "
            f"{what}; give the crank speed with --speed in place of the angle"
        )
    if record.abscissa == "time" and not request.speed:
        raise InputError(
            f"{record.source}: a record over time is compared with the running linkage; give the "
            "crank speed at which it was taken, not 0, or the frequency-response function of a "
            "test at a locked crank"
        )
