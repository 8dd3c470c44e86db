"""The result of a synthesis: its table, picture and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from flexmech import plots
from flexmech.analyses.datasets import table_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CrankRockerSynthesis(Result):
    """A crank-rocker for a wanted transmission angle, and what comes out when it is checked.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``ratio`` of the lengths to the ground's over ``member``, and ``length`` where that of
        the ground is given. Computed back from the lengths: ``transmission_angle`` over
        ``crank_angle`` and its least and greatest value ``transmission_angle_limit``;
        ``rocker_angle`` at crank angle zero, ``rocker_swing`` and ``time_ratio``.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "transmission_angle"
    subject = "transmission angle"
    hallmark = "rocker_swing"
    files = ("transmission_angle.csv", "transmission_angle.nc", "transmission_angle.png")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Transmission angle at each degree of the crank."""
        columns = {f"{name}_deg": name for name in ("crank_angle", "transmission_angle")}
        return {self.stem: table_of(self.dataset.isel(linkage=0), ("crank_angle",), columns)}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the transmission angle over a turn, in axes of the user's if they are given."""
        return plots.plot_transmission_angle(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Proportions, and what the linkage made of them has, computed back from its lengths."""
        data = self.dataset
        ratios = data["ratio"].to_series().drop("ground").items()
        least, greatest = np.degrees(data["transmission_angle_limit"].values)
        lines = [
            ", ".join(f"{link} {ratio:.4f}" for link, ratio in ratios) + " of the ground",
            f"check: transmission angle {least:.6g} to {greatest:.6g} deg, rocker at "
            f"{np.degrees(data['rocker_angle'].item()):.6g} deg at crank angle 0",
            f"Grashof class: {data.attrs['grashof_class']}; the rocker swings through "
            f"{np.degrees(data['rocker_swing'].item()):.5g} deg, time ratio "
            f"{data['time_ratio'].item():.4g}",
        ]
        if "length" in data:
            lengths = data["length"].to_series().items()
            table = [f'{link} = "{1e3 * length:.6g} mm"' for link, length in lengths]
            lines += ["", "[linkage]", 'kind = "four-bar"', *table, ""]
        return Summary(tuple(lines))
