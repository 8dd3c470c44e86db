"""The result of a hammer test on the running linkage."""

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
from flexmech.analyses.running_hammer.measured import FAINT
from flexmech.analyses.summary import Summary, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_OVER = ("order", "frequency")
_PLACES = {"order": "order", "frequency_Hz": "frequency"}
# Columns of the tables, and their variables.
_RESPONSE = _PLACES | {
    "receptance_real_m_N": "receptance_real",
    "receptance_imag_m_N": "receptance_imag",
}
_PREDICTION = _PLACES | {
    "receptance_real_m_N": "predicted_real",
    "receptance_imag_m_N": "predicted_imag",
    "frozen_real_m_N": "frozen_real",
    "frozen_imag_m_N": "frozen_imag",
}
_PEAKS = {
    "order": "order",
    "identified_m_N": "identified_peak",
    "identified_frequency_Hz": "identified_peak_frequency",
    "predicted_m_N": "predicted_peak",
    "predicted_frequency_Hz": "predicted_peak_frequency",
    "bins_apart": "bins_apart",
}


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
        return table_of(self.dataset, _OVER, _RESPONSE)

    def prediction(self) -> pd.DataFrame:
        """Harmonic transfer functions as predicted, and those of the frozen linkage.

        Returns
        -------
        pandas.DataFrame
        """
        return table_of(self.dataset, _OVER, _PREDICTION)

    def peaks(self) -> pd.DataFrame:
        """Greatest amplitude of each order, identified and predicted.

        Returns
        -------
        pandas.DataFrame
        """
        return table_of(self.dataset, ("order",), _PEAKS)

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
        details = (
            *_impact_lines(data),
            *_prediction_lines(data),
            *theory_lines(data.attrs),
            *_error_lines(data),
        )
        warned = warnings_of(data.attrs)
        answer = _answer(data)
        return Summary(answer, _peak_table(data), _verdict(data), details, warned, _numbers(data))


# Of the acceptance of a test: amplitudes within this part, and frequencies within so many bins.
_AGREES, _BINS = 0.05, 1
# Sidebands that the last line speaks of: those that the default asks for.
_SIDEBANDS = 2


def _answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Greatest amplitude of all orders, and how strong the sidebands are against it."""
    peaks = dataset["identified_peak"]
    order = int(peaks.idxmax("order"))
    own = dataset.sel(order=order)
    at = float(own["identified_peak_frequency"])
    [greatest] = (one for one in _numbers(dataset) if one.of == f"order {order}")
    sides = peaks.sel(order=peaks["order"] != 0)
    said = f"The response is greatest at {at:.4g} Hz, {greatest} of order {order}"
    if order == 0 and sides.sizes["order"]:
        share = 100 * float(sides.max() / peaks.max())
        strongest = int(sides.idxmax("order"))
        said += f"; the strongest sideband, order {strongest:+d}, has {share:.2g} % of it"
    return (f"{said}.",)


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Greatest amplitude of each order; its error is the way to the prediction."""
    return tuple(
        Quantity(
            "identified_peak",
            float(own["identified_peak"]),
            "m/N",
            abs(float(own["identified_peak"]) - float(own["predicted_peak"])),
            f"order {order}",
        )
        for order in dataset["order"].values.tolist()
        for own in [dataset.sel(order=order)]
    )


def _peak_table(dataset: xr.Dataset) -> Table:
    """Greatest amplitude of each order, identified and predicted.

    Parameters
    ----------
    dataset : xarray.Dataset

    Returns
    -------
    Table
    """
    rows = []
    for order in dataset["order"].values.tolist():
        own = dataset.sel(order=order)
        rows.append(
            (
                f"{order:+d}" if order else "0",
                f"{float(own['identified_peak']):.4g}",
                f"{float(own['identified_peak_frequency']):.5g}",
                f"{float(own['predicted_peak']):.4g}",
                f"{float(own['predicted_peak_frequency']):.5g}",
                "-" if _is_faint(dataset, order) else f"{100 * _apart(own):+.2f}",
                "-" if _is_faint(dataset, order) else str(int(own["bins_apart"])),
            )
        )
    resolution = float(dataset["frequency"][1] - dataset["frequency"][0])
    return Table(
        f"harmonic response, {dataset.attrs.get('mechanism', '')}",
        ("order", "identified m/N", "at Hz", "predicted m/N", "at Hz", "apart %", "bins"),
        (tuple(rows),),
        caption=(
            "greatest amplitude of each order: response at f + n f_crank to a force at f, at the "
            f"input's frequency f; bins of {resolution:.4g} Hz"
        ),
    )


def _impact_lines(dataset: xr.Dataset) -> list[str]:
    """How the linkage was hit and the orders were separated."""
    attrs, count = dataset.attrs, dataset.sizes["impact"]
    fitted = int(attrs["highest_fitted_order"])
    turns = int(attrs["turns"])
    noise = float(attrs["noise"])
    lines = [
        f"impacts: {count} at evenly spaced, jittered crank angles (seed {attrs['seed']}) of "
        f"{float(attrs['peak_force']):.3g} N and {1e3 * float(attrs['pulse']):.3g} ms on "
        f"{attrs['impact_point']}, read at {attrs['response_point']}, {attrs['direction']}, at "
        f"{crank_speed_text(attrs)}; a twin run without impact is subtracted",
        f"orders: -{fitted} to {fitted} by least squares, condition number "
        f"{float(attrs['condition']):.3g}; they leave {100 * float(attrs['misfit']):.2g} % of the "
        "responses",
        f"records: {turns} turns, {turns * float(attrs['turn_time']):.4g} s, at whose end an "
        f"impact has decayed to {float(dataset['decay'].max()):.1e} of its greatest response; each "
        "impact has a run of its own, from the twin's state at crank angle 0",
        f"small enough: halving the impacts, which add {1e6 * float(attrs['peak_response']):.3g} "
        f"µm at most, changes H_n by {100 * float(dataset['halving_change'].max()):.2g} % at most",
    ]
    if noise:
        averages = int(attrs["averages"])
        lines.append(
            f"noise: {100 * noise:.3g} % of each record of force and response, "
            f"{averages} impact{'' if averages == 1 else 's'} at each crank angle"
        )
    return lines


def _prediction_lines(dataset: xr.Dataset) -> list[str]:
    """What the prediction is of, and what it leaves out."""
    attrs = dataset.attrs
    return [
        f"prediction: {int(attrs['moving_modes'])} moving modes about the quasi-static state "
        f"(prestress {attrs['prestress']}) with the static answer of those left out, by the "
        f"propagator in {int(attrs['propagator_steps'])} steps a turn; the slowest vibration "
        f"decays by {float(attrs['decay_rate']):.4g} 1/s"
    ]


def _error_lines(dataset: xr.Dataset) -> list[str]:
    """How far prediction and runs may be off."""
    step, balance, reduction = (
        float(dataset[f"{name}_error"].max()) for name in ("step", "balance", "reduction")
    )
    return [
        f"errors of the prediction, over each order's greatest amplitude: steps {step:.1e}, moving "
        f"modes {reduction:.1e}; harmonic balance differs by {balance:.1e}",
        f"errors of the runs: time steps of {float(dataset.attrs['step']):.3g} s lower a frequency "
        f"by up to {float(dataset.attrs['step_lag']):.1e} of itself at the bandwidth's end; the "
        f"twin repeats itself to {float(dataset.attrs['twin_defect']):.1e}",
    ]


def _verdict(dataset: xr.Dataset) -> str:
    """How the first sidebands that were identified agree with those predicted."""
    engine = dataset.attrs["engine"]
    near = [n for n in dataset["order"].values.tolist() if 0 < abs(n) <= _SIDEBANDS]
    strong = [n for n in near if not _is_faint(dataset, n)]
    if not strong:
        largest = float(dataset["identified_peak"].max())
        sideband = float(dataset["identified_peak"].sel(order=near).max())
        return (
            f"{engine}: no sidebands are predicted; those identified are {sideband / largest:.1e} "
            "of the greatest amplitude at most"
        )
    sides = dataset.sel(order=strong)
    # Not a number where an order was not identified: that is no agreement.
    apart = float(np.max([abs(_apart(sides.isel(order=n))) for n in range(sides.sizes["order"])]))
    bins = int(sides["bins_apart"].max())
    agree = apart <= _AGREES and bins <= _BINS
    return (
        f"{engine}: the sidebands identified and predicted "
        f"{'agree' if agree else 'do not agree'} within {100 * _AGREES:g} % and {_BINS} bin: "
        f"amplitudes {100 * apart:.2g} % and frequencies {bins} bin{'' if bins == 1 else 's'} "
        "apart at most"
    )


def _is_faint(dataset: xr.Dataset, order: int) -> bool:
    """Whether next to nothing is predicted of an order, as of all but one of a rotating arm."""
    peaks = dataset["predicted_peak"]
    return bool(peaks.sel(order=order) < FAINT * peaks.max())


def _apart(order: xr.Dataset) -> float:
    """Relative difference of the identified amplitude of an order."""
    return float(order["identified_peak"]) / float(order["predicted_peak"]) - 1
