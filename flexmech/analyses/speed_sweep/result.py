"""The result of a speed sweep: peaks of the periodic motion, and critical speeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import Columns, columns_along, table_of
from flexmech.analyses.remarks import speed_text, warnings_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class SpeedSweep(Result):
    """Peak deflections of the periodic motion over crank speeds, with critical speeds.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``peak_deflection`` over (crank_speed, link) in m; ``critical_speed_low`` and
        ``critical_speed_high`` over (mode, order) in rad/s.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "speed_sweep"
    subject = "peaks and critical speeds over crank speed"
    hallmark = "peak_deflection"
    files = ("speed_sweep.csv", "speed_sweep.nc", "speed_sweep.png")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Peaks, one row for each crank speed."""
        peaks = columns_along("{}_peak_deflection_m", self.dataset["peak_deflection"], "link")
        columns: Columns = {"crank_speed_rad_s": "crank_speed", **peaks}
        return {self.stem: table_of(self.dataset, ("crank_speed",), columns)}

    def plot(
        self,
        *,
        ax: plots.AxesLike | None = None,
        links: str | Sequence[str] | None = None,
        modes: int | Sequence[int] | None = None,
    ) -> Figure:
        """Draw peaks against crank speed, over the critical speeds.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            One for each link.
        links : str or sequence of str, optional
        modes : int or sequence of int, optional
            Whose critical speeds are shaded.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If something chosen is not there, or the axes are too few or too many.
        """
        return plots.plot_speed_sweep(plots.chosen(self.dataset, links=links, modes=modes), ax=ax)

    def summary(self) -> Summary:
        """Greatest peak of each link, and the speed where it is."""
        peaks, unit = self.dataset["peak_deflection"], self.dataset.attrs["speed_unit"]
        speeds = peaks["crank_speed"][peaks.argmax("crank_speed")]
        rows = tuple(
            (
                str(link),
                f"{1e3 * float(peaks.sel(link=link).max()):.4g}",
                speed_text(speeds.sel(link=link), unit),
            )
            for link in peaks["link"].values
        )
        title = f"greatest steady-state deflection, {self.dataset.attrs['mechanism']}"
        table = Table(title, ("link", "mm", f"at {unit}"), (rows,))
        attributes = self.dataset.attrs
        return Summary((table, *theory_lines(attributes)), warnings=warnings_of(attributes))
