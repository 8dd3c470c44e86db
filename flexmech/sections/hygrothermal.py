"""A beam section in heat and water: swollen, softer, heavier, and curved where unevenly so.

Classical lamination theory gives the strains that a stack takes by itself: its layers pull at each
other until forces and moments vanish (Tsai & Hahn, *Introduction to Composite Materials*, ch. 8). A
beam takes from them the elongation of the neutral axis and the curvature in the plane of the
linkage; the swelling of its width and thickness goes into its section.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError
from flexmech.materials import (
    Laminate,
    Layer,
    Ply,
    moisture_of,
    ply_diluted,
    ply_in_state,
    through_thickness_strain,
)
from flexmech.sections.beam_reduction import PlaneState, Reduction
from flexmech.sections.beam_section import BeamSection, Layers, with_layers
from flexmech.sections.laminate_section import LaminateSection, in_ply_axes
from flexmech.sections.solid_section import CURVATURE, STRETCH, TWIST
from flexmech.validation import check_fields


@dataclass(frozen=True)
class HygrothermalProfile:
    """Temperature and moisture through a cross-section.

    Parameters
    ----------
    temperature_rise : float
        Over the reference temperature in K, the same everywhere.
    moisture : float or tuple of tuple of float
        Mass of water over the dry mass of the resin: one for the section, or for each layer
        of its laminate, from the lowest up, those of equally thick slices of it.
    reference_temperature : float
        In K: dimensions and moduli of the dry section are those at it.

    Raises
    ------
    InputError
        If a number is not finite, a moisture negative or a temperature not above 0 K.
    """

    temperature_rise: float
    moisture: float | tuple[tuple[float, ...], ...]
    reference_temperature: float

    def __post_init__(self) -> None:
        check_fields(self, {"temperature_rise": "K", "reference_temperature": "K"})
        if not (self.reference_temperature > 0 and self.temperature > 0):
            raise InputError(
                f"a temperature of {self.temperature:g} K, {self.temperature_rise:g} K from the "
                f"reference temperature of {self.reference_temperature:g} K, cannot be; both must "
                "be above 0 K"
            )

    @property
    def temperature(self) -> float:
        """In K."""
        return self.reference_temperature + self.temperature_rise

    def slices(self, laminate: Laminate) -> list[tuple[Layer, float]]:
        """Slices of a laminate, each with the moisture that is offered to it.

        Parameters
        ----------
        laminate : Laminate

        Returns
        -------
        list of tuple of Layer and float
        """
        if isinstance(self.moisture, tuple):
            if len(self.moisture) != len(laminate.layers):
                raise InputError(
                    f"moisture is given for {len(self.moisture)} layers, the laminate has "
                    f"{len(laminate.layers)}; give one tuple for each"
                )
            return [
                (replace(layer, thickness=layer.thickness / len(moistures)), moisture)
                for layer, moistures in zip(laminate.layers, self.moisture, strict=True)
                for moisture in moistures
            ]
        return [(layer, self.moisture) for layer in laminate.layers]


@dataclass(frozen=True)
class SwollenSection:
    """A section in heat and water.

    Parameters
    ----------
    section : BeamSection
        With the curvature that it takes by itself.
    elongation : float
        Free strain of its neutral axis along the link.
    water : float
        Mass of the water over the dry mass of the section.
    """

    section: BeamSection
    elongation: float
    water: float


def swollen_section(section: BeamSection, profile: HygrothermalProfile) -> SwollenSection:
    """Swell a section as temperature and moisture through it demand.

    Stiffness, damping and inertia are computed again from the layers as they are then; their
    change is applied to the section, so that a dry one at its reference temperature stays
    the same to the last bit. The mass of fibres and resin stays: a swollen link is less
    dense, and water is added.

    Parameters
    ----------
    section : BeamSection
        Dry, at the reference temperature. One whose layers are not known stays as it is.
    profile : HygrothermalProfile

    Returns
    -------
    SwollenSection

    Raises
    ------
    InputError
        If a resin is above its wet glass transition or takes up less water than is offered.
    """
    if section.layers is None:
        return SwollenSection(section, 0.0, 0.0)
    dry = section.layers
    slices = [_Slice.of(*entry, profile) for entry in profile.slices(dry.laminate)]
    grown = Laminate(tuple(s.swollen for s in slices))
    stress = np.stack([keeping_stress(s.swollen, s.strain[:2]) for s in slices])
    free = free_strains(grown, stress, dry.reduction)
    across = 1 + (free[0, 1] if dry.reduction == "narrow" else 0.0)
    soft = dry.resized(grown, across)
    if isinstance(soft, LaminateSection) and soft.twist == "held" and free[1, 2] and soft.twists:
        free = without_twist(free, soft)
    elongation = float(free[0, 0])
    # Where nothing bends, the axis does not matter, and need not be found.
    if free[1, 0]:
        elongation += float(soft.neutral_axis * free[1, 0])
    packed = tuple(s.packed(across * (1 + elongation)) for s in slices)
    wet = soft.resized(replace(dry.laminate, layers=packed), 1.0)
    masses = np.array([s.dry.ply.density * s.dry.thickness for s in slices])
    water = float(masses @ [s.water for s in slices] / masses.sum())
    return SwollenSection(_changed(section, wet, -float(free[1, 0])), elongation, water)


@dataclass(frozen=True)
class _Slice:
    """Part of a layer with one moisture: the dry ply, the ply then, and its free strains.

    ``strain`` has the free strains along, across and through the ply.
    """

    dry: Layer
    ply: Ply
    moisture: float
    strain: tuple[float, float, float]

    @classmethod
    def of(cls, layer: Layer, offered: float, profile: HygrothermalProfile) -> _Slice:
        moisture = moisture_of(layer.ply, offered)
        ply = ply_in_state(layer.ply, profile.temperature, moisture, profile.reference_temperature)
        rise = profile.temperature_rise
        along, across = (
            heat * rise + water * moisture
            for heat, water in zip(ply.thermal_expansion, ply.moisture_expansion, strict=True)
        )
        through = through_thickness_strain(ply, rise, moisture)
        # Only the resin grows: the same fibres in a larger ply.
        volume = (1 + along) * (1 + across) * (1 + through)
        return cls(layer, ply_diluted(ply, volume), moisture, (along, across, through))

    @property
    def swollen(self) -> Layer:
        """The slice as thick as it is then."""
        return Layer(self.ply, self.dry.thickness * (1 + self.strain[2]), self.dry.angle)

    @property
    def water(self) -> float:
        """Mass of water over the dry mass of the slice."""
        resin = self.dry.ply.resin
        return 0.0 if resin is None else self.moisture * resin.mass_fraction

    def packed(self, growth: float) -> Layer:
        """The swollen slice with its water, where its area has grown by a factor."""
        volume = growth * (1 + self.strain[2])
        density = self.dry.ply.density * (1 + self.water) / volume
        return replace(self.swollen, ply=replace(self.ply, density=density))


def free_strains(laminate: Laminate, stress: FloatArray, reduction: Reduction) -> FloatArray:
    """Strains x, z, xz at the mid-plane and their gradients in y that a stack takes without loads.

    Parameters
    ----------
    laminate : Laminate
    stress : ndarray, shape (N, 3)
        Stress x, z, xz in Pa that would keep each layer from straining.
    reduction : {"narrow", "wide"}

    Returns
    -------
    ndarray, shape (2, 3)
    """
    faces = laminate.boundaries
    loads = np.concatenate([np.diff(faces) @ stress, np.diff(faces**2) / 2 @ stress])
    matrix = laminate.plate_stiffness
    strains = np.zeros(6)
    free = np.arange(6) if reduction == "narrow" else np.array([0, 3])
    strains[free] = np.linalg.solve(matrix[np.ix_(free, free)], loads[free])
    # What rounding leaves of a symmetric stack's curvature would bend its link.
    bent = strains[3:] * laminate.thickness
    strains[3:][np.abs(bent) < ROUND_OFF * np.abs(strains[:3]).max()] = 0.0
    return strains.reshape(2, 3)


def keeping_stress(layer: Layer, strain: Sequence[float]) -> FloatArray:
    """Stress x, z, xz in Pa that would keep a layer from straining, (3,).

    Parameters
    ----------
    layer : Layer
    strain : sequence of float
        Free strains along and across the fibres; in the ply's axes they shear nothing.

    Returns
    -------
    ndarray, shape (3,)
    """
    # Stress turns as strain's dual.
    stress = layer.ply.reduced_stiffness @ np.array([*strain, 0.0])
    return np.asarray(layer.strain_turn.T @ stress)


def without_twist(free: FloatArray, section: LaminateSection) -> FloatArray:
    """Free strains (2, 3) of a section whose joints take back the twist that it would swell to.

    The torque that they need is the same along the whole link; it bends and stretches plies that
    couple these with twist (:mod:`flexmech.sections.free_edges`).
    """
    by_torque = section.solid.compliance[:, TWIST]
    # The shear between the faces is of twice the twist.
    torque = -free[1, 2] / 2 / by_torque[TWIST]
    untwisted = free.copy()
    untwisted[0, 0] += by_torque[STRETCH] * torque
    untwisted[1, 0] -= by_torque[CURVATURE] * torque
    untwisted[1, 2] = 0.0
    return untwisted


def _changed(section: BeamSection, wet: Layers, curvature: float) -> BeamSection:
    """The section with the layers that heat and water have made, which bend by themselves."""
    result = replace(
        with_layers(section, wet),
        in_plane_thickness=wet.in_plane_thickness,
        neutral_axis=wet.neutral_axis,
        mass_axis=wet.mass_axis,
        free_curvature=section.free_curvature + curvature,
        specific_damping=None if section.specific_damping is None else wet.specific_damping,
    )
    if section.damping_frequency is not None:
        return result.with_damping_frequency(section.damping_frequency)
    return result


def residual_ply_stresses(
    layers: Layers, temperature_rise: float, moisture: FloatArray
) -> FloatArray:
    """Stresses that the layers put on each other without loads.

    Parameters
    ----------
    layers : LaminateSection or SheetSection
        As they are in heat and water.
    temperature_rise : float
        Over the temperature at which they are free of stress, in K.
    moisture : ndarray, shape (N,)
        Moisture of each layer's resin, as :func:`flexmech.materials.moisture_of` gives it.

    Returns
    -------
    ndarray, shape (N, 2, 5)
        In Pa, at both surfaces of each layer; of plies across the width in their middle. Classical
        lamination theory, linear in the temperature; no ply flows.
    """
    laminate, count = layers.laminate, len(layers.laminate.layers)
    plies = [layer.ply for layer in laminate.layers]
    heat, water = (
        np.array([getattr(ply, name) for ply in plies])
        for name in ("thermal_expansion", "moisture_expansion")
    )
    strains = heat * temperature_rise + water * moisture[:, None]
    kept = np.stack([keeping_stress(*one) for one in zip(laminate.layers, strains, strict=True)])
    free = free_strains(laminate, kept, layers.reduction)
    faces = laminate.boundaries
    place = np.stack([faces[:-1], faces[1:]], axis=1)
    if not isinstance(layers, LaminateSection):
        place = np.repeat(place.mean(axis=1, keepdims=True), 2, axis=1)
    elif layers.twist == "held" and layers.twists:
        free = without_twist(free, layers)
    state = PlaneState(laminate, np.broadcast_to(free, (count, 2, 3)))
    stress = np.zeros((count, 2, 5))
    stress[..., :3] = state.stress(place, np.arange(count)[:, None]) - kept[:, None]
    return in_ply_axes(laminate, stress)
