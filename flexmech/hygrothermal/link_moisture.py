"""Moisture of a link in an environment, links that take up water, and how soft these get."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flexmech.hygrothermal.environment import Environment, Exposure
from flexmech.hygrothermal.link_diffusion import LinkDiffusion, link_diffusion
from flexmech.materials import Layer, moisture_of
from flexmech.materials.moisture import Ambient
from flexmech.mechanism import Mechanism
from flexmech.sections import HygrothermalProfile


def link_profile(mechanism: Mechanism, link: str, environment: Environment) -> HygrothermalProfile:
    """Temperature and moisture through a link's thickness in an environment.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    environment : HygrothermalState or Exposure

    Returns
    -------
    HygrothermalProfile

    Raises
    ------
    InputError
        If the link's resin takes up water and it is not known how fast.
    """
    reference = mechanism.reference_temperature
    if not isinstance(environment, Exposure):
        return HygrothermalProfile(environment.temperature_rise, environment.moisture, reference)
    if not environment.time or link not in absorbing_links(mechanism):
        return HygrothermalProfile(environment.temperature_rise, 0.0, reference)
    moisture = _exposed(
        link_diffusion(mechanism, link),
        environment.relative_humidity,
        reference + environment.temperature_rise,
        environment.time,
    )
    return HygrothermalProfile(environment.temperature_rise, moisture, reference)


@lru_cache(maxsize=128)
def _exposed(
    diffusion: LinkDiffusion, relative_humidity: float, temperature: float, time: float
) -> tuple[tuple[float, ...], ...]:
    """Moisture in slices after an exposure. Cached: links of a mechanism are often alike."""
    ambient = Ambient.constant(relative_humidity, temperature)
    return diffusion.sliced(diffusion.history(ambient, np.array([0.0, time])), -1)


def resin_retention(
    mechanism: Mechanism, link: str, environment: Environment
) -> tuple[float, float] | None:
    """Parts of their stiffness that a link's resins keep, where least and most.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    environment : HygrothermalState or Exposure

    Returns
    -------
    tuple of float, or None
        None where no resin has a glass transition.

    Raises
    ------
    InputError
        If a resin is above its wet glass transition.
    """
    section = mechanism.layers_of(link)
    if section is None:
        return None
    profile = link_profile(mechanism, link, environment)
    kept = [
        resin.hygrothermal.retention(
            profile.temperature, moisture_of(layer.ply, offered), profile.reference_temperature
        )
        for layer, offered in profile.slices(section.laminate)
        if (resin := layer.ply.resin) is not None
        and resin.hygrothermal.glass_transition is not None
    ]
    return (min(kept), max(kept)) if kept else None


def absorbing_links(mechanism: Mechanism) -> tuple[str, ...]:
    """Links with a resin that takes up water.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    tuple of str
    """
    names = mechanism.linkage.topology.link_names
    return tuple(name for name in names if any(_takes_water(p) for p in _layers(mechanism, name)))


def inert_links(mechanism: Mechanism) -> tuple[str, ...]:
    """Links whose materials state no response to heat and water.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    tuple of str
    """
    return tuple(
        name
        for name in mechanism.linkage.topology.link_names
        if not any(_answers(layer) for layer in _layers(mechanism, name))
    )


def _layers(mechanism: Mechanism, link: str) -> tuple[Layer, ...]:
    section = mechanism.layers_of(link)
    return () if section is None else section.laminate.layers


def _takes_water(layer: Layer) -> bool:
    resin = layer.ply.resin
    return resin is not None and resin.hygrothermal.takes_water


def _answers(layer: Layer) -> bool:
    known = layer.ply.resin is not None and layer.ply.resin.hygrothermal.is_known
    return known or any(layer.ply.thermal_expansion) or any(layer.ply.moisture_expansion)
