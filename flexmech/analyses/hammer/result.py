"""The result of a hammer test: records, frequency responses, modes, tables and pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines, theory_warnings
from flexmech.analyses.datasets import DEGREES, table_over
from flexmech.analyses.hammer import words
from flexmech.analyses.hammer.uff import uff_contents
from flexmech.analyses.remarks import left_out_warnings
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.errors import InputError
from flexmech.files import given_path, moved_into
from flexmech.measured_data import write_uff

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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
        data = self.dataset
        return table_over(
            *("crank_angle", "frequency"),
            crank_angle_deg=DEGREES * data["crank_angle"],
            frequency_Hz=data["frequency"],
            receptance_real_m_N=data["unwindowed_receptance_real"],
            receptance_imag_m_N=data["unwindowed_receptance_imag"],
            coherence=data["coherence"],
        )

    def identified(self) -> pd.DataFrame:
        """Modes of the band: identified ones beside those of the eigen model.

        Returns
        -------
        pandas.DataFrame
            Not a number where a mode was not identified; ``mac`` where the impact roves over a
            grid.
        """
        data = self.dataset
        table = table_over(
            *("crank_angle", "mode"),
            crank_angle_deg=DEGREES * data["crank_angle"],
            mode=data["mode"],
            frequency_Hz=data["identified_frequency"],
            damping_ratio=data["identified_damping_ratio"],
            eigen_frequency_Hz=data["eigen_frequency"],
            eigen_damping_ratio=data["eigen_damping_ratio"],
            mac=data["mac"],
        )
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
        data = self.dataset
        if "point" not in data.dims:
            raise InputError(
                "this hammer test has no grid of impacts; ask for it by grid=N (--grid N)"
            )
        table = table_over(
            *("crank_angle", "mode", "point"),
            crank_angle_deg=DEGREES * data["crank_angle"],
            mode=data["mode"],
            link=data["point_link"],
            fraction=data["point_fraction"],
            shape_real=data["shape_real"],
            shape_imag=data["shape_imag"],
            eigen_shape_real=data["eigen_shape_real"],
            eigen_shape_imag=data["eigen_shape_imag"],
            complexity_factor=data["complexity_factor"],
        )
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
        """Modes as papers print them, how they were measured, and how sure that is."""
        data = self.dataset
        parts: tuple[Table | str, ...] = (
            words.mode_table(data),
            *words.record_lines(data),
            *theory_lines(data.attrs),
        )
        warned = (
            *words.unfound_warnings(data),
            *left_out_warnings(data.attrs),
            *theory_warnings(data.attrs),
        )
        return Summary(parts, words.verdict(data), warned)

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
