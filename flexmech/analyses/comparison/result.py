"""The result of a comparison with a record: curves, fitted parameters, tables and pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.comparison.problem import CURVES
from flexmech.analyses.comparison.words import comparison_summary
from flexmech.analyses.datasets import table_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.errors import InputError, suggestion

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
        Of the file that it was loaded from.
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
        own = self.dataset.isel(parameter=names.index(name))
        return FittedValue(
            value=float(own["fitted"]),
            unit=str(own["parameter_unit"].item()),
            standard_error=float(own["standard_error"]),
            lower=float(own["lower"]),
            upper=float(own["upper"]),
        )

    def tables(self) -> dict[str, pd.DataFrame]:
        """The curves, and the fitted parameters."""
        data = self.dataset
        suffix = _SUFFIXES.get(str(data.attrs["unit"]), "")
        parts = ("_real", "_imag") if "measured_real" in data else ("",)
        curves = {f"{curve}{part}{suffix}": f"{curve}{part}" for curve in CURVES for part in parts}
        dimension, places = next((d, own) for d, own in _PLACES.items() if d in data.dims)
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
        return comparison_summary(self.dataset)
