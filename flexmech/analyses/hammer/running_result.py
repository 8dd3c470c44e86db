"""Harmonic transfer functions of the running linkage: tables, picture and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import table_of
from flexmech.analyses.digits import Quantity
from flexmech.analyses.remarks import crank_speed_text, warnings_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Columns of the tables, and their variables.
_RESPONSE = {
    "order": "order",
    "frequency_Hz": "frequency",
    "receptance_real_m_N": "receptance_real",
    "receptance_imag_m_N": "receptance_imag",
    "frozen_real_m_N": "frozen_real",
    "frozen_imag_m_N": "frozen_imag",
}
_PEAKS = {"order": "order", "peak_m_N": "peak", "peak_frequency_Hz": "peak_frequency"}
_ERRORS = ("step_error", "balance_error", "reduction_error")


class RunningHammerTest(Result):
    """Harmonic transfer functions of the running linkage, and those of the frozen one.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``receptance`` and ``frozen``, each by its real and imaginary part, over (order, frequency
        of the force); peaks and errors over ``order``.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "harmonic_frf"
    subject = "hammer test on the running linkage"
    hallmark = "peak_frequency"
    files = ("harmonic_frf.csv", "harmonic_frf.nc", "harmonic_frf.png")

    def response(self) -> pd.DataFrame:
        """Harmonic transfer functions, a row for each order and frequency.

        Returns
        -------
        pandas.DataFrame
            ``frequency_Hz`` is that of the force; ``frozen_...`` are of the frozen linkage.
        """
        return table_of(self.dataset, ("order", "frequency"), _RESPONSE)

    def peaks(self) -> pd.DataFrame:
        """Greatest amplitude of each order.

        Returns
        -------
        pandas.DataFrame
        """
        return table_of(self.dataset, ("order",), _PEAKS)

    def tables(self) -> dict[str, pd.DataFrame]:
        """``harmonic_frf``."""
        return {self.stem: self.response()}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw amplitude and phase of each order, of the running linkage and of the frozen one.

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
        """Peaks of the orders, what was solved, and how far it may be off."""
        data = self.dataset
        attrs = data.attrs
        step, balance, reduction = (float(data[name].max()) for name in _ERRORS)
        details = (
            f"force on {attrs['impact_point']}, read at {attrs['response_point']}, "
            f"{attrs['direction']}, at {crank_speed_text(attrs)}",
            f"equations: {int(attrs['moving_modes'])} moving modes about the quasi-static state "
            f"(prestress {attrs['prestress']}) with the static answer of those left out, by the "
            f"propagator in {int(attrs['propagator_steps'])} steps a turn; the slowest vibration "
            f"decays by {float(attrs['decay_rate']):.4g} 1/s",
            *theory_lines(attrs),
        )
        verdict = (
            f"{attrs['engine']}: errors over each order's greatest amplitude: steps {step:.1e}, "
            f"moving modes {reduction:.1e}; harmonic balance differs by {balance:.1e}"
        )
        warned = warnings_of(attrs)
        return Summary(_answer(data), _peak_table(data), verdict, details, warned, _numbers(data))


def _answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Greatest amplitude of all orders, and how strong the sidebands are against it."""
    peaks = dataset["peak"]
    order = int(peaks.idxmax("order"))
    [greatest] = (one for one in _numbers(dataset) if one.of == f"order {order}")
    at = float(dataset["peak_frequency"].sel(order=order))
    said = f"The response is greatest at {at:.4g} Hz, {greatest} of order {order}"
    sides = peaks.sel(order=peaks["order"] != 0)
    if order == 0:
        share = 100 * float(sides.max() / peaks.max())
        strongest = int(sides.idxmax("order"))
        said += f"; the strongest sideband, order {strongest:+d}, has {share:.2g} % of it"
    return (f"{said}.",)


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Greatest amplitude of each order with all its errors."""
    error = dataset["peak"] * sum(dataset[name] for name in _ERRORS)
    return tuple(
        Quantity("peak", float(peak), "m/N", float(off), f"order {order}")
        for order, peak, off in zip(
            dataset["order"].values.tolist(), dataset["peak"].values, error.values, strict=True
        )
    )


def _peak_table(dataset: xr.Dataset) -> Table:
    """Greatest amplitude of each order, and what the frozen linkage has at most."""
    parts = (dataset[f"frozen_{part}"].values for part in ("real", "imag"))
    frozen = np.hypot(*parts).max(axis=1)
    rows = [
        (
            f"{peak.order:+d}" if peak.order else "0",
            f"{peak.peak:.4g}",
            f"{peak.peak_frequency:.5g}",
            f"{alone:.4g}",
        )
        for peak, alone in zip(
            dataset[["peak", "peak_frequency"]].to_dataframe().reset_index().itertuples(),
            frozen,
            strict=True,
        )
    ]
    resolution = float(dataset["frequency"][1] - dataset["frequency"][0])
    return Table(
        f"harmonic response, {dataset.attrs.get('mechanism', '')}",
        ("order", "greatest m/N", "at Hz", "frozen linkage m/N"),
        (tuple(rows),),
        caption=(
            "greatest amplitude of each order: response at f + n f_crank to a force at f, at the "
            f"force's frequency f; lines every {resolution:.4g} Hz"
        ),
    )
