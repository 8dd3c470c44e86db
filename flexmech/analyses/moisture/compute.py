"""The water in the links of a mechanism in constant ambient conditions, in one dataset."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

from flexmech.analyses.moisture.link_uptake import link_uptake
from flexmech.analyses.moisture.result import MoistureUptake
from flexmech.analyses.provenance import origin
from flexmech.analyses.requests import link_of, mechanism_of
from flexmech.errors import InputError
from flexmech.hygrothermal import absorbing_links, link_diffusion
from flexmech.mechanism import Mechanism
from flexmech.numbers import POSITIVE, Bounds, checked_number
from flexmech.types import FloatArray

__all__ = ["moisture_uptake"]

# Profiles at these parts of the time, uptake at so many times evenly in its root.
PARTS = np.array([0.01, 0.05, 0.2, 0.5, 1.0])
TIMES = 121


def moisture_uptake(
    mechanism: Mechanism,
    relative_humidity: float,
    time: float,
    temperature: float | None = None,
    link: str | None = None,
) -> MoistureUptake:
    """Moisture profiles and uptake of links in constant ambient conditions, from dry.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    relative_humidity : float
        Above 0, up to 1.
    time : float
        Of exposure in s.
    temperature : float, optional
        Of air and links in K; the mechanism's reference temperature if left out.
    link : str, optional
        One link alone; all that take up water if left out.

    Returns
    -------
    MoistureUptake

    Raises
    ------
    InputError
        If a number is out of its range, there is no such link, or the links cannot take up
        water; see :func:`flexmech.hygrothermal.link_diffusion`.
    """
    mechanism = mechanism_of(mechanism)
    end = checked_number(time, "time", "s", POSITIVE)
    humidity = checked_number(relative_humidity, "relative_humidity", "", Bounds(above=0, most=1))
    kelvin = mechanism.reference_temperature if temperature is None else temperature
    kelvin = checked_number(kelvin, "temperature", "K", POSITIVE)
    known, absorbing = mechanism.linkage.topology.link_names, absorbing_links(mechanism)
    names = absorbing if link is None else (link_of(link, known),)
    if not names:
        raise InputError(
            f"{mechanism.provenance.file or 'mechanism'}: no link takes up water; add "
            "equilibrium_moisture and diffusivity to a material or a matrix"
        )
    # Rounded, so that a time that is in both lists comes once.
    roots = np.round(np.concatenate([np.linspace(0.0, 1.0, TIMES), np.sqrt(PARTS)]), 12)
    times = end * np.unique(roots) ** 2
    parts = np.abs(times - end * PARTS[:, np.newaxis]).argmin(axis=1)
    links = [
        link_uptake(link_diffusion(mechanism, name), humidity, kelvin, times, parts)
        for name in names
    ]
    # Links with fewer cells than others end with places that are not numbers.
    dataset = xr.concat(links, pd.Index(names, name="link"), join="outer")
    dataset["water"] = dataset["water"] * xr.DataArray(_faces_over_mass(mechanism, names), dims="link")
    attributes = {
        **origin(mechanism),
        "relative_humidity": humidity,
        "temperature": kelvin,
        "links_without_uptake": ", ".join(name for name in known if name not in absorbing),
    }
    return MoistureUptake(dataset.assign_attrs(attributes))
