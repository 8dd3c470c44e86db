"""The result of strength: its tables, pictures and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import Columns, table_of
from flexmech.analyses.result import Result
from flexmech.analyses.strength.words import summary_of, where_text
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STRENGTH = {
    "engine": "engine",
    "link": "link",
    "position_m": "position",
    "layer": "layer",
    "surface": "surface",
    "crank_angle_deg": "worst_angle",
    "criterion": "criterion",
    "index": "failure_index",
    "load_factor": "load_factor",
}
_FORCES = {
    "engine": "engine",
    "link": "link",
    "position_m": "position",
    "crank_angle_deg": "crank_angle",
    "axial_force_N": "axial_force",
    "shear_force_N": "shear_force",
    "bending_moment_Nm": "bending_moment",
}


class Strength(Result):
    """Internal forces of links over the turn, and how far their layers are from failure.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over (engine, link, crank_angle, station): ``axial_force``, ``bending_moment`` and
        ``shear_force`` at ``position`` (link, station). Over (engine, link, station, layer,
        surface): ``load_factor``, the least over the turn, with ``worst_angle``,
        ``failure_index`` and ``failure_mode`` there, and ``speed_factor``. Over (link, layer):
        ``criterion``, ``ply`` and ``angle``. Over ``margin``, the weakest part first: its
        ``margin_part``, ``margin_load_factor`` and so on. Links with fewer stations or layers have
        NaN after them.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "strength"
    subject = "strength"
    hallmark = "margin_load_factor"
    files = (
        "strength.csv",
        "margins.csv",
        "internal_forces.csv",
        "strength.nc",
        "strength.png",
        "internal_forces.png",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Each place at its worst crank angle; the margins of parts; internal forces."""
        data = self.dataset
        dims = ("engine", "link", "station", "layer", "surface")
        places = table_of(data, dims, _STRENGTH).dropna(subset=["load_factor"])
        forces = table_of(data, ("engine", "link", "crank_angle", "station"), _FORCES)
        return {
            "strength": places.reset_index(drop=True),
            "margins": _margins_table(data),
            "internal_forces": forces.dropna(subset=["position_m"]).reset_index(drop=True),
        }

    def figures(self) -> dict[str, Figure]:
        """Margins on the drawn linkage, and internal forces along the links."""
        return {
            "strength": self.plot(),
            "internal_forces": plots.plot_internal_forces(self.dataset),
        }

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the linkage, each link coloured by its load factor, the worst places marked.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            The user's.
        """
        return plots.plot_strength(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Which part fails first, how, and by what factors loads and speed may rise."""
        return summary_of(self.dataset)


def _margins_table(data: xr.Dataset) -> pd.DataFrame:
    places = [where_text(data, number) for number in range(data.sizes["margin"])]
    columns: Columns = {
        "part": "margin_part",
        "kind": "margin_kind",
        "load_factor": "margin_load_factor",
        "speed_factor": "margin_speed_factor",
        "where": xr.DataArray(places, dims="margin"),
        "layer": "margin_layer",
        "crank_angle_deg": "margin_crank_angle",
        "mode_of_failure": "margin_mode",
    }
    return table_of(data, ("margin",), columns)
