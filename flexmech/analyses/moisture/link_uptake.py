"""How one link takes up water in constant ambient conditions, over time."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import xarray as xr

from flexmech.errors import ComputationError
from flexmech.hygrothermal import LinkDiffusion
from flexmech.materials.moisture import (
    MoistureHistory,
    Surroundings,
    shen_springer_uptake,
    short_time_uptake,
    time_to_saturation,
)
from flexmech.types import FloatArray, IntArray

__all__ = ["link_uptake"]

SHARES = np.array([0.5, 0.9, 0.99])
# Of the time scale of filling; a slab is full to 1e-17 by then.
LONGEST = 40.0


def link_uptake(
    diffusion: LinkDiffusion,
    relative_humidity: float,
    temperature: float,
    times: FloatArray,
    profile_times: IntArray,
) -> xr.Dataset:
    """Water in a link over time, from dry.

    Parameters
    ----------
    diffusion : LinkDiffusion
    relative_humidity : float
        Above 0, up to 1.
    temperature : float
        In K.
    times : ndarray, shape (t,)
        In s, rising from zero.
    profile_times : ndarray of int
        Indices of the times that profiles are of.

    Returns
    -------
    xarray.Dataset
        Variables of :class:`flexmech.analyses.moisture.MoistureUptake`; ``water`` in kg per m^2
        of the faces.
    """
    ambient = relative_humidity, temperature
    history = _history(diffusion, *ambient, tuple(times))
    layers, saturation = diffusion.layers, np.array(diffusion.saturation)
    resin = [one.thickness * one.capacity for one in layers] / saturation
    faces = np.cumsum([layer.thickness for layer in layers])
    layer_of_cell = np.searchsorted(faces - faces[-1] / 2, history.place).clip(max=len(layers) - 1)
    profile = (history.saturation * saturation[layer_of_cell])[profile_times]
    laws, times_to = _laws(diffusion, temperature, times), _times_to_shares(diffusion, *ambient)
    one, second = {"units": "1"}, {"units": "s"}
    return xr.Dataset(
        {
            "place": ("cell", history.place, {"units": "m"}),
            "profile": (("profile_time", "cell"), profile, one),
            "moisture": ("time", history.water / resin.sum(), one),
            "water": ("time", history.water, one),
            "uptake": ("time", history.uptake / _final(diffusion, relative_humidity), one),
            "short_time_uptake": ("time", laws[0], one),
            "shen_springer_uptake": ("time", laws[1], one),
            "time_to_share": ("share", times_to, second),
            "mass_balance_error": ((), history.mass_balance_error, one),
        },
        {
            "cell": np.arange(history.place.size),
            "time": ("time", times, second),
            "profile_time": ("profile_time", times[profile_times], second),
            "share": SHARES,
            "over_width": diffusion.width is not None,
        },
    )
