"""How a link takes up water in constant surroundings, over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal.link_diffusion import LinkDiffusion, link_diffusion
from flexmech.materials.moisture import (
    MoistureHistory,
    Surroundings,
    shen_springer_uptake,
    short_time_uptake,
    time_to_saturation,
)
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["LinkUptake", "link_uptake"]


# Of the time scale of filling; a slab is full to 1e-17 by then.
LONGEST = 40.0


@dataclass(frozen=True)
class LinkUptake:
    """Water in a link over time, from dry.

    Parameters
    ----------
    diffusion : LinkDiffusion
    history : MoistureHistory
    relative_humidity : float
        Of the surroundings.
    temperature : float
        In K.
    """

    diffusion: LinkDiffusion
    history: MoistureHistory
    relative_humidity: float
    temperature: float

    @property
    def final_saturation(self) -> float:
        """Saturation of all layers in the end."""
        return float(self.relative_humidity**self.diffusion.humidity_exponent)

    @property
    def uptake(self) -> FloatArray:
        """Water over what the link takes up in the end, (t,)."""
        return np.asarray(self.history.uptake / self.final_saturation)

    @property
    def moisture(self) -> FloatArray:
        """Mean moisture of the resin, (t,): all water over the dry mass of all resin."""
        resin = [
            layer.thickness * layer.capacity / saturation
            for layer, saturation in zip(
                self.diffusion.layers, self.diffusion.saturation, strict=True
            )
        ]
        return np.asarray(self.history.water / sum(resin))

    @property
    def profile(self) -> FloatArray:
        """Moisture of the resin in the cells through the thickness, (t, n)."""
        return np.asarray(self.history.saturation * self._saturation_of_cells)

    @property
    def diffusivity(self) -> float | None:
        """Diffusivity in m^2/s at the temperature; None where layers differ.

        Layers that hold more water than others are no slab either, though water moves as fast.
        """
        layers = self.diffusion.layers
        found = {(float(one.diffusivity.at(self.temperature)), one.capacity) for one in layers}
        return found.pop()[0] if len(found) == 1 else None

    @property
    def thickness(self) -> float:
        """Of the link in m."""
        return sum(layer.thickness for layer in self.diffusion.layers)

    def laws(self) -> tuple[FloatArray, FloatArray] | None:
        """Uptake by the law of the root of time and by Shen & Springer's formula.

        Returns
        -------
        tuple of ndarray, shape (t,), or None
            None where layers differ or water comes in through the sides too.
        """
        if self.diffusivity is None or self.diffusion.width is not None:
            return None
        slab = self.history.time, self.thickness, self.diffusivity
        faces = self.diffusion.faces
        root = short_time_uptake(*slab, faces=faces)
        return np.minimum(root, 1.0), shen_springer_uptake(*slab, faces=faces)

    def times_to(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Times in s at which the link holds shares of its water in the end.

        By the series where there is one; else from the finite volumes, within 1e-3.

        Parameters
        ----------
        shares : sequence of float
            Between 0 and 1.

        Returns
        -------
        tuple of float

        Raises
        ------
        InputError
            If a share is not between 0 and 1.
        ComputationError
            If one is not reached in forty times the time in whose scale the link fills.
        """
        for share in shares:
            if not 0 < share < 1:
                raise InputError(f"share of the equilibrium must lie between 0 and 1, got {share}")
        faces = self.diffusion.faces
        if self.diffusivity is not None and self.diffusion.width is None:
            slab = self.thickness, self.diffusivity
            return tuple(time_to_saturation(share, *slab, faces=faces) for share in shares)
        scale = self._time_scale
        times = np.concatenate([[0.0], np.geomspace(1e-4 * scale, LONGEST * scale, 400)])
        surroundings = self.relative_humidity, self.temperature
        values = _history(self.diffusion, *surroundings, tuple(times)).uptake
        values = values / self.final_saturation
        if values[-1] < max(shares):
            raise ComputationError(
                f"{100 * max(shares):g} % of the equilibrium is not reached in {times[-1]:.3g} s; "
                "check the layers' diffusivities and thicknesses"
            )
        # Near the end what is left falls exponentially: straight in its logarithm.
        left = -np.log(np.clip(1 - values, 1e-12, 1.0))
        return tuple(float(np.interp(-np.log(1 - share), left, times)) for share in shares)

    @property
    def _time_scale(self) -> float:
        """Time in s in the scale of which the link fills."""
        own = sum(
            layer.thickness / np.sqrt(float(layer.diffusivity.at(self.temperature)))
            for layer in self.diffusion.layers
        )
        return float(own**2) * (1 if self.diffusion.faces == "both" else 4) / np.pi**2

    @property
    def _saturation_of_cells(self) -> FloatArray:
        layers = self.diffusion.layers
        faces = np.cumsum([layer.thickness for layer in layers])
        faces = faces - faces[-1] / 2
        own = np.searchsorted(faces, self.history.place).clip(max=len(layers) - 1)
        saturation: FloatArray = np.asarray(self.diffusion.saturation)[own]
        return saturation


def link_uptake(
    mechanism: Mechanism,
    link: str,
    relative_humidity: float,
    temperature: float,
    times: FloatArray,
) -> LinkUptake:
    """Water in a link over time in constant surroundings, from dry.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    relative_humidity : float
        Above 0, up to 1.
    temperature : float
        In K.
    times : ndarray, shape (t,)
        In s, rising from zero.

    Returns
    -------
    LinkUptake

    Raises
    ------
    InputError
        If the humidity is zero, or the link cannot take up water; see
        :func:`flexmech.hygrothermal.link_diffusion`.
    """
    if not 0 < relative_humidity <= 1:
        raise InputError(
            "relative_humidity must lie above 0 and up to 100 % for a link to take up water, got "
            f"{100 * relative_humidity:g} %"
        )
    diffusion = link_diffusion(mechanism, link)
    history = _history(diffusion, relative_humidity, temperature, tuple(times))
    return LinkUptake(diffusion, history, relative_humidity, temperature)


@lru_cache(maxsize=16)
def _history(
    diffusion: LinkDiffusion,
    relative_humidity: float,
    temperature: float,
    times: tuple[float, ...],
) -> MoistureHistory:
    """Water over time; links are often alike."""
    surroundings = Surroundings.constant(relative_humidity, temperature)
    return diffusion.history(surroundings, np.array(times))
