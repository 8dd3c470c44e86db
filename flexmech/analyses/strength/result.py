"""The result of strength: its tables, pictures and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.result import Result
from flexmech.analyses.strength.margins import NO_LAYER
from flexmech.analyses.strength.words import summary_of
from flexmech.analyses.summary import Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Of which files have nothing where no load or speed leads to failure.
_FACTORS = ("", "margin_", "pin_", "fatigue_")


class Strength(Result):
    """Internal forces of links over the turn, and how far layers and pins are from failure.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: internal forces along the links over the crank angle; over
        (engine, link, station, layer, surface) the least factors over the turn; checks of pins over
        ``pin_check``; parts over ``margin``, the weakest first. Links with fewer stations or layers
        have NaN after them.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "strength"
    subject = "strength"
    hallmark = "margin_load_factor"

    def tabulated(self) -> xr.Dataset:
        """The dataset without factors that are infinite, and layers of what has none."""
        data = self.dataset
        names = [f"{of}{name}_factor" for of in _FACTORS for name in ("load", "speed")]
        finite = {n: data[n].where(np.isfinite(data[n])) for n in names if n in data}
        layer = data["margin_layer"]
        return data.assign({**finite, "margin_layer": layer.where(layer != NO_LAYER)})

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
