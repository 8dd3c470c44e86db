"""The result of a hammer test: records, frequency responses, modes, tables and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines, theory_warnings
from flexmech.analyses.hammer import words
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.analyses.tables import DEGREES, table_over

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["HammerTest"]


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
    )

    def frf(self) -> pd.DataFrame:
        """Receptance (H1) and coherence at every line of every crank angle.

        Returns
        -------
        pandas.DataFrame
        """
        data = self.dataset
        return table_over(
            *("crank_angle", "frequency"),
            crank_angle_deg=DEGREES * data["crank_angle"],
            frequency_Hz=data["frequency"],
            receptance_real_m_N=data["receptance_real"],
            receptance_imag_m_N=data["receptance_imag"],
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

    def tables(self) -> dict[str, pd.DataFrame]:
        """``frf`` and ``identified``."""
        return {"frf": self.frf(), "identified": self.identified()}

    def figures(self) -> dict[str, Figure]:
        """Records in time, frequency responses, and Nyquist circles, of the first crank angle."""
        data = self.dataset
        first = data["identified_frequency"].isel(crank_angle=0)
        circles = {"nyquist": plots.plot_nyquist(data)} if first.notnull().any() else {}
        return {
            self.stem: plots.plot_hammer(data),
            "frf": self.plot(),
            "frf_parts": plots.plot_frf_parts(data),
        } | circles

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
        warned = (*words.unfound_warnings(data), *theory_warnings(data.attrs))
        return Summary(parts, words.verdict(data), warned)
