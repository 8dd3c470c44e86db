"""The result of a hammer test: records, frequency responses, modes, tables and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.datasets import table_of
from flexmech.analyses.hammer.uff import uff_contents
from flexmech.analyses.hammer.words import hammer_summary
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
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
    "frequency_error_Hz": "identified_frequency_error",
    "damping_ratio_error": "identified_damping_ratio_error",
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
        where a mode was not identified or an angle has fewer in the band; ``..._error`` are
        standard errors of what was identified, by noise.
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
        return hammer_summary(self.dataset)

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
