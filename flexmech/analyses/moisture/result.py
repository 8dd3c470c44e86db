"""The result of moisture uptake: its tables, picture and words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import Columns, table_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.units import ZERO_CELSIUS, from_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Columns of the tables, and their variables; moisture as percentages besides.
_PROFILE = {"link": "link", "time_s": "profile_time", "place_m": "place"}
_LAWS = {name: name for name in ("uptake", "short_time_uptake", "shen_springer_uptake")}


class MoistureUptake(Result):
    """Water in the links of a mechanism over time, from dry.

    Parameters
    ----------
    dataset : xarray.Dataset
        Moisture ``profile`` of the resin (mass of water over its dry mass) over ``link``,
        ``profile_time`` and ``cell``, at the ``place`` of each cell from the middle of the
        thickness, a mean over the width where water enters through the sides too
        (``over_width``). Over ``link`` and ``time``: mean ``moisture`` of the resin; ``water``
        over the dry mass of the link; ``uptake``, the water over that in equilibrium, and beside
        it ``short_time_uptake`` by the law of the root of time and ``shen_springer_uptake`` by
        Shen & Springer's formula, not a number where they do not hold. ``time_to_share`` of the
        equilibrium, and ``mass_balance_error`` over what the link can hold.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "moisture"
    subject = "moisture uptake"
    hallmark = "shen_springer_uptake"
    files = ("moisture_profile.csv", "moisture_uptake.csv", "moisture.nc", "moisture.png")
    significant_digits = 8
    digits = dict.fromkeys(["time_s"], 10)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Profiles at some times, and the uptake over time with the laws beside it."""
        data = self.dataset
        columns: Columns = {**_PROFILE, "moisture_percent": 100 * data["profile"]}
        profile = table_of(data, ("link", "profile_time", "cell"), columns)
        columns = {
            "link": "link",
            "time_s": "time",
            "sqrt_time_sqrt_s": data["time"] ** 0.5,
            "moisture_percent": 100 * data["moisture"],
            **_LAWS,
        }
        uptake = table_of(data, ("link", "time"), columns)
        return {"moisture_profile": profile.dropna(), "moisture_uptake": uptake}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw profiles and uptake of each link, in axes of the user's (two a link) if given."""
        return plots.plot_moisture(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Water in the links at the end, and how long they take to their equilibrium."""
        data, attrs = self.dataset, self.dataset.attrs
        percent = 100 * data[["moisture", "water", "uptake"]].isel(time=-1).to_dataframe()
        times = data["time_to_share"]
        rows = tuple(
            (str(link), *(f"{value:.4g}" for value in water), *map(_duration, times.sel(link=link)))
            for link, *water in percent[["moisture", "water", "uptake"]].itertuples()
        )
        table = Table(
            f"{attrs['mechanism']}: {_duration(data['time'][-1])} at "
            f"{100 * attrs['relative_humidity']:.4g} % relative humidity and "
            f"{attrs['temperature'] - ZERO_CELSIUS:.4g} °C",
            (
                *("link", "water of resin (%)", "water of link (%)", "of equilibrium (%)"),
                *(f"{100 * share:g} % after" for share in times["share"].values),
            ),
            (rows,),
            caption="water over the dry mass of resin and link; time to a share of the equilibrium",
        )
        dry, gap = attrs["links_without_uptake"], float(data["mass_balance_error"].max())
        return Summary(
            (table, *([f"take up no water: {dry}"] if dry else [])),
            f"check: mass of water is balanced within {gap:.1e} of what the links can hold",
        )


def _duration(time: xr.DataArray) -> str:
    seconds = float(time)
    days = from_si(seconds, "day")
    return f"{days:.4g} d" if days >= 1 else f"{from_si(seconds, 'hour'):.4g} h"
