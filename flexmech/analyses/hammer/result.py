"""The result of a hammer test: records, frequency responses, modes, tables and pictures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import DEGREES, table_of
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.hammer.uff import uff_contents
from flexmech.analyses.remarks import warnings_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.files import given_path, moved_into
from flexmech.measured_data import write_uff

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_OVER_MODES = {"crank_angle_deg": "crank_angle", "mode": "mode"}
# Columns of the tables, and their variables.
_FRF = {
    "crank_angle_deg": "crank_angle",
    "frequency_Hz": "frequency",
    "receptance_real_m_N": "unwindowed_receptance_real",
    "receptance_imag_m_N": "unwindowed_receptance_imag",
    "coherence": "coherence",
}
_IDENTIFIED = _OVER_MODES | {
    "frequency_Hz": "identified_frequency",
    "damping_ratio": "identified_damping_ratio",
    "eigen_frequency_Hz": "eigen_frequency",
    "eigen_damping_ratio": "eigen_damping_ratio",
    "mac": "mac",
}
_SHAPES = _OVER_MODES | {
    "link": "point_link",
    "fraction": "point_fraction",
    "shape_real": "shape_real",
    "shape_imag": "shape_imag",
    "eigen_shape_real": "eigen_shape_real",
    "eigen_shape_imag": "eigen_shape_imag",
    "complexity_factor": "complexity_factor",
}


class HammerTest(Result):
    """Hammer tests at locked crank angles.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``force`` and ``response`` over (crank_angle, average, time); receptances in two parts,
        ``receptance_real`` and ``receptance_imag`` (H1), and ``coherence`` over (crank_angle,
        frequency); ``identified_...`` and ``eigen_...`` over (crank_angle, mode), not a number
        where a mode was not identified or an angle has fewer in the band.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "hammer"
    subject = "hammer test"
    hallmark = "receptance_real"
    files = (
        "frf.csv",
        "identified.csv",
        "hammer.nc",
        "hammer.png",
        "frf.png",
        "frf_parts.png",
        "nyquist.png",
        "stabilisation.png",
        "shapes.csv",
        "shapes.png",
        "hammer_*deg.uff",
    )

    def frf(self) -> pd.DataFrame:
        """Receptance (H1) and coherence at every line of every crank angle.

        What an exponential window adds is taken off by the modes identified.

        Returns
        -------
        pandas.DataFrame
        """
        return table_of(self.dataset, ("crank_angle", "frequency"), _FRF)

    def identified(self) -> pd.DataFrame:
        """Modes of the band: identified ones beside those of the eigen model.

        Returns
        -------
        pandas.DataFrame
            Not a number where a mode was not identified; ``mac`` where the impact roves over a
            grid.
        """
        table = table_of(self.dataset, ("crank_angle", "mode"), _IDENTIFIED)
        return table.dropna(subset=["eigen_frequency_Hz"], ignore_index=True)

    def shapes(self) -> pd.DataFrame:
        """Mode shapes at the points of the grid of impacts.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InputError
            If no grid was roved.
        """
        if "point" not in self.dataset.dims:
            raise InputError(
                "this hammer test has no grid of impacts; ask for it by grid=N (--grid N)"
            )
        table = table_of(self.dataset, ("crank_angle", "mode", "point"), _SHAPES)
        return table.dropna(subset=["eigen_shape_real"], ignore_index=True)

    def tables(self) -> dict[str, pd.DataFrame]:
        """``frf`` and ``identified``, and ``shapes`` where the impact roved over a grid."""
        tables = {"frf": self.frf(), "identified": self.identified()}
        return tables | ({"shapes": self.shapes()} if "point" in self.dataset.dims else {})

    def figures(self) -> dict[str, Figure]:
        """Pictures of the first crank angle.

        Records in time, frequency responses, and Nyquist circles; the stabilisation chart of LSCF,
        and mode shapes where the impact roved over a grid.
        """
        data = self.dataset
        first = data["identified_frequency"].isel(crank_angle=0)
        circles = {"nyquist": plots.plot_nyquist(data)} if first.notnull().any() else {}
        figures = {
            self.stem: plots.plot_hammer(data),
            "frf": self.plot(),
            "frf_parts": plots.plot_frf_parts(data),
        } | circles
        if "chart_order" in data:
            figures["stabilisation"] = plots.plot_stabilisation(data)
        if "point" in data.dims:
            figures["shapes"] = plots.plot_impact_shapes(data)
        return figures

    def plot(self, *, ax: Axes | None = None) -> Figure:
        """Draw the frequency responses with coherence, measured and exact.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional

        Returns
        -------
        matplotlib.figure.Figure
        """
        return plots.plot_frf(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Modes identified, as papers print them, and how near they are to the eigen model."""
        data = self.dataset
        return Summary(
            _answer(data),
            _mode_table(data),
            _verdict(data),
            (*_record_lines(data), *theory_lines(data.attrs)),
            (*_unfound_warnings(data), *warnings_of(data.attrs)),
            _numbers(data),
        )

    def save_uff(self, folder: str | Path) -> list[Path]:
        """Write universal files, one a crank angle: records, frequency responses and modes.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If pyuff is not installed (extra ``modal-test``), or the folder cannot be written to.
        """
        place = given_path(folder)
        with moved_into(place) as temporary:
            names = [
                write_uff(temporary / name, contents).name
                for name, contents in uff_contents(self.dataset).items()
            ]
        return [place / name for name in names]


_HEADINGS = ("crank deg", "mode", "FE Hz", "Ex Hz", "diff %", "FE xi %", "Ex xi %", "diff %", "MAC")
_CAPTION = (
    "FE: eigen model; Ex: identified from the hammer test; xi: damping ratio; "
    "a dash: not identified, or without a grid of impacts"
)
# Modes that the verdict speaks of, as papers do.
_FIRST_MODES = 3


def _answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Identified frequencies and damping ratios of the first modes, over all crank angles."""
    found = dataset.isel(mode=slice(None, _FIRST_MODES))
    told = []
    for number, mode in enumerate(found["mode"].values):
        own = found.isel(mode=number)
        frequency = own["identified_frequency"].values
        ratio = own["identified_damping_ratio"].values
        known = np.isfinite(frequency)
        if not known.any():
            continue
        errors = np.abs(frequency - own["eigen_frequency"].values)[known]
        away = np.abs(ratio - own["eigen_damping_ratio"].values)[known]
        hertz = _span(frequency[known], float(errors.max()))
        percents = _span(100 * ratio[known], 100 * float(away.max()))
        told.append(f"mode {int(mode)} at {hertz} Hz, damped by {percents} %")
    angles = DEGREES * dataset["crank_angle"].values
    one = f"at crank angle {angles[0]:.6g} deg"
    where = one if len(angles) == 1 else f"at {len(angles)} crank angles"
    if not told:
        return (f"The test identifies none of the first modes {where}.",)
    return (f"The test identifies, {where}: {'; '.join(told)}.",)


def _span(values: FloatArray, error: float) -> str:
    """Least and greatest of some values, or the one that they are."""
    ends = (rounded(float(end), error) for end in (values.min(), values.max()))
    return " to ".join(dict.fromkeys(ends))


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """What was identified at the first crank angle; its error is the way to the eigen model."""
    own = dataset.isel(crank_angle=0)
    found = []
    for what, unit, factor in (("frequency", "Hz", 1.0), ("damping_ratio", "%", 100.0)):
        for number, mode in enumerate(own["mode"].values):
            value = factor * float(own[f"identified_{what}"][number])
            apart = abs(value - factor * float(own[f"eigen_{what}"][number]))
            if np.isfinite(value):
                name = f"identified_{what}"
                found.append(Quantity(name, value, unit, apart, f"mode {int(mode)}"))
    return tuple(found)


def _mode_table(dataset: xr.Dataset) -> Table:
    """Measured beside computed frequencies and damping ratios, as papers print them."""
    groups = []
    for number, angle in enumerate(dataset["crank_angle"].values):
        own = dataset.isel(crank_angle=number)
        rows = [
            _row(DEGREES * float(angle), own.isel(mode=mode))
            for mode in range(own.sizes["mode"])
            if np.isfinite(own["eigen_frequency"][mode])
        ]
        groups.append(tuple(rows))
    title = (
        f"hammer test, {dataset.attrs.get('mechanism', '')}: impact at {dataset.attrs['impact']}, "
        f"response at {dataset.attrs['response_point']}, {dataset.attrs['direction']}"
    )
    return Table(title, _HEADINGS, tuple(groups), text_columns=0, caption=_CAPTION)


def _record_lines(dataset: xr.Dataset) -> list[str]:
    """How the records were taken, and what they were compared with."""
    of = dataset.attrs
    samples, averages = dataset.sizes["time"], dataset.sizes["average"]
    error = _greatest(dataset, "simulation_error")
    left_out = _greatest(dataset, "superposition_error")
    direct = _greatest(dataset, "direct_difference")
    misfit = _greatest(dataset, "identification_misfit")
    return [
        f"pulse: half-sine of {1e3 * of['pulse']:.4g} ms with {of['peak_force']:g} N, by which "
        "links move a millionth of the shortest one's length: they answer linearly",
        f"records: {of['duration']:.4g} s, {samples} samples at {of['sampling_rate']:.6g} Hz, "
        f"band to {of['bandwidth']:g} Hz, lines every {1 / of['duration']:.4g} Hz; {averages} "
        f"average{'s' if averages > 1 else ''}, {_noise(of)}",
        f"windows: force about the pulse, {1e3 * of['pulse_start']:.3g} ms after the record's "
        f"begin; {_window(of)}",
        f"transient: {_transient(of)}",
        f"measured receptance (H1) against the superposition of all modes: {error} of the peak "
        "at most",
        "superposition of the modes up to twice the band with the residual term "
        f"{_residual(dataset)} m/N: {left_out} of the peak; direct solution against all modes: "
        f"{direct}",
        f"identification: {of['method']}, which leaves {misfit} of the measured receptance",
    ]


def _unfound_warnings(dataset: xr.Dataset) -> list[str]:
    """Modes of the band that the test did not show, an angle each."""
    eigen, identified = (
        np.isfinite(dataset[f"{kind}_frequency"].values) for kind in ("eigen", "identified")
    )
    missing = eigen & ~identified
    lines = []
    for number, angle in enumerate(dataset["crank_angle"].values):
        modes = dataset["mode"].values[missing[number]]
        if len(modes):
            listed = ", ".join(map(str, modes))
            lines.append(
                f"crank angle {DEGREES * float(angle):.6g} deg: mode{'s' * (len(modes) > 1)} "
                f"{listed} not identified: nearly a node at one of the points, or hidden by "
                "damping or noise; try another --impact or --response"
            )
    return lines


def _verdict(dataset: xr.Dataset) -> str:
    """How near the first modes identified are to the eigen model."""
    found = dataset.isel(mode=slice(None, _FIRST_MODES))
    apart = {
        "frequencies": _difference(found, "frequency"),
        "damping ratios": _difference(found, "damping_ratio"),
    }
    if not any(np.isfinite(each).any() for each in apart.values()):
        return "the test identifies none of the first modes; try other points"
    said = ", ".join(
        f"{name} {100 * np.nanmax(np.abs(each)):.2g} %" for name, each in apart.items()
    )
    return f"identified against eigen model, first {found.sizes['mode']} modes: {said} at most"


def _row(degrees: float, mode: xr.Dataset) -> tuple[str, ...]:
    eigen, found = float(mode["eigen_frequency"]), float(mode["identified_frequency"])
    damped, ratio = float(mode["eigen_damping_ratio"]), float(mode["identified_damping_ratio"])
    return (
        f"{degrees:.6g}",
        str(int(mode["mode"])),
        f"{eigen:.6g}",
        _number(found, "{:.6g}"),
        _number(100 * (found / eigen - 1), "{:+.3f}"),
        f"{100 * damped:.4g}",
        _number(100 * ratio, "{:.4g}"),
        _number(100 * (ratio / damped - 1), "{:+.2f}"),
        _number(float(mode["mac"]), "{:.4f}"),
    )


def _number(value: float, form: str) -> str:
    if not np.isfinite(value):
        return "-"
    text = form.format(value)
    return text if float(text) else text.lstrip("+-")


def _difference(dataset: xr.Dataset, what: str) -> FloatArray:
    return np.asarray(dataset[f"identified_{what}"] / dataset[f"eigen_{what}"] - 1)


def _greatest(dataset: xr.Dataset, name: str) -> str:
    return f"{float(np.abs(dataset[name]).max()):.1e}"


def _residual(dataset: xr.Dataset) -> str:
    values = dataset["residual_term"].values
    low, high = values.min(), values.max()
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def _noise(of: Mapping[Any, Any]) -> str:
    if not of["noise"]:
        return "no noise"
    return f"noise of {100 * of['noise']:g} % of the signal's root mean square, seed {of['seed']}"


def _window(of: Mapping[Any, Any]) -> str:
    rate = of["window_decay_rate"]
    if not rate:
        return f"none on the response, which decays to {of['left_at_the_end']:g}"
    return (
        f"exponential with {rate:.4g} 1/s on both, so that the response ends at "
        f"{of['left_at_the_end']:g}; its damping is taken off the poles "
        "identified, and by these off the receptance of frf.csv"
    )


def _transient(of: Mapping[Any, Any]) -> str:
    if not of["simulates"]:
        return "exact answer of the linear equations to the pulse, no error of time steps"
    shift = (np.pi * of["bandwidth"] * of["step"]) ** 2 / 3
    return (
        f"Exudyn's nonlinear simulation by the trapezoidal rule in steps of "
        f"{1e3 * of['step']:.4g} ms; the rule's shift of frequencies, {100 * shift:.2g} % at "
        "the end of the band, is taken off"
    )
