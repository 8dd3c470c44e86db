"""A rectangular section of layers, and one whose plies are stacked in the linkage's plane.

Bending in the plane of the linkage bends the laminate through its thickness. The section
keeps the axial-bending coupling of an unsymmetric stack: it has a neutral axis off the
mid-plane, where the pins sit. Strains along the link are ``e - y kappa``.

Stresses of plies in their own axes are five: along the fibres, across them and in shear, which is
all that criteria of plane stress ask for, then the shear stresses 13 and 23 between the plies.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import ClassVar

import numpy as np

from flexmech.arrays import ROUND_OFF, SAME_PLACE, FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.materials import Laminate
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr
from flexmech.sections.beam_reduction import (
    REDUCTIONS,
    SHEAR_THEORIES,
    LayerDirection,
    PlaneState,
    Reduction,
    ShearTheory,
    Strip,
    ThirdOrder,
    ThroughThickness,
    Zigzag,
    gauss_points,
    lost_share,
    parabolic_shear,
    shear_across,
    shear_strain,
    third_order_of,
    zigzag_of,
)
from flexmech.sections.damping import SpecificDamping
from flexmech.sections.free_edges import (
    FIRST_MODE,
    TWISTS,
    Twist,
    free_edges,
    laminate_solid,
)
from flexmech.sections.solid_section import SolidSection
from flexmech.units import LENGTH
from flexmech.validation import POSITIVE, check_choice, check_instance, check_number

SURFACES = ("lower", "upper")
"""Surfaces of a layer, at its lower and its higher y; edges of plies across the width."""


class LayeredSection(ABC):
    """A rectangular section of a laminate: stresses of its layers under loads."""

    laminate: Laminate
    direction: ClassVar[LayerDirection]
    """Total thickness of the stack."""

    @property
    @abstractmethod
    def neutral_axis(self) -> float:
        """Distance of the neutral axis from the middle in m."""

    @property
    @abstractmethod
    def breadth(self) -> float:
        """Extent of the plies across the link in m."""

    @property
    @abstractmethod
    def edges(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest place y of each layer in the plane of the linkage in m, (N,) each."""

    @abstractmethod
    def plane_state(
        self, axial_force: float, bending_moment: float, coupled: bool = True
    ) -> PlaneState:
        """Its layers under loads on the neutral axis.

        Parameters
        ----------
        axial_force, bending_moment : float
            In N and N m.
        coupled : bool
            As of :meth:`stresses`.

        Returns
        -------
        PlaneState
            By places y in the plane of the linkage.
        """

    @abstractmethod
    def unit_shear(
        self, place: FloatArray, layer: IntArray, coupled: bool, theory: ShearTheory
    ) -> FloatArray:
        """Stresses of layers by a unit shear force.

        Parameters
        ----------
        place : ndarray, shape (...)
        layer : ndarray of int
            Layers of the places, which broadcast against them.
        coupled : bool
        theory : {"equilibrium", "third-order"}
            Both as of :meth:`stresses`.

        Returns
        -------
        ndarray, shape (..., 5)
            Stresses x, z, xz, zy and xy in Pa.
        """

    @property
    def mass_per_length(self) -> float:
        """Mass rho A in kg/m."""
        return self.breadth * self.laminate.mass_moment(0)

    def places(self, per_layer: int) -> FloatArray:
        """Places through each layer in the plane of the linkage, its faces or edges included.

        Parameters
        ----------
        per_layer : int

        Returns
        -------
        ndarray, shape (N, per_layer)
            In m.

        Raises
        ------
        InputError
            If there are fewer than two a layer.
        """
        if per_layer < 2:
            raise InputError(f"per_layer must be 2 or more, for both faces; got {per_layer}")
        return np.linspace(*self.edges, per_layer, axis=1)

    def stresses(
        self,
        place: FloatArray,
        axial_force: float = 0.0,
        bending_moment: float = 0.0,
        shear_force: float = 0.0,
        *,
        coupled: bool = True,
        theory: ShearTheory = "equilibrium",
    ) -> ThroughThickness:
        """Strain and stress of the layers under loads on the neutral axis.

        Away from the ends of the link. Strain and normal stress by classical theory. With coupling
        both shear stresses have the shear force as their resultant; that of plies at angles across
        the width includes what stretching them takes, which cancels over all plies.

        Parameters
        ----------
        place : ndarray, shape (m,) or (N, m)
            In m from the middle. In a list, for layers through the thickness alone, an interface
            is of its upper layer; in rows, of which :meth:`places` gives some, each layer has its
            own stress at it.
        axial_force : float
            In N, on the neutral axis (on the mid-plane if not ``coupled``).
        bending_moment : float
            In N m; positive stretches the side of lower y.
        shear_force : float
            In N, along y on the face towards higher x.
        coupled : bool
            Off: the section's axial-bending coupling is left out, as if the stack were
            symmetric; the stresses then do not balance the loads, and the shear stress
            does not vanish at the upper face. Layers across the width couple nothing.
        theory : {"equilibrium", "third-order"}
            Shear stress that balances the normal stress along the link, or Reddy's parabola
            of shear strain ``1 - 4 y^2 / h^2`` with each layer's stiffness, which jumps at
            interfaces. Across the width both are the same parabola.

        Returns
        -------
        ThroughThickness

        Raises
        ------
        InputError
            If a place is outside its layer, there is not a row for each layer, a load is not a
            number or the theory unknown.
        """
        loads = [float(load) for load in (axial_force, bending_moment, shear_force)]
        if not np.all(np.isfinite(loads)):
            raise InputError(f"loads on a section must be finite, got {loads}")
        check_choice(theory, SHEAR_THEORIES, "theory")
        place = np.asarray(place, dtype=float)
        layer = self._layer_of(place)
        state = self.plane_state(axial_force, bending_moment, coupled)
        sheared = shear_force * self.unit_shear(place, layer, coupled, theory)
        stress = state.stress(place, layer)
        through = self.direction == "through thickness"
        return ThroughThickness(
            place=place,
            strain=state.strain(place, layer)[..., 0],
            normal_stress=stress[..., 0] + sheared[..., 0],
            shear_stress=sheared[..., 4] if through else stress[..., 2] + sheared[..., 2],
        )

    def _layer_of(self, place: FloatArray) -> IntArray:
        """Layers of places, by which they broadcast; see :meth:`stresses`."""
        low, high = self.edges
        through = self.direction == "through thickness"
        if place.ndim == 2 and len(place) == len(low):
            layer = np.arange(len(low))[:, None]
        elif through and place.ndim < 2:
            layer = np.clip(np.searchsorted(low, place, side="right") - 1, 0, len(low) - 1)
        else:
            raise InputError(
                f"places must {'be a list, or ' if through else ''}have one row for each of the "
                f"{len(low)} layers; got shape {place.shape}"
            )
        slack = SAME_PLACE * (high[-1] - low[0])
        inside = (place >= low[layer] - slack) & (place <= high[layer] + slack)
        if not np.all(inside):
            raise InputError(
                f"place {place[~inside].flat[0]:.6g} m is outside its layer; the section reaches "
                f"from {low[0]:.6g} to {high[-1]:.6g} m"
            )
        return np.asarray(layer)


@dataclass(frozen=True)
class LaminateSection(LayeredSection):
    """Laminate of a width along the joint axes, stacked through the thickness in the plane.

    Parameters
    ----------
    laminate : Laminate
    width : float
        Along the joint axes, in m.
    reduction : {"narrow", "wide"}
        ``narrow``: no stress resultant across the link nor in-plane shear (plane stress);
        ``wide``: no strain across nor in-plane shear (plane strain, cylindrical bending).
    twist : {"free", "held"}, optional
        Twist of a narrow section whose off-axis plies twist as they bend: ``held`` where joints
        keep both ends from turning about the link's axis (:mod:`flexmech.sections.free_edges`).
        Left out: as the link's joints have it, and free where there is no link.

    Raises
    ------
    InputError
        If the width is not positive or the reduction or the twist unknown.

    Examples
    --------
    >>> known = flexmech.published_constituents()
    >>> glass = flexmech.ply_from_constituents(known["E-glass"], known["polyester"], 0.6)
    >>> carbon = flexmech.ply_from_constituents(known["carbon"], known["polyester"], 0.6)
    >>> laminate = flexmech.Laminate.stacked([glass, carbon], 1e-3, [0.0, 0.0])
    >>> section = flexmech.LaminateSection(laminate, width=0.02)
    >>> round(section.neutral_axis * 1e3, 3)  # towards the stiffer ply, in mm
    0.239
    """

    laminate: Laminate
    width: float
    reduction: Reduction = "narrow"
    twist: Twist | None = None
    direction: ClassVar[LayerDirection] = "through thickness"

    def __post_init__(self) -> None:
        check_instance(self.laminate, Laminate, "laminate", "give Laminate(layers)")
        check_number(self.width, "width of a laminate section", "m", POSITIVE)
        check_choice(self.reduction, REDUCTIONS, "reduction")
        if self.twist is not None:
            check_choice(self.twist, TWISTS, "twist")

    def __repr__(self) -> str:
        width = f"{self.width * 1e3:.6g} mm wide"
        return short_repr(self, self.laminate.stacking, width, self.reduction)

    @property
    def in_plane_thickness(self) -> float:
        """Extent in the plane of the linkage in m."""
        return self.laminate.thickness

    @property
    def breadth(self) -> float:
        """Its width."""
        return self.width

    @property
    def edges(self) -> tuple[FloatArray, FloatArray]:
        """Faces y of each layer in m, (N,) each."""
        faces = self.laminate.boundaries
        return faces[:-1], faces[1:]

    @property
    def smeared(self) -> LaminateSection:
        """The section itself: its layers are those through the thickness in the plane."""
        return self

    @cached_property
    def axial_stiffness(self) -> float:
        """EA in N."""
        return float(self._classical[0, 0])

    @cached_property
    def coupling_stiffness(self) -> float:
        """B, the integral of E y, in N m: N = EA e - B kappa about the mid-plane."""
        return float(self._classical[0, 1])

    @cached_property
    def neutral_axis(self) -> float:
        """Distance of the neutral axis from the mid-plane in m; exactly 0 if symmetric."""
        return self.coupling_stiffness / self.axial_stiffness

    @cached_property
    def bending_stiffness(self) -> float:
        """EI about the neutral axis in N m^2."""
        return float(self._classical[1, 1]) - self.axial_stiffness * self.neutral_axis**2

    @cached_property
    def shear_stiffness(self) -> float:
        """Shear stiffness kGA in N, from the shear energy of the stack.

        The shear stress that balances the bending stress of a unit shear force has the
        complementary energy ``1 / (2 kGA)`` for each metre (Whitney 1973 for plates; one
        homogeneous layer has k = 5/6). In a narrow link this takes the stress across the
        link too, which the shear within angle plies asks for; its force is zero.
        """
        return float(1 / self._shear_flexibility.sum())

    @cached_property
    def shear_correction(self) -> float:
        """Factor k: kGA over the integral of G, reduced as the section is."""
        moment = self.laminate.shear_moment(0)
        along = moment[1, 1] + shear_across(moment, self.reduction) * moment[0, 1]
        return float(self.shear_stiffness / (self.width * along))

    @cached_property
    def mass_axis(self) -> float:
        """Distance of the centre of mass from the mid-plane in m; exactly 0 if symmetric."""
        axis = self.laminate.mass_moment(1) / self.laminate.mass_moment(0)
        return axis if abs(axis) > ROUND_OFF * self.laminate.thickness else 0.0

    @cached_property
    def rotary_inertia(self) -> float:
        """Mass moment rho I about the centre of mass in kg m."""
        return self.width * self.laminate.mass_moment(2) - self.mass_per_length * self.mass_axis**2

    @cached_property
    def solid(self) -> SolidSection:
        """The cross-section in three dimensions, all edges free: compliance by six loads.

        A narrow link with plies at angles stretches and bends as this section does. Torsion and
        bending across the linkage's plane are added.

        Examples
        --------
        >>> aluminium = flexmech.Material(70e9, 2700.0, 0.33)
        >>> layer = flexmech.Layer(flexmech.Ply.isotropic(aluminium), 4e-3)
        >>> section = flexmech.LaminateSection(flexmech.Laminate((layer,)), width=8e-3)
        >>> torsion = 1 / section.solid.compliance[3, 3]
        >>> round(torsion / (aluminium.shear_modulus * 8e-3 * 4e-3**3), 3)  # closed form: 0.229
        0.229
        """
        return laminate_solid(self.laminate, self.width)

    @cached_property
    def third_order(self) -> ThirdOrder:
        """Integrals for Reddy's theory, reduced like the classical ones."""
        return third_order_of(self._strip, self.width)

    @property
    def twists(self) -> bool:
        """Whether bending twists the section, so that joints matter which restrain the twist."""
        return self._free_edges[1] > 0

    @cached_property
    def twist_restraint(self) -> float:
        """Where the section is between twist that is free (0) and none at all (1)."""
        return FIRST_MODE * self._free_edges[1] if self.twist == "held" else 0.0

    @cached_property
    def zigzag(self) -> Zigzag:
        """Integrals for the zigzag beam, reduced like the classical ones."""
        return zigzag_of(self._strip, self._bent_inside)

    @cached_property
    def specific_damping(self) -> SpecificDamping:
        """Specific damping capacity of stretching, bending, shear and warping.

        Strain energies by ply and direction in the material's axes, each with its own
        capacity (Adams & Bacon 1973; Ni & Adams 1984). All shear through the thickness
        loses with the ply's capacity in shear.
        """
        sheared = np.zeros((len(self.laminate.layers), 3))
        sheared[:, 2] = self._shear_flexibility
        stretched = self._strip.energy_by_direction(self._strains(1.0, 0.0))
        bent = self._strip.energy_by_direction(self._strains(0.0, 1.0))
        axial, bending, shear = (
            lost_share(self.laminate, energy) for energy in (stretched, bent, sheared)
        )
        return SpecificDamping(axial, bending, shear, self.zigzag.loss)

    def plane_state(
        self, axial_force: float, bending_moment: float, coupled: bool = True
    ) -> PlaneState:
        """Its layers under loads on the neutral axis, in N and N m; see :meth:`stresses`."""
        return self._state(self._strains(axial_force, bending_moment, coupled))

    def unit_shear(
        self, place: FloatArray, layer: IntArray, coupled: bool, theory: ShearTheory
    ) -> FloatArray:
        """Stresses x, z, xz, zy and xy by a unit shear force, (..., 5) in Pa."""
        stress = np.zeros((*place.shape, 5))
        if theory == "equilibrium":
            growing = self.plane_state(0.0, 1.0, coupled)
            stress[..., 3:] = growing.balancing_shear(place, layer)
        else:
            shear = parabolic_shear(self.laminate, self.reduction, place, layer)
            stress[..., 4] = shear / self.width
        return stress

    def resized(self, laminate: Laminate, growth: float) -> LaminateSection:
        """The section of another laminate, its plies broader by a factor.

        Parameters
        ----------
        laminate : Laminate
        growth : float

        Returns
        -------
        LaminateSection
        """
        return replace(self, laminate=laminate, width=growth * self.width)

    def to_table(self, shared: SharedTables) -> TomlTable:
        """Keys of a link in a model file; the laminate is added to the shared tables."""
        laminate = shared.name_of("laminates", self.laminate.to_table(shared), "laminate")
        twist = {} if self.twist is None else {"twist": self.twist}
        return {
            "laminate": laminate,
            "out_of_plane_width": quantity(self.width, LENGTH),
            "reduction": self.reduction,
            **twist,
        }

    @cached_property
    def _free_edges(self) -> tuple[FloatArray, float]:
        """Relaxation and torsion of a narrow section whose plies are at angles."""
        if self.reduction == "wide":
            return np.zeros((2, 2)), 0.0
        return free_edges(self.laminate, self.width)

    @cached_property
    def _strip(self) -> Strip:
        relaxation, _ = self._free_edges
        return Strip(self.laminate, self.reduction, relaxation, self.twist_restraint)

    @cached_property
    def _classical(self) -> FloatArray:
        """Stiffness by mid-plane strain and its gradient in y, (2, 2)."""
        matrix = self.width * self._strip.stiffness
        # What rounding leaves of a symmetric stack's coupling would move its axis off the pins.
        if abs(matrix[0, 1]) < ROUND_OFF * np.sqrt(matrix[0, 0] * matrix[1, 1]):
            matrix[0, 1] = matrix[1, 0] = 0.0
        return matrix

    def _strains(self, axial_force: float, moment: float, coupled: bool = True) -> FloatArray:
        """Mid-plane strain and its gradient in y under loads on the neutral axis, (2,)."""
        axis = self.neutral_axis if coupled else 0.0
        curvature = moment / (self.bending_stiffness if coupled else self._classical[1, 1])
        return np.array([axial_force / self.axial_stiffness + axis * curvature, -curvature])

    def _state(self, strains: FloatArray) -> PlaneState:
        """The laminate under strain along the link and its gradient in y."""
        return PlaneState(self.laminate, np.tensordot(strains, self._strip.strains, axes=1))

    @property
    def _bent_inside(self) -> PlaneState:
        """The laminate away from its edges under a unit bending moment."""
        inside = self._strip.joined
        strains = np.linalg.solve(self.width * inside.stiffness, np.array([0.0, -1.0]))
        return PlaneState(self.laminate, np.tensordot(strains, inside.strains, axes=1))

    @cached_property
    def _shear_flexibility(self) -> FloatArray:
        """Share of each layer in 1 / kGA, (N,), in 1/N."""
        places, weights = gauss_points(self.laminate)
        every = np.arange(len(places))[:, None]
        stress = self._bent_inside.balancing_shear(places, every)
        strain = shear_strain(self.laminate, self.reduction, stress)
        return np.asarray(self.width * np.einsum("nm,nmi,nmi->n", weights, stress, strain))


# A search for the weakest place judges the same few layers hundreds of times: a fifth of its time.
@lru_cache(maxsize=64)
def unit_ply_stresses(layers: LayeredSection) -> FloatArray:
    """Stresses under a unit axial force, bending moment and shear force at the pins' axis.

    Parameters
    ----------
    layers : LaminateSection or SheetSection

    Returns
    -------
    ndarray, shape (3, N, 2, 5)
        In Pa for 1 N along the pins' axis (with coupling it bends the link), 1 N m that stretches
        the side of lower y, and 1 N along y on the face towards higher x; of each layer at both
        surfaces. The mean over the width of what free edges let go. Read-only.
    """
    place, every = layers.places(2), np.arange(len(layers.laminate.layers))[:, None]
    # Along the pins' axis the force has this lever about the neutral axis.
    loads = [(1.0, layers.neutral_axis), (0.0, 1.0)]
    stresses = np.zeros((3, *place.shape, 5))
    for stress, load in zip(stresses, loads, strict=False):
        stress[..., :3] = layers.plane_state(*load).stress(place, every)
    stresses[2] = layers.unit_shear(place, every, True, "equilibrium")
    stresses = in_ply_axes(layers.laminate, stresses)
    stresses.setflags(write=False)
    return stresses


def in_ply_axes(laminate: Laminate, stress: FloatArray) -> FloatArray:
    """Stresses of layers in their plies' axes.

    Parameters
    ----------
    laminate : Laminate
    stress : ndarray, shape (..., N, m, 5)
        Along the link's axes: x, z, xz, zy and xy.

    Returns
    -------
    ndarray, shape (..., N, m, 5)
        1, 2, 12, 13 and 23.
    """
    turns = np.zeros((len(laminate.layers), 5, 5))
    turns[:, :3, :3] = [np.linalg.inv(layer.strain_turn).T for layer in laminate.layers]
    angle = np.array([layer.angle for layer in laminate.layers])
    turns[:, 3, 3], turns[:, 3, 4] = np.sin(angle), np.cos(angle)
    turns[:, 4, 3], turns[:, 4, 4] = np.cos(angle), -np.sin(angle)
    return np.asarray(np.einsum("nij,...nmj->...nmi", turns, stress))
