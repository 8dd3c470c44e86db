"""Diffusion of water into a link: its layers, and the moisture of their resin."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmech.errors import InputError
from flexmech.materials import Layer, PlyComposition, ResinContent
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
from flexmech.types import FloatArray

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

    def history(self, ambient: Ambient, times: FloatArray) -> MoistureHistory:
        """Water in the link over time, from dry.

        Parameters
        ----------
        ambient : Ambient
        times : ndarray, shape (t,)
            In s.

        Returns
        -------
        MoistureHistory
        """
        through = CELLS if self.width is None else BAR_CELLS[0]
        cells = max(through, CELLS_A_LAYER * len(self.layers))
        settings: dict[str, Any] = {
            "faces": self.faces,
            "humidity_exponent": self.humidity_exponent,
            "tolerance": TOLERANCE,
        }
        if self.width is None:
            return diffuse(self.layers, ambient, times, cells=cells, **settings)
        cells_of_bar = cells, BAR_CELLS[1]
        return diffuse_bar(self.layers, self.width, ambient, times, cells=cells_of_bar, **settings)

    def sliced(self, history: MoistureHistory, number: int) -> tuple[tuple[float, ...], ...]:
        """Moisture of the resin in slices of each layer at one of the times.

        Parameters
        ----------
        history : MoistureHistory
            Of this link.
        number : int
            Of the time.

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
        held = np.concatenate([[0.0], np.cumsum(steps)])
        thickness = np.array([layer.thickness for layer in self.layers])
        ends = history.boundaries[0] + np.concatenate([[0.0], np.cumsum(thickness)])
        moisture = []
        for layer, greatest in enumerate(self.saturation):
            count = max(1, round(SLICES * thickness[layer] / thickness.sum()))
            faces = np.linspace(ends[layer], ends[layer + 1], count + 1)
            mean = np.diff(np.interp(faces, history.boundaries, held)) / np.diff(faces)
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
        width=section.width if wetting.sides else None,
    )


def _uptake(link: str, layer: Layer) -> tuple[ResinContent, MoistureEquilibrium, Diffusivity]:
    """Resin of a layer with its equilibrium and its diffusivity, refused where one is missing."""
    resin = layer.ply.resin
    what = f"links.{link}: ply {layer.ply.name!r}" if layer.ply.name else f"links.{link}: its resin"
    if resin is None or not resin.hygrothermal.takes_water:
        raise InputError(
            f"{what} takes up no water and stands between layers that do; give its resin, or "
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
