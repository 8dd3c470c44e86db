"""The result of moisture uptake: its tables, picture and words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import xarray as xr

from flexmech import plots
from flexmech.analyses.digits import Quantity, percent, plain, rounded
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.units import ZERO_CELSIUS, from_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class MoistureUptake(Result):
    """Water in the links of a mechanism over time, from dry.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: over (link, time) water of resin and link, and beside the
        uptake two laws that are not a number where they do not hold; profiles over
        (link, profile_time, cell), a mean over the width where water enters through the sides too
        (``over_width``).
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "moisture"
    subject = "moisture uptake"
    hallmark = "shen_springer_uptake"
    significant_digits = 8
    digits = dict.fromkeys(["time_s"], 10)

    def tabulated(self) -> xr.Dataset:
        """The dataset with moisture as percentages, and the root of time."""
        data = self.dataset
        return data.assign(
            percent_in_cell=100 * data["profile"],
            percent=100 * data["moisture"],
            root_of_time=data["time"] ** 0.5,
        )

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw profiles and uptake of each link, in axes of the user's (two a link) if given."""
        return plots.plot_moisture(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Water in the links at the end, how long they take to their equilibrium, and errors."""
        data, attrs = self.dataset, self.dataset.attrs
        end, times = data.isel(time=-1), data["time_to_share"]
        rows = tuple(
            (
                link,
                *(rounded(*_water(end, link, name)) for name in ("moisture", "water", "uptake")),
                *(_time_to(data, link, share) for share in times["share"].values),
            )
            for link in map(str, times["link"].values)
        )
        table = Table(
            f"{attrs['mechanism']}: {_exposure(end)} at "
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
        balance = f"mass of water is balanced within {gap:.1e} of what the links can hold"
        return Summary(
            tuple(_answer(data)),
            table,
            _trust(data),
            (f"check: {balance}", *([f"take up no water: {dry}"] if dry else [])),
            numbers=tuple(_numbers(data)),
        )


# Share of the water in equilibrium at which laboratories call a specimen saturated.
_SATURATED = 0.99


def _answer(data: xr.Dataset) -> Iterator[str]:
    """Water in the end, and when the slowest link is saturated."""
    end = data.isel(time=-1)
    wettest, driest = (_link_at(end["uptake"], pick) for pick in ("argmax", "argmin"))
    after = _exposure(end)
    if len({_share(end, str(link)) for link in end["link"].values}) == 1:
        who = f"the {wettest} has" if data.sizes["link"] == 1 else "each link has"
        yield f"After {after} {who} {_share(end, wettest)} of the water that it takes up."
    else:
        yield (
            f"After {after} the {wettest} has {_share(end, wettest)} of the water that it takes "
            f"up, the {driest} {_share(end, driest)}."
        )
    slowest = _link_at(data["time_to_share"].sel(share=_SATURATED), "argmax")
    yield (
        f"The {slowest} has {100 * _SATURATED:g} % of it after "
        f"{_time_to(data, slowest, _SATURATED)}; "
        f"water is then {_final(end, slowest)} of its dry mass."
    )


def _link_at(values: xr.DataArray, pick: str) -> str:
    return str(values["link"].values[getattr(values.values, pick)()])


def _water(end: xr.Dataset, link: str, name: str) -> tuple[float, float]:
    """Moisture, water or uptake of a link in percent, and its error: all have that of the uptake.

    Parameters
    ----------
    end : xarray.Dataset
        At one time.
    link : str
    name : {"moisture", "water", "uptake"}
    """
    own = end.sel(link=link)
    value = 100 * float(own[name])
    return value, value * float(own["uptake_error"] / own["uptake"])


def _share(end: xr.Dataset, link: str) -> str:
    return f"{rounded(*_water(end, link, 'uptake'))} %"


def _final(end: xr.Dataset, link: str) -> str:
    """Water of a saturated link over its dry mass: of links and air alone, without an error."""
    own = end.sel(link=link)
    return f"{plain(100 * _SATURATED * float(own['water'] / own['uptake']))} %"


def _time_to(data: xr.Dataset, link: str, share: float) -> str:
    own = data.sel(link=link, share=share)
    time = float(own["time_to_share"])
    relative = float(own["time_to_share_error"]) / time
    return _in_days(time, lambda value: rounded(value, relative * value))


def _numbers(data: xr.Dataset) -> Iterator[Quantity]:
    """Water of resin and link in the end, and times to saturation."""
    end = data.isel(time=-1)
    for link in data["link"].values.tolist():
        for name in ("moisture", "water", "uptake"):
            value, error = _water(end, link, name)
            yield Quantity(name, value, "%", error, str(link))
        own = data.sel(link=link, share=_SATURATED)
        days = (
            from_si(float(own[name]), "day") for name in ("time_to_share", "time_to_share_error")
        )
        time, error = days
        yield Quantity("time_to_saturation", time, "day", error, str(link))


def _trust(data: xr.Dataset) -> str:
    """How far water and times are known, by cells half as large."""
    end = data.isel(time=-1)
    water = end["uptake_error"] / end["uptake"]
    times = data["time_to_share_error"] / data["time_to_share"]
    worst = max(float(water.max()), float(times.max()))
    if not math.isfinite(worst):
        return "errors of the numbers are not estimated"
    return (
        f"numbers are known to {percent(worst)}, estimated by cells half as large; diffusivity "
        "and equilibrium are those of the model file"
    )


def _exposure(end: xr.Dataset) -> str:
    """Time of exposure, as it was asked for."""
    return _in_days(float(end["time"]), plain)


def _in_days(seconds: float, told: Callable[[float], str]) -> str:
    """A time in days, or in hours where it is less than one."""
    unit, name = ("day", "d") if from_si(seconds, "day") >= 1 else ("hour", "h")
    return f"{told(from_si(seconds, unit))} {name}"
