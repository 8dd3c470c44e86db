"""The result of strength: its tables, pictures and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import Columns, table_of
from flexmech.analyses.result import Result
from flexmech.analyses.strength.margins import NO_LAYER
from flexmech.analyses.strength.words import summary_of
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PLACES = ("engine", "link", "station", "layer", "surface")
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
_PINS = {
    "engine": "engine",
    "joint": "pin_joint",
    "link": "pin_link",
    "check": "pin_mode",
    "crank_angle_deg": "pin_worst_angle",
    "stress_Pa": "pin_stress",
    "mean_Pa": "pin_mean",
    "allowable_Pa": "pin_allowable",
    "load_factor": "pin_load_factor",
    "speed_factor": "pin_speed_factor",
}
_ENDURANCE = {
    "engine": "engine",
    "link": "link",
    "position_m": "position",
    "layer": "layer",
    "surface": "surface",
    "crank_angle_deg": "peak_angle",
    "stress_amplitude_Pa": "stress_amplitude",
    "mean_stress_Pa": "mean_stress",
    "cycles_per_turn": "stress_cycles",
    "load_factor": "fatigue_load_factor",
    "speed_factor": "fatigue_speed_factor",
    "turns_to_failure": "turns_to_failure",
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
    """Internal forces of links over the turn, and how far layers and pins are from failure.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over (engine, link, crank_angle, station): ``axial_force``, ``bending_moment`` and
        ``shear_force`` at ``position`` (link, station). Over (engine, link, station, layer,
        surface): ``load_factor``, the least over the turn, with ``worst_angle``,
        ``failure_index`` and ``failure_mode`` there, and ``speed_factor``. Over (link, layer):
        ``criterion``, ``ply`` and ``angle``. Over ``pin_check``, where joints state diameters:
        ``pin_joint``, ``pin_mode``, ``pin_stress``, ``pin_load_factor`` and so on. Where materials
        state their fatigue, at every place: ``stress_amplitude``, ``mean_stress``,
        ``fatigue_load_factor``, ``turns_to_failure`` and so on. Over ``margin``, the weakest part
        first: its ``margin_part``, ``margin_load_factor`` and so on. Links with fewer stations or
        layers have NaN after them.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "strength"
    subject = "strength"
    hallmark = "margin_load_factor"
    files = (
        "strength.csv",
        "margins.csv",
        "pins.csv",
        "endurance.csv",
        "internal_forces.csv",
        "strength.nc",
        "strength.png",
        "internal_forces.png",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Each place at its worst crank angle; the margins of parts; internal forces."""
        data = self.dataset
        places = table_of(data, _PLACES, _STRENGTH).dropna(subset=["load_factor"])
        forces = table_of(data, ("engine", "link", "crank_angle", "station"), _FORCES)
        checked = "pin_joint" in data
        return {
            "strength": _finite(places.reset_index(drop=True)),
            "margins": _finite(_margins_table(data)),
            **(
                {"pins": _finite(table_of(data, ("engine", "pin_check"), _PINS))} if checked else {}
            ),
            **({"endurance": _endurance_table(data)} if "stress_amplitude" in data else {}),
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


def _endurance_table(data: xr.Dataset) -> pd.DataFrame:
    table = table_of(data, _PLACES, _ENDURANCE).dropna(subset=["load_factor"])
    return _finite(table.reset_index(drop=True))


def _finite(table: pd.DataFrame) -> pd.DataFrame:
    """The table with empty factors where no load or speed leads to failure."""
    factors = [name for name in ("load_factor", "speed_factor") if name in table]
    return table.assign(**{name: table[name].replace(np.inf, np.nan) for name in factors})


def _margins_table(data: xr.Dataset) -> pd.DataFrame:
    columns: Columns = {
        "part": "margin_part",
        "kind": "margin_kind",
        "load_factor": "margin_load_factor",
        "speed_factor": "margin_speed_factor",
        "where": "margin_where",
        "layer": "margin_layer",
        "crank_angle_deg": "margin_crank_angle",
        "mode_of_failure": "margin_mode",
        "relative_error": "margin_error",
    }
    if "margin_error" not in data:  # a file of an earlier version
        del columns["relative_error"]
    table = table_of(data, ("margin",), columns)
    layers = table["layer"].astype("Int64")
    return table.assign(layer=layers.mask(layers == NO_LAYER))
