"""Moisture of a link in an environment: layers that water diffuses into, and how soft they get."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal.environment import Environment, Exposure
from flexmech.materials import Layer, PlyComposition, ResinContent, moisture_of
from flexmech.materials.moisture import (
    Ambient,
    DiffusionLayer,
    Diffusivity,
    Faces,
    MoistureEquilibrium,
    MoistureHistory,
    composite_diffusivity_ratio,
    diffuse,
    diffuse_bar,
)
from flexmech.mechanism import Mechanism
from flexmech.sections import HygrothermalProfile

# Slices of a link through its thickness, each with the mean moisture inside it, and the cells
# and the tolerance that it is computed with: good to some 1e-5 of the saturation.
SLICES = 32
CELLS, BAR_CELLS = 400, (100, 48)
CELLS_A_LAYER = 16
TOLERANCE = 1e-6


@dataclass(frozen=True)
class LinkDiffusion:
    """Layers of a link that water diffuses into, and the surfaces that are exposed.

    Parameters
    ----------
    layers : tuple of DiffusionLayer
        From the lowest up.
    saturation : tuple of float
        Moisture of each layer's resin at 100 % relative humidity.
    humidity_exponent : float
    faces : {"both", "lower", "upper"}
        Which faces are exposed.
    width : float, optional
        In m, where water comes in through the sides too.
    """

    layers: tuple[DiffusionLayer, ...]
    saturation: tuple[float, ...]
    humidity_exponent: float
    faces: Faces
    width: float | None

    def history(self, ambient: Ambient, times: FloatArray, finer: int = 1) -> MoistureHistory:
        """Water in the link over time, from dry.

        Parameters
        ----------
        ambient : Ambient
        times : ndarray, shape (t,)
            In s.
        finer : int
            Cells in each direction over those that are usual; the tolerance in time falls with
            their square, as the error by the cells does.

        Returns
        -------
        MoistureHistory
        """
        through = CELLS if self.width is None else BAR_CELLS[0]
        cells = finer * max(through, CELLS_A_LAYER * len(self.layers))
        settings: dict[str, Any] = {
            "faces": self.faces,
            "humidity_exponent": self.humidity_exponent,
            "tolerance": TOLERANCE / finer**2,
        }
        if self.width is None:
            return diffuse(self.layers, ambient, times, cells=cells, **settings)
        cells_of_bar = cells, finer * BAR_CELLS[1]
        return diffuse_bar(self.layers, self.width, ambient, times, cells=cells_of_bar, **settings)

    def sliced(self, history: MoistureHistory, number: int) -> tuple[tuple[float, ...], ...]:
        """Moisture of the resin in slices of each layer at one of the times.

        Parameters
        ----------
        history : MoistureHistory
            History of this link.
        number : int
            Number of the time.

        Returns
        -------
        tuple of tuple of float
            As :class:`flexmech.sections.HygrothermalProfile` takes it.
        """
        saturation = history.saturation[number]
        if self._is_symmetric:
            # The exact profile is symmetric, and half the difference is the solver's error. It
            # must not bend the link.
            saturation = (saturation + saturation[::-1]) / 2
        steps = saturation * np.diff(history.boundaries)
        content = np.concatenate([[0.0], np.cumsum(steps)])
        thickness = np.array([layer.thickness for layer in self.layers])
        ends = history.boundaries[0] + np.concatenate([[0.0], np.cumsum(thickness)])
        moisture = []
        for layer, greatest in enumerate(self.saturation):
            count = max(1, round(SLICES * thickness[layer] / thickness.sum()))
            faces = np.linspace(ends[layer], ends[layer + 1], count + 1)
            mean = np.diff(np.interp(faces, history.boundaries, content)) / np.diff(faces)
            moisture.append(tuple(float(m) for m in np.clip(mean, 0.0, 1.0) * greatest))
        return tuple(moisture)

    @property
    def _is_symmetric(self) -> bool:
        mirrored = self.layers[::-1], self.saturation[::-1]
        return self.faces == "both" and mirrored == (self.layers, self.saturation)


def link_diffusion(mechanism: Mechanism, link: str) -> LinkDiffusion:
    """Layers of a link that water diffuses into, from its section and its wetting.

    Parameters
    ----------
    mechanism : Mechanism
    link : str

    Returns
    -------
    LinkDiffusion

    Raises
    ------
    InputError
        If a layer takes up no water, its equilibrium or diffusivity is not known, or layers
        answer differently to humidity.
    """
    section = mechanism.layers_of(link)
    if section is None:
        raise InputError(f"links.{link}: its layers are not known, so water cannot diffuse into it")
    plies = [(layer, *_uptake(link, layer)) for layer in section.laminate.layers]
    exponents = {equilibrium.humidity_exponent for _, _, equilibrium, _ in plies}
    if len(exponents) > 1:
        raise InputError(
            f"links.{link}: its layers have different humidity_exponents "
            f"({', '.join(f'{e:g}' for e in sorted(exponents))}), so that none of them is in "
            "balance with the next; give all the same"
        )
    wetting = mechanism.wetting_of(link)
    return LinkDiffusion(
        layers=tuple(_diffusion_layer(*ply) for ply in plies),
        saturation=tuple(equilibrium.saturation for _, _, equilibrium, _ in plies),
        humidity_exponent=exponents.pop(),
        faces=wetting.faces,
        width=section.breadth if wetting.sides else None,
    )


def _uptake(link: str, layer: Layer) -> tuple[ResinContent, MoistureEquilibrium, Diffusivity]:
    """Resin of a layer with its equilibrium and its diffusivity, refused where one is missing."""
    resin = layer.ply.resin
    what = f"links.{link}: ply {layer.ply.name!r}" if layer.ply.name else f"links.{link}: its resin"
    if resin is None or not resin.hygrothermal.takes_water:
        raise InputError(
            f"{what} takes up no water but lies between layers that do; give its resin, or "
            "state the moisture of the links instead of humidity and time"
        )
    equilibrium, diffusivity = resin.hygrothermal.equilibrium, resin.hygrothermal.diffusivity
    if equilibrium is None or diffusivity is None:
        key = "equilibrium_moisture" if equilibrium is None else "diffusivity"
        raise InputError(
            f"{what} has no {key}, which water diffusing into it needs; add it, or state the "
            "moisture of the links instead of humidity and time"
        )
    return resin, equilibrium, diffusivity


def _diffusion_layer(
    layer: Layer, resin: ResinContent, equilibrium: MoistureEquilibrium, diffusivity: Diffusivity
) -> DiffusionLayer:
    along, across = 1.0, 1.0
    if resin.volume_fraction < 1:
        along, across = composite_diffusivity_ratio(1 - resin.volume_fraction)
    woven = isinstance(layer.ply.origin, PlyComposition) and layer.ply.origin.woven
    share = 0.5 if woven else float(np.sin(layer.angle) ** 2)
    ratio_across_width = along * share + across * (1 - share)
    return DiffusionLayer(
        thickness=layer.thickness,
        diffusivity=replace(diffusivity, value=diffusivity.value * across),
        capacity=equilibrium.saturation * resin.mass_fraction * layer.ply.density,
        diffusivity_across=replace(diffusivity, value=diffusivity.value * ratio_across_width),
    )


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
