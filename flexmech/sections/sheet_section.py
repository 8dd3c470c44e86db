"""A rectangular section cut from a flat laminate whose plies are parallel to the plane of motion.

Bending in the plane of the linkage bends each ply in its own plane: all plies have the strain
``e - y kappa``, and the stiffness follows the membrane stiffness of the laminate, whatever the
order of its plies. Against other sections of the linkage's plane it is a solid rectangle of the
plies' mean. The edges are free: no force acts across the link.

A laminate that is not symmetric would bend and twist out of the plane when it is stretched, and one
that is not balanced would shear; beams in a plane know neither.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import ClassVar

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.materials import Laminate, Layer, Ply, PlyDamping
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr
from flexmech.sections.beam_reduction import (
    LayerDirection,
    PlaneState,
    Reduction,
    ShearTheory,
    energy_by_direction,
    lost_share,
)
from flexmech.sections.damping import SpecificDamping
from flexmech.sections.free_edges import (
    NARROWEST,
    WIDEST,
    is_off_axis,
    laminate_solid,
)
from flexmech.sections.laminate_section import LaminateSection, LayeredSection
from flexmech.sections.solid_section import ACROSS_PLANE, STRETCH
from flexmech.units import LENGTH
from flexmech.validation import POSITIVE, check_instance, check_number

# Part of the plies' stiffness that may couple stretching with bending out of the plane: round-off.
SYMMETRIC = 1e-9
# Square of the coupling of stretching with shear over both flexibilities, below which no frequency
# shows it. Layers at opposite angles that are unevenly moist, at different depths, have 3e-9.
BALANCED = 1e-6


@dataclass(frozen=True)
class SheetSection(LayeredSection):
    """Strip of a flat laminate, its plies parallel to the plane of motion.

    Parameters
    ----------
    laminate : Laminate
        Symmetric and balanced. Its thickness is the link's extent along the joint axes; layers
        count towards positive joint axes, and angles from the link's axis in the plane of motion.
    in_plane_thickness : float
        Breadth of the strip, in the plane of the linkage, in m.

    Raises
    ------
    InputError
        If the thickness is not positive, or the laminate is not symmetric or not balanced.

    Examples
    --------
    >>> known = flexmech.published_constituents()
    >>> glass = flexmech.ply_from_constituents(known["E-glass"], known["polyester"], 0.6)
    >>> carbon = flexmech.ply_from_constituents(known["carbon"], known["polyester"], 0.6)
    >>> stack = [glass, carbon, glass]
    >>> laminate = flexmech.Laminate.stacked(stack, 1e-3, [0.0, 0.0, 0.0])
    >>> sheet = flexmech.SheetSection(laminate, in_plane_thickness=0.02)
    >>> area, mean = 3e-3 * 0.02, sum(ply.longitudinal_modulus for ply in stack) / 3
    >>> abs(sheet.axial_stiffness / (area * mean) - 1) < 1e-5
    True
    """

    laminate: Laminate
    in_plane_thickness: float

    reduction: ClassVar[Reduction] = "narrow"
    """Free to contract across the link."""
    direction: ClassVar[LayerDirection] = "across width"
    neutral_axis: ClassVar[float] = 0.0
    mass_axis: ClassVar[float] = 0.0

    def __post_init__(self) -> None:
        check_instance(self.laminate, Laminate, "laminate", "give Laminate(layers)")
        check_number(self.in_plane_thickness, "in_plane_thickness of a sheet", "m", POSITIVE)
        membrane, coupling = (self.laminate.stiffness_moment(order) for order in (0, 1))
        if np.abs(coupling).max() > SYMMETRIC * membrane[0, 0] * self.laminate.thickness:
            raise InputError(
                f"laminate {self.laminate.stacking} is not symmetric: with its layers across the "
                "width it would bend out of the plane of motion; make it symmetric, or state "
                'layers = "through thickness"'
            )
        flexibility = self._compliance
        if flexibility[0, 2] ** 2 > BALANCED * flexibility[0, 0] * flexibility[2, 2]:
            raise InputError(
                f"laminate {self.laminate.stacking} is not balanced: with its layers across the "
                "width it would shear as it is stretched; give every angle a layer of the opposite "
                'one, or state layers = "through thickness"'
            )

    def __repr__(self) -> str:
        breadth = f"{self.in_plane_thickness * 1e3:.6g} mm in the plane"
        return short_repr(self, self.laminate.stacking, breadth, "layers across the width")

    @property
    def width(self) -> float:
        """Along the joint axes, in m."""
        return self.laminate.thickness

    @property
    def breadth(self) -> float:
        """Its extent in the plane of the linkage."""
        return self.in_plane_thickness

    @property
    def edges(self) -> tuple[FloatArray, FloatArray]:
        """Edges y of each ply in m, (N,) each."""
        half = np.full(len(self.laminate.layers), self.in_plane_thickness / 2)
        return -half, half

    @cached_property
    def axial_stiffness(self) -> float:
        """EA in N."""
        return self._kept[0] * self.in_plane_thickness / float(self._compliance[0, 0])

    @cached_property
    def bending_stiffness(self) -> float:
        """EI in N m^2."""
        return self._kept[1] * self.in_plane_thickness**3 / (12 * float(self._compliance[0, 0]))

    @property
    def shear_stiffness(self) -> float:
        """Shear stiffness kGA in N, k = 5/6: the plies' shear strain is a parabola."""
        return self.shear_correction * self.in_plane_thickness / float(self._compliance[2, 2])

    @property
    def shear_correction(self) -> float:
        """Factor k of a solid rectangle."""
        return 5 / 6

    @property
    def rotary_inertia(self) -> float:
        """Mass moment rho I in kg m."""
        return self.mass_per_length * self.in_plane_thickness**2 / 12

    @cached_property
    def specific_damping(self) -> SpecificDamping:
        """Specific damping capacity: strain energies by ply and direction, as of stacked layers."""
        stretched = self._loss(self._compliance[:, 0])
        return SpecificDamping(stretched, stretched, self._loss(self._compliance[:, 2]), stretched)

    @cached_property
    def smeared(self) -> LaminateSection:
        """One layer of the plies' mean, which bends in the plane as they do."""
        thickness, compliance = self.laminate.thickness, self._compliance
        # Bending decides, where free edges make the modulus of stretching another one.
        modulus = self._kept[1] / (thickness * float(compliance[0, 0]))
        through = self.laminate.shear_moment(0) / thickness
        loss = self.specific_damping
        ply = Ply(
            longitudinal_modulus=modulus,
            transverse_modulus=1 / (thickness * float(compliance[1, 1])),
            in_plane_shear_modulus=float(through[1, 1]),
            longitudinal_shear_modulus=1 / (thickness * float(compliance[2, 2])),
            transverse_shear_modulus=float(through[0, 0]),
            poisson_ratio=-float(compliance[0, 1] / compliance[0, 0]),
            density=self.laminate.mass_moment(0) / thickness,
            specific_damping=PlyDamping(loss.bending, self._loss(compliance[:, 1]), loss.shear),
        )
        return LaminateSection(Laminate((Layer(ply, self.in_plane_thickness),)), thickness)

    def plane_state(
        self, axial_force: float, bending_moment: float, coupled: bool = True
    ) -> PlaneState:
        """Its layers under loads, in N and N m, by places in the plane of the linkage."""
        along = self._compliance[:, 0] / self._compliance[0, 0]
        strains = axial_force / self.axial_stiffness, -bending_moment / self.bending_stiffness
        shape = (len(self.laminate.layers), 2, 3)
        return PlaneState(self.laminate, np.broadcast_to(np.outer(strains, along), shape))

    def unit_shear(
        self, place: FloatArray, layer: IntArray, coupled: bool, theory: ShearTheory
    ) -> FloatArray:
        """Stresses x, z, xz, zy and xy in Pa by a unit shear force, (..., 5): a parabola."""
        stress, breadth = np.zeros((*place.shape, 5)), self.in_plane_thickness
        by_force = self.laminate.transformed_stiffness @ self._compliance[:, 2]
        parabola = 1.5 * (1 - (2 * place / breadth) ** 2) / breadth
        stress[..., :3] = by_force[layer] * parabola[..., None]
        return stress

    def resized(self, laminate: Laminate, growth: float) -> SheetSection:
        """The section of a laminate of other thickness, its plies broader by a factor.

        Parameters
        ----------
        laminate : Laminate
        growth : float

        Returns
        -------
        SheetSection
        """
        return SheetSection(laminate, growth * self.in_plane_thickness)

    def to_table(self, shared: SharedTables) -> TomlTable:
        """Keys of a link in a model file; the laminate is added to the shared tables."""
        return {
            "laminate": shared.name_of("laminates", self.laminate.to_table(shared), "laminate"),
            "layers": "across width",
            "in_plane_thickness": quantity(self.in_plane_thickness, LENGTH),
        }

    @cached_property
    def _compliance(self) -> FloatArray:
        """Strains x, z and xz by forces for each metre of breadth, (3, 3), in m/N."""
        return np.asarray(np.linalg.inv(self.laminate.stiffness_moment(0)))

    @property
    def _kept(self) -> tuple[float, float]:
        """Part of the stiffness against stretching and bending that free edges leave."""
        return _kept_by_free_edges(self.laminate, self.in_plane_thickness)

    def _loss(self, strain: FloatArray) -> float:
        """Specific damping capacity under in-plane strains (3,), the same in all plies."""
        thickness = np.array([[layer.thickness] for layer in self.laminate.layers])
        fields = np.broadcast_to(strain, (len(thickness), 1, 3))
        return lost_share(self.laminate, energy_by_direction(self.laminate, fields, thickness))


@lru_cache(maxsize=256)
def _kept_by_free_edges(laminate: Laminate, breadth: float) -> tuple[float, float]:
    """Stiffness against stretching and bending over that of plies that hold each other to the edge.

    Near the edges plies at angles are free of each other (:mod:`flexmech.sections.free_edges`):
    the section in three dimensions tells how much softer that makes the strip. The edges of
    broader strips stay as they are.
    """
    if not is_off_axis(laminate):
        return 1.0, 1.0
    ratio = breadth / laminate.thickness
    computed = float(np.clip(ratio, NARROWEST, WIDEST)) * laminate.thickness
    solid = laminate_solid(laminate, computed).compliance
    held = computed / np.linalg.inv(laminate.stiffness_moment(0))[0, 0]
    lost = 1 - np.array(
        [
            1 / (solid[STRETCH, STRETCH] * held),
            12 / (solid[ACROSS_PLANE, ACROSS_PLANE] * held * computed**2),
        ]
    )
    stretching, bending = 1 - lost * min(1.0, WIDEST / ratio)
    return float(stretching), float(bending)
