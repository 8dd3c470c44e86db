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

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.materials import Laminate, Layer, Ply, PlyDamping
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr
from flexmech.sections.beam_reduction import Reduction, energy_by_direction, lost_share
from flexmech.sections.damping import SpecificDamping
from flexmech.sections.free_edges import (
    NARROWEST,
    WIDEST,
    is_off_axis,
    laminate_solid,
)
from flexmech.sections.laminate_section import LaminateSection
from flexmech.sections.shear_theories import (
    SHEAR_THEORIES,
    LayerDirection,
    ShearTheory,
    ThroughThickness,
    check_loads,
)
from flexmech.sections.solid_section import ACROSS_PLANE, STRETCH
from flexmech.units import LENGTH
from flexmech.validation import POSITIVE, check_choice, check_instance, check_number

# Part of the plies' stiffness that may couple stretching with bending out of the plane: round-off.
SYMMETRIC = 1e-9
# Square of the coupling of stretching with shear over both flexibilities, below which no frequency
# shows it. Layers at opposite angles that are unevenly moist, at different depths, have 3e-9.
BALANCED = 1e-6


@dataclass(frozen=True)
class SheetSection:
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
    """Of the stack."""
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
        """Extent of the plies across the link in m."""
        return self.in_plane_thickness

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
    def mass_per_length(self) -> float:
        """Mass rho A in kg/m."""
        return self.in_plane_thickness * self.laminate.mass_moment(0)

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

    def places(self, per_layer: int) -> FloatArray:
        """Places across each ply in the plane of the linkage, edges included.

        Parameters
        ----------
        per_layer : int

        Returns
        -------
        ndarray, shape (N, per_layer)
            In m, the same of all plies.
        """
        return np.repeat(self.smeared.places(per_layer), len(self.laminate.layers), axis=0)

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
        """Strain and stress of each ply under loads, away from the ends of the link.

        Parameters
        ----------
        place : ndarray, shape (N, m)
            In m from the middle, a row for each ply.
        axial_force : float
            In N.
        bending_moment : float
            In N m; positive stretches the side of lower y.
        shear_force : float
            In N, along y on the face towards higher x.
        coupled : bool
            Without meaning: nothing is coupled.
        theory : {"equilibrium", "third-order"}
            The same parabola by both.

        Returns
        -------
        ThroughThickness
            The shear stress of plies at angles includes what stretching them takes, which cancels
            over all plies.

        Raises
        ------
        InputError
            If a place is outside the section, there is not a row for each ply, a load is not a
            number or the theory unknown.
        """
        check_loads((axial_force, bending_moment, shear_force))
        check_choice(theory, SHEAR_THEORIES, "theory")
        place = np.asarray(place, dtype=float)
        count, half = len(self.laminate.layers), self.in_plane_thickness / 2
        if place.ndim != 2 or len(place) != count:
            raise InputError(
                f"places must have one row for each of the {count} plies; got shape {place.shape}"
            )
        if not np.all(np.abs(place) <= half * (1 + SAME_PLACE)):
            raise InputError(f"places must be within {half:.6g} m of the middle")
        stress = self.plane_stress(place, axial_force, bending_moment, shear_force)
        return ThroughThickness(
            place=place,
            strain=self._strain(place, axial_force, bending_moment),
            normal_stress=stress[..., 0],
            shear_stress=stress[..., 2],
        )

    def plane_stress(
        self, place: FloatArray, axial_force: float, bending_moment: float, shear_force: float
    ) -> FloatArray:
        """Stress of each ply along the link, across it and in shear, in the linkage's plane.

        Parameters
        ----------
        place : ndarray, shape (N, m)
            In m from the middle, a row for each ply.
        axial_force, bending_moment, shear_force : float
            In N, N m and N, signed as in :meth:`stresses`.

        Returns
        -------
        ndarray, shape (N, m, 3)
            In Pa.
        """
        strain = self._strain(place, axial_force, bending_moment)
        along, sheared = self._compliance[:, 0], self._compliance[:, 2]
        stiffness = self.laminate.transformed_stiffness
        parabola = 1.5 * (1 - (2 * place / self.in_plane_thickness) ** 2) / self.in_plane_thickness
        stress = np.einsum("nij,j,nm->nmi", stiffness, along / along[0], strain)
        shear = np.einsum("nij,j,nm->nmi", stiffness, sheared, shear_force * parabola)
        return np.asarray(stress + shear)

    def _strain(self, place: FloatArray, axial_force: float, moment: float) -> FloatArray:
        """Along the link."""
        return axial_force / self.axial_stiffness - place * moment / self.bending_stiffness

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
