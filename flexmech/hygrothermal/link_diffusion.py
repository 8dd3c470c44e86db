"""What water meets on its way into a link, and where it is there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.materials import Laminate, Layer, PlyComposition
from flexmech.materials.moisture import (
    DiffusionLayer,
    Diffusivity,
    Faces,
    MoistureHistory,
    Surroundings,
    composite_diffusivity_ratio,
    diffuse,
    diffuse_bar,
)
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["LinkDiffusion", "link_diffusion"]


# Slices of a link through its thickness, each with the mean moisture inside it, and the cells
# and the tolerance that it is computed with: good to some 1e-5 of the saturation.
SLICES = 32
CELLS, BAR_CELLS = 400, (100, 48)
CELLS_A_LAYER = 16
TOLERANCE = 1e-6


@dataclass(frozen=True)
class LinkDiffusion:
    """What water meets on its way into a link.

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

    def history(self, surroundings: Surroundings, times: FloatArray) -> MoistureHistory:
        """Water in the link over time, from dry.

        Parameters
        ----------
        surroundings : Surroundings
        times : ndarray, shape (t,)
            In s.

        Returns
        -------
        MoistureHistory
        """
        if self.width is None:
            return diffuse(
                self.layers,
                surroundings,
                times,
                faces=self.faces,
                humidity_exponent=self.humidity_exponent,
                cells=max(CELLS, CELLS_A_LAYER * len(self.layers)),
                tolerance=TOLERANCE,
            )
        return diffuse_bar(
            self.layers,
            self.width,
            surroundings,
            times,
            faces=self.faces,
            humidity_exponent=self.humidity_exponent,
            cells=(max(BAR_CELLS[0], CELLS_A_LAYER * len(self.layers)), BAR_CELLS[1]),
            tolerance=TOLERANCE,
        )

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
            As :class:`flexmech.sections.Condition` takes it.
        """
        saturation = history.saturation[number]
        if self._is_symmetric:
            # Both halves are one problem: what its solver leaves between them is no curvature.
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
    """What water meets on its way into a link.

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
    section = mechanism.sections[link].layers
    if section is None:
        raise InputError(f"links.{link}: its layers are not known, so water cannot diffuse into it")
    laminate = section.laminate
    exponents = {_equilibrium_exponent(link, layer) for layer in laminate.layers}
    if len(exponents) > 1:
        raise InputError(
            f"links.{link}: its layers have different humidity_exponents "
            f"({', '.join(f'{e:g}' for e in sorted(exponents))}), so that none of them is in "
            "balance with the next; give all the same"
        )
    wetting = mechanism.wetting_of(link)
    return LinkDiffusion(
        layers=tuple(_diffusion_layer(layer) for layer in laminate.layers),
        saturation=_saturation(laminate),
        humidity_exponent=exponents.pop(),
        faces=wetting.faces,
        width=section.width if wetting.sides else None,
    )


def _equilibrium_exponent(link: str, layer: Layer) -> float:
    """Humidity exponent of a layer that water can diffuse into."""
    resin = layer.ply.resin
    what = f"links.{link}: ply {layer.ply.name!r}" if layer.ply.name else f"links.{link}: its resin"
    if resin is None or not resin.hygrothermal.takes_water:
        raise InputError(
            f"{what} takes up no water and stands between layers that do; give its resin, or "
            "state the moisture of the links instead of humidity and time"
        )
    for key, value in (
        ("equilibrium_moisture", resin.hygrothermal.equilibrium),
        ("diffusivity", resin.hygrothermal.diffusivity),
    ):
        if value is None:
            raise InputError(
                f"{what} has no {key}, which water diffusing into it needs; add it, or state the "
                "moisture of the links instead of humidity and time"
            )
    assert resin.hygrothermal.equilibrium is not None
    return resin.hygrothermal.equilibrium.humidity_exponent


def _diffusion_layer(layer: Layer) -> DiffusionLayer:
    resin = layer.ply.resin
    assert resin is not None
    assert resin.hygrothermal.equilibrium is not None
    own = resin.hygrothermal.diffusivity
    assert own is not None
    along, across = 1.0, 1.0
    if resin.volume_fraction < 1:
        along, across = composite_diffusivity_ratio(1 - resin.volume_fraction)
    woven = isinstance(layer.ply.origin, PlyComposition) and layer.ply.origin.woven
    share = 0.5 if woven else float(np.sin(layer.angle) ** 2)
    water = resin.hygrothermal.equilibrium.saturation * resin.mass_fraction * layer.ply.density
    return DiffusionLayer(
        thickness=layer.thickness,
        diffusivity=_scaled(own, across),
        capacity=water,
        diffusivity_across=_scaled(own, along * share + across * (1 - share)),
    )


def _scaled(diffusivity: Diffusivity, ratio: float) -> Diffusivity:
    return Diffusivity(
        diffusivity.value * ratio, diffusivity.reference_temperature, diffusivity.activation_energy
    )


def _saturation(laminate: Laminate) -> tuple[float, ...]:
    found = []
    for layer in laminate.layers:
        assert layer.ply.resin is not None
        assert layer.ply.resin.hygrothermal.equilibrium is not None
        found.append(layer.ply.resin.hygrothermal.equilibrium.saturation)
    return tuple(found)
