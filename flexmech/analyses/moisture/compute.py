"""The water in the links of a mechanism in constant ambient conditions, in one dataset.

The result of moisture uptake: its tables, picture and words.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import origin
from flexmech.analyses.digits import Quantity, percent, plain, rounded
from flexmech.analyses.frequencies.discretisation import share_of_error
from flexmech.analyses.options import MoistureOptions
from flexmech.analyses.requests import asks, link_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import LinkDiffusion, absorbing_links, link_diffusion
from flexmech.materials.moisture import (
    Ambient,
    MoistureHistory,
    shen_springer_uptake,
    short_time_uptake,
    time_to_saturation,
)
from flexmech.mechanics import checked_mechanism
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection
from flexmech.units import ZERO_CELSIUS, from_si
from flexmech.validation import POSITIVE, Bounds, checked_number

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
        Conventions, title, date and command line of the file that it was loaded from.
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
        balance = f"mass of water is balanced within {gap:.1e} of the water that the links can hold"
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
        yield f"After {after} {who} {_share(end, wettest)} of the equilibrium moisture."
    else:
        yield (
            f"After {after} the {wettest} has {_share(end, wettest)} of its equilibrium moisture, "
            f"the {driest} {_share(end, driest)}."
        )
    slowest = _link_at(data["time_to_share"].sel(share=_SATURATED), "argmax")
    yield (
        f"The {slowest} reaches {100 * _SATURATED:g} % of it after "
        f"{_time_to(data, slowest, _SATURATED)}, "
        f"with water of {_final_share(end, slowest)} of its dry mass."
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
    of_link = end.sel(link=link)
    value = 100 * float(of_link[name])
    return value, value * float(of_link["uptake_error"] / of_link["uptake"])


def _share(end: xr.Dataset, link: str) -> str:
    return f"{rounded(*_water(end, link, 'uptake'))} %"


def _final_share(end: xr.Dataset, link: str) -> str:
    """Water of a saturated link over its dry mass: of links and air alone, without an error."""
    of_link = end.sel(link=link)
    return f"{plain(100 * _SATURATED * float(of_link['water'] / of_link['uptake']))} %"


def _time_to(data: xr.Dataset, link: str, share: float) -> str:
    of_link = data.sel(link=link, share=share)
    time = float(of_link["time_to_share"])
    relative = float(of_link["time_to_share_error"]) / time
    return _in_days(time, lambda value: rounded(value, relative * value))


def _numbers(data: xr.Dataset) -> Iterator[Quantity]:
    """Water of resin and link in the end, and times to saturation."""
    end = data.isel(time=-1)
    for link in data["link"].values.tolist():
        for name in ("moisture", "water", "uptake"):
            value, error = _water(end, link, name)
            yield Quantity(name, value, "%", error, str(link))
        of_link = data.sel(link=link, share=_SATURATED)
        days = (
            from_si(float(of_link[name]), "day")
            for name in ("time_to_share", "time_to_share_error")
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


def _in_days(seconds: float, written: Callable[[float], str]) -> str:
    """A time in days, or in hours where it is less than one."""
    unit, name = ("day", "d") if from_si(seconds, "day") >= 1 else ("hour", "h")
    return f"{written(from_si(seconds, unit))} {name}"


# Profiles at these parts of the time, uptake at so many times evenly in its root, in which it
# begins as a straight line; and shares of the water in equilibrium that laboratories wait for.
_PARTS = np.array([0.01, 0.05, 0.2, 0.5, 1.0])
_TIMES = 121
_SHARES = np.array([0.5, 0.9, 0.99])
# Cells in each direction of the solution that another one is compared with, over its own.
_FINER = 2
# Times of a history from which times to shares are read.
_TIMES_TO_SHARES = 400
# Longest time over the time scale of filling; a slab is full to 1e-17 by then.
_LONGEST = 40.0


@asks(MoistureOptions)
def moisture_uptake(mechanism: Mechanism, asked: MoistureOptions) -> MoistureUptake:
    """Moisture profiles and uptake of links in constant ambient conditions, from dry.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.

    Returns
    -------
    MoistureUptake

    Raises
    ------
    InputError
        If a number is out of its range, there is no such link, or the links cannot take up
        water; see :func:`flexmech.hygrothermal.link_moisture`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/moist_composite_fourbar.toml")
    >>> found = flexmech.moisture_uptake(mechanism, 0.85, 30 * 86400, 353.15, link="rocker")
    >>> found.dataset["uptake"].values[:, -1].round(3)
    array([0.596])
    """
    mechanism = checked_mechanism(mechanism)
    temperature, link = asked.temperature, asked.link
    end = checked_number(asked.time, "time", "s", POSITIVE)
    humidity = checked_number(
        asked.relative_humidity, "relative_humidity", "", Bounds(above=0, most=1)
    )
    kelvin = mechanism.reference_temperature if temperature is None else temperature
    kelvin = checked_number(kelvin, "temperature", "K", POSITIVE)
    known, absorbing = mechanism.linkage.topology.link_names, absorbing_links(mechanism)
    names = absorbing if link is None else (link_of(link, known),)
    if not names:
        raise InputError(
            "links: none takes up water; add equilibrium_moisture and diffusivity to a material or "
            "a matrix"
        )
    links = [
        _link(link_diffusion(mechanism, name), mechanism.sections[name], humidity, kelvin, end)
        for name in names
    ]
    # Links with fewer cells than others end with places that are not numbers.
    dataset = xr.concat(links, "link", join="outer").assign_coords(link=list(names))
    attributes = {
        **origin(mechanism),
        "relative_humidity": humidity,
        "temperature": kelvin,
        "links_without_uptake": ", ".join(name for name in known if name not in absorbing),
    }
    return MoistureUptake(dataset.assign_attrs(attributes))


def _link(
    diffusion: LinkDiffusion, section: BeamSection, humidity: float, kelvin: float, end: float
) -> xr.Dataset:
    """Water in one link over time."""
    # Rounded, so that a time that is in both lists comes once.
    roots = np.round(np.concatenate([np.linspace(0.0, 1.0, _TIMES), np.sqrt(_PARTS)]), 12)
    times = end * np.unique(roots) ** 2
    parts = np.abs(times - end * _PARTS[:, np.newaxis]).argmin(axis=1)
    history, finer = (_history(diffusion, humidity, kelvin, tuple(times), n) for n in (1, _FINER))
    final = _final(diffusion, humidity)
    error = np.abs(history.uptake - finer.uptake) / final / share_of_error(1, _FINER)
    shares, shares_error = _times_to_shares(diffusion, humidity, kelvin)
    short_time, shen_springer = _laws(diffusion, kelvin, times)
    layers, saturation = diffusion.layers, np.array(diffusion.saturation)
    of_layers = zip(layers, saturation, strict=True)
    resin = sum(layer.thickness * layer.capacity / greatest for layer, greatest in of_layers)
    tops = np.cumsum([one.thickness for one in layers])
    layer_of_cell = np.searchsorted(tops - tops[-1] / 2, history.place).clip(max=len(layers) - 1)
    profile = history.saturation[parts] * saturation[layer_of_cell]
    assert section.layers is not None
    water = history.water * section.layers.breadth / section.mass_per_length
    return MoistureUptake.schema().dataset(
        {
            "place": history.place,
            "profile": profile,
            "moisture": history.water / resin,
            "water": water,
            "uptake": history.uptake / final,
            "uptake_error": error,
            "short_time_uptake": short_time,
            "shen_springer_uptake": shen_springer,
            "time_to_share": shares,
            "time_to_share_error": shares_error,
            "mass_balance_error": history.mass_balance_error,
            "cell": np.arange(history.place.size),
            "time": times,
            "profile_time": times[parts],
            "share": _SHARES,
            "over_width": diffusion.width is not None,
        },
    )


def _final(diffusion: LinkDiffusion, humidity: float) -> float:
    """Saturation of all layers in the end."""
    return float(humidity**diffusion.humidity_exponent)


def _slab(diffusion: LinkDiffusion, kelvin: float) -> tuple[float, float] | None:
    """Thickness in m and diffusivity in m^2/s, if the link is one homogeneous slab.

    Layers that hold more water than others are no slab either, though water moves as fast.
    """
    layers = diffusion.layers
    laws = {(float(one.diffusivity.at(kelvin)), one.capacity) for one in layers}
    if len(laws) > 1 or diffusion.width is not None:
        return None
    return sum(one.thickness for one in layers), laws.pop()[0]


def _laws(diffusion: LinkDiffusion, kelvin: float, times: FloatArray) -> FloatArray:
    """Uptake by the law of the root of time and by Shen & Springer's formula, (2, t).

    Both are of a homogeneous slab, and not a number for any other link.
    """
    slab = _slab(diffusion, kelvin)
    if slab is None:
        return np.full((2, times.size), np.nan)
    root = np.minimum(short_time_uptake(times, *slab, faces=diffusion.faces), 1.0)
    return np.stack([root, shen_springer_uptake(times, *slab, faces=diffusion.faces)])


def _times_to_shares(
    diffusion: LinkDiffusion, humidity: float, kelvin: float
) -> tuple[FloatArray, FloatArray]:
    """Times in s at which the link has its shares of the equilibrium, and their errors in s.

    By the series where there is one, which is exact but for round-off; else from the finite
    volumes, whose error is estimated by finer cells and more times.
    """
    slab = _slab(diffusion, kelvin)
    if slab is not None:
        exact = [time_to_saturation(share, *slab, faces=diffusion.faces) for share in _SHARES]
        return np.array(exact), ROUND_OFF * np.array(exact)
    shares, finer = (_shares_by_volumes(diffusion, humidity, kelvin, n) for n in (1, _FINER))
    return shares, np.abs(shares - finer) / share_of_error(1, _FINER)


def _shares_by_volumes(
    diffusion: LinkDiffusion, humidity: float, kelvin: float, finer: int
) -> FloatArray:
    """Times to shares from finite volumes, with so many times the cells and times."""
    # The time in the scale of which the link fills.
    layers = [(one.thickness, float(one.diffusivity.at(kelvin))) for one in diffusion.layers]
    root = sum(thickness / np.sqrt(diffusivity) for thickness, diffusivity in layers)
    scale = float(root**2) * (1 if diffusion.faces == "both" else 4) / np.pi**2
    rising = np.geomspace(1e-4 * scale, _LONGEST * scale, finer * _TIMES_TO_SHARES)
    times = np.concatenate([[0.0], rising])
    history = _history(diffusion, humidity, kelvin, tuple(times), finer)
    uptake = history.uptake / _final(diffusion, humidity)
    if uptake[-1] < _SHARES[-1]:
        raise ComputationError(
            f"{100 * _SHARES[-1]:g} % of the equilibrium is not reached in {times[-1]:.3g} s; "
            "check the layers' diffusivities and thicknesses"
        )
    # Near the end what is left falls exponentially: straight in its logarithm.
    left = -np.log(np.clip(1 - uptake, 1e-12, 1.0))
    return np.asarray(np.interp(-np.log(1 - _SHARES), left, times))


@lru_cache(maxsize=32)
def _history(
    diffusion: LinkDiffusion, humidity: float, kelvin: float, times: tuple[float, ...], finer: int
) -> MoistureHistory:
    """Water over time; links are often alike."""
    return diffusion.history(Ambient.constant(humidity, kelvin), np.array(times), finer)
