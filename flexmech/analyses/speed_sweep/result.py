"""The result of a speed sweep: peaks of the periodic motion, and critical speeds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import Columns, columns_along, table_of
from flexmech.analyses.digits import Quantity, percent, rounded
from flexmech.analyses.remarks import speed_text, warnings_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.analyses.trust import trust_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class SpeedSweep(Result):
    """Peak deflections of the periodic motion over crank speeds, with critical speeds.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``peak_deflection`` over (crank_speed, link) in m; ``critical_speed_low`` and
        ``critical_speed_high`` over (mode, order) in rad/s. Estimated relative errors:
        ``peak_error`` over (check_speed, link), at some of the speeds and where each link bends
        most, and ``discretisation_error`` of the critical speeds over mode.
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
        """Greatest peak of each link, the speed where it is, and how far it is known."""
        data, attributes = self.dataset, self.dataset.attrs
        unit = attributes["speed_unit"]
        found = _greatest_peaks(data)
        rows = tuple(
            (str(link), rounded(peak, error), speed_text(speed, unit))
            for link, peak, error, speed in found.itertuples()
        )
        title = f"greatest steady-state deflection, {attributes['mechanism']}"
        most = str(found["peak"].idxmax())
        peaks = {
            str(link): Quantity("peak_deflection", peak, "mm", error, str(link))
            for link, peak, error, _ in found.itertuples()
        }
        where = speed_text(found["speed"][most], unit)
        relative = (found["error"] / found["peak"]).where(found["peak"] > 0, 0.0).max(skipna=False)
        return Summary(
            (f"The {most} bends most, by up to {peaks[most]} at {where} {unit}.",),
            Table(title, ("link", "mm", f"at {unit}"), (rows,)),
            trust_line([attributes["engine"]], float(relative)),
            details=(*theory_lines(attributes), *_error_lines(data)),
            warnings=warnings_of(attributes),
            numbers=(peaks.pop(most), *peaks.values()),
        )


def _greatest_peaks(data: xr.Dataset) -> pd.DataFrame:
    """Greatest peak of each link and its error in mm, and the speed in rad/s where it is."""
    peaks = 1e3 * data["peak_deflection"]
    speeds = peaks.idxmax("crank_speed")
    errors = xr.full_like(speeds, np.nan)
    # Results of before errors were estimated have none.
    if "peak_error" in data:
        errors = data["peak_error"].sel(check_speed=speeds).drop_vars("check_speed")
    greatest = peaks.max("crank_speed")
    found = xr.Dataset({"peak": greatest, "error": errors * greatest, "speed": speeds})
    return found.drop_vars("probe", errors="ignore").to_dataframe()


def _error_lines(data: xr.Dataset) -> Iterator[str]:
    """Errors of the peaks at the speeds checked, and of the critical speeds."""
    if "peak_error" not in data:
        return
    errors, unit = data["peak_error"].max("link"), data.attrs["speed_unit"]
    pairs = zip(errors["check_speed"].values, errors.values, strict=True)
    told = ", ".join(f"{percent(error)} at {speed_text(speed, unit)}" for speed, error in pairs)
    yield f"errors of the peaks by mesh, time step and component modes (estimated): {told} {unit}"
    worst = float(data["discretisation_error"].max())
    yield f"error of the critical speeds by the mesh (estimated): at most {percent(worst)}"
