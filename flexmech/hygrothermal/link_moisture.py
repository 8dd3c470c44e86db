"""How moist a link is in a state, which links take up water, and how soft they get."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flexmech.hygrothermal.link_diffusion import LinkDiffusion, link_diffusion
from flexmech.hygrothermal.state import Exposure, State
from flexmech.materials import Layer, moisture_of
from flexmech.materials.moisture import Surroundings
from flexmech.mechanism import Mechanism
from flexmech.sections import Condition

__all__ = ["absorbing_links", "link_condition", "resin_retention", "silent_links"]


def link_condition(mechanism: Mechanism, link: str, state: State) -> Condition:
    """Heat and water in a link's cross-section.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    state : HygrothermalState or Exposure

    Returns
    -------
    Condition

    Raises
    ------
    InputError
        If the link's resin takes up water and it is not known how fast.
    """
    reference = mechanism.reference_temperature
    if not isinstance(state, Exposure):
        return Condition(state.temperature_rise, state.moisture, reference)
    if not state.time or link not in absorbing_links(mechanism):
        return Condition(state.temperature_rise, 0.0, reference)
    moisture = _exposed(
        link_diffusion(mechanism, link),
        state.relative_humidity,
        reference + state.temperature_rise,
        state.time,
    )
    return Condition(state.temperature_rise, moisture, reference)


@lru_cache(maxsize=128)
def _exposed(
    diffusion: LinkDiffusion, relative_humidity: float, temperature: float, time: float
) -> tuple[tuple[float, ...], ...]:
    """Moisture in slices after an exposure; links are often alike, and asked of twice."""
    surroundings = Surroundings.constant(relative_humidity, temperature)
    return diffusion.sliced(diffusion.history(surroundings, np.array([0.0, time])), -1)


def resin_retention(mechanism: Mechanism, link: str, state: State) -> tuple[float, float] | None:
    """Parts of their stiffness and strength that a link's resins keep, where least and most.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    state : HygrothermalState or Exposure

    Returns
    -------
    tuple of float, or None
        None where no resin has a glass transition.

    Raises
    ------
    InputError
        If a resin is above its wet glass transition.
    """
    section = mechanism.sections[link].layers
    if section is None:
        return None
    condition = link_condition(mechanism, link, state)
    kept = [
        resin.hygrothermal.retention(
            condition.temperature, moisture_of(layer.ply, offered), condition.reference_temperature
        )
        for layer, offered in condition.slices(section.laminate)
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


def silent_links(mechanism: Mechanism) -> tuple[str, ...]:
    """Links of which nothing is known that heat or water could do to them.

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
    section = mechanism.sections[link].layers
    return () if section is None else section.laminate.layers


def _takes_water(layer: Layer) -> bool:
    resin = layer.ply.resin
    return resin is not None and resin.hygrothermal.takes_water


def _answers(layer: Layer) -> bool:
    known = layer.ply.resin is not None and layer.ply.resin.hygrothermal.is_known
    return known or any(layer.ply.thermal_expansion) or any(layer.ply.moisture_expansion)
