"""The result of a hammer test on the running linkage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines, theory_warnings
from flexmech.analyses.datasets import table_over
from flexmech.analyses.result import Result
from flexmech.analyses.running_hammer import words
from flexmech.analyses.summary import Summary, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class RunningHammerTest(Result):
    """Harmonic transfer functions of the running linkage, identified from impacts and predicted.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``receptance``, ``predicted`` and ``frozen``, each by its real and imaginary part, over
        (order, frequency of the input); peaks and errors over ``order``; crank angle and decay of
        each ``impact``.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "harmonic_frf"
    subject = "hammer test on the running linkage"
    hallmark = "halving_change"
    files = ("harmonic_frf.csv", "harmonic_prediction.csv", "harmonic_frf.nc", "harmonic_frf.png")

    def response(self) -> pd.DataFrame:
        """Harmonic transfer functions as identified, a row for each order and frequency.

        Returns
        -------
        pandas.DataFrame
            ``frequency_Hz`` is that of the input.
        """
        data = self.dataset
        return table_over(
            *("order", "frequency"),
            order=data["order"],
            frequency_Hz=data["frequency"],
            receptance_real_m_N=data["receptance_real"],
            receptance_imag_m_N=data["receptance_imag"],
        )

    def prediction(self) -> pd.DataFrame:
        """Harmonic transfer functions as predicted, and those of the frozen linkage.

        Returns
        -------
        pandas.DataFrame
        """
        data = self.dataset
        return table_over(
            *("order", "frequency"),
            order=data["order"],
            frequency_Hz=data["frequency"],
            receptance_real_m_N=data["predicted_real"],
            receptance_imag_m_N=data["predicted_imag"],
            frozen_real_m_N=data["frozen_real"],
            frozen_imag_m_N=data["frozen_imag"],
        )

    def peaks(self) -> pd.DataFrame:
        """Greatest amplitude of each order, identified and predicted.

        Returns
        -------
        pandas.DataFrame
        """
        data = self.dataset
        return table_over(
            "order",
            order=data["order"],
            identified_m_N=data["identified_peak"],
            identified_frequency_Hz=data["identified_peak_frequency"],
            predicted_m_N=data["predicted_peak"],
            predicted_frequency_Hz=data["predicted_peak_frequency"],
            bins_apart=data["bins_apart"],
        )

    def tables(self) -> dict[str, pd.DataFrame]:
        """``harmonic_frf`` and ``harmonic_prediction``."""
        return {self.stem: self.response(), "harmonic_prediction": self.prediction()}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw amplitude and phase of each order: identified, predicted, and frozen.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            Two an order.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If the axes are too few or too many.
        """
        return plots.plot_harmonic_frf(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Peaks of the orders, impacts, errors, and how runs and prediction agree."""
        data = self.dataset
        parts: tuple[Table | str, ...] = (
            words.peak_table(data),
            *words.impact_lines(data),
            *words.prediction_lines(data),
            *theory_lines(data.attrs),
            *words.error_lines(data),
        )
        return Summary(parts, words.verdict(data), tuple(theory_warnings(data.attrs)))
