"""Geometrically nonlinear plane beam elements in corotational coordinates.

An element's pure deformation is its elongation and what its nodes turn and bend against
its chord; large rotations are those of the chord. The axial strain is averaged over the
element and contains the slopes (shallow arch), so that the tangent at a straight, tensioned
element is exactly eq. 1.58 of Kumar & Chandrakar and no membrane locking appears. After
Crisfield, *Non-linear Finite Element Analysis of Solids and Structures*, vol. 1 (1991),
ch. 7. Where the neutral axis is off the pins' axis, rigid arms that turn with the nodes
lead to it. Without load an element has the strain and the curvature that its section takes
by itself: the strain is that of the arc, so that a chord shortens as it bends.

Forces come from the *relative coordinates* of an element alone: the displacement of its second
node against its first, along and across, then all other coordinates of the first node, then
those of the second. Arrays of them end with the batch of positions, so that every operation
runs over many numbers at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.elements import BeamElements
from flexmech.reference.element_numbers import (
    ElementNumbers,
    by_elements,
    in_positions,
    over_positions,
)
from flexmech.reference.rigid_arms import RigidArms
from flexmech.sections import damping_times

# Step of differences over a radian or an element's length: half the digits.
DIFFERENCE = 1e-7


@dataclass(frozen=True)
class LinearStrain:
    """Axial strain of elements to first order about a deformed state.

    Parameters
    ----------
    relative : ndarray, shape (e, r, B)
        Relative coordinates of the neutral axis's nodes in that state.
    strain : ndarray, shape (e, B)
    gradient : ndarray, shape (e, r, B)
        By the relative coordinates.
    """

    relative: FloatArray
    strain: FloatArray
    gradient: FloatArray

    def at(self, relative: FloatArray) -> FloatArray:
        """Strain (e, B) at relative coordinates (e, r, B)."""
        change = self.gradient * (relative - self.relative)
        return np.asarray(self.strain + change.sum(axis=1), dtype=float)

    def of(self, which: IntArray) -> LinearStrain:
        """Strain of some positions."""
        return LinearStrain(*(in_positions(values, which) for values in vars(self).values()))


class ElementResponse(NamedTuple):
    """Internal forces, tangent and strain of elements in relative coordinates.

    Parameters
    ----------
    force : ndarray, shape (e, r, B)
    tangent : ndarray, shape (e, r, r, B)
    strain : LinearStrain
        About the displacement.
    """

    force: FloatArray
    tangent: FloatArray
    strain: LinearStrain


@dataclass(frozen=True)
class CorotationalElements:
    """Corotational elements of one link: large rotations, small deformations.

    Parameters
    ----------
    elements : BeamElements
        Their small displacements: e elements of p coordinates a node. Each has
        r = 2 (p - 1) relative coordinates, k = 2 (p - 2) of which turn and bend it.
    """

    elements: BeamElements

    def response(
        self, displacement: FloatArray, swelling: float = 1.0
    ) -> tuple[FloatArray, FloatArray]:
        """Internal forces and tangent stiffness of deformed elements.

        Parameters
        ----------
        displacement : ndarray, shape (B, e, 2 p)
            Coordinates of each element's nodes in the frame of the straight link.
        swelling : float
            Part of the section's free strain and curvature that has come on.

        Returns
        -------
        force : ndarray, shape (B, e, 2 p)
        tangent : ndarray, shape (B, e, 2 p, 2 p)
        """
        force, tangent, _ = self.relative_response(self._relative(displacement), swelling)
        of_nodes = self.node_signs[:, None] * force[:, self.relative_places]
        return np.moveaxis(of_nodes, -1, 0), np.moveaxis(self.of_nodes(tangent), -1, 0)

    def relative_response(
        self,
        relative: FloatArray,
        swelling: float = 1.0,
        before: LinearStrain | None = None,
        out: FloatArray | None = None,
        design: IntArray | None = None,
    ) -> ElementResponse:
        """Internal forces and tangent stiffness by the relative coordinates.

        Parameters
        ----------
        relative : ndarray, shape (e, r, B)
        swelling : float
            Part of the section's free strain and curvature that has come on.
        before : LinearStrain, optional
            About the state that a step of Newton's method came from: the tangent is taken with the
            tension to which it leads. Left out: with the tension of the state itself.
        out : ndarray, shape (e, r, r, B), optional
            Where to write the tangent.
        design : ndarray of int, shape (B,), optional
            Of each position, where elements are those of several designs.

        Returns
        -------
        ElementResponse
        """
        moved, numbers = self._arms.moved(relative), self._numbers_at(design)
        pure = self._pure(moved, numbers)
        bending = by_elements(numbers.bending, pure.turns - swelling * self._arc)
        own = self._stress(pure, bending, pure.strain, swelling, numbers)
        force = pure.by_relative_coordinates(*own)
        tangent = np.empty((*relative.shape[:2], *relative.shape[1:])) if out is None else out
        for_tangent = own
        if before is not None:
            for_tangent = self._stress(pure, bending, before.at(moved), swelling, numbers)
        self._fill(tangent, pure, numbers, for_tangent)
        self._arms.turn_tangent(relative, tangent, force)
        self._arms.turn_force(relative, force)
        gradient = pure.by_relative_coordinates(
            1 / numbers.length, pure.lift, pure.lift[:, self._angles].sum(axis=1)
        )
        return ElementResponse(force, tangent, LinearStrain(moved, pure.strain, gradient))

    def damping(self, displacement: FloatArray, design: IntArray | None = None) -> FloatArray:
        """Kelvin-Voigt damping matrix of deformed elements.

        A bowed element that bends further stretches no fibre on its axis, and nothing is to
        be damped there: only what strains the material counts, not the part of the tangent
        that comes from the stress.

        Parameters
        ----------
        displacement : ndarray, shape (B, e, 2 p)
            As in :meth:`response`.
        design : ndarray of int, shape (B,), optional
            As in :meth:`relative_response`.

        Returns
        -------
        ndarray, shape (B, e, 2 p, 2 p)
        """
        relative, numbers = self._relative(displacement), self._numbers_at(design)
        pure = self._pure(self._arms.moved(relative), numbers)
        matrix = np.empty((*relative.shape[:2], *relative.shape[1:]))
        axial = damping_times(self.elements.section)[..., 0] * self._numbers.axial_stiffness
        own = self._by_design(self._own_part(self.elements.neutral_damping))
        damped = replace(self._numbers, axial_stiffness=axial, bending=own)
        self._fill(matrix, pure, damped if design is None else damped.at(design), None)
        self._arms.turn_tangent(relative, matrix, None)
        return np.moveaxis(self.of_nodes(matrix), -1, 0)

    def damping_stiffness(self, displacement: FloatArray, rate: FloatArray) -> FloatArray:
        """Derivative of the damping forces of deformed elements by their displacement.

        By differences, which is near enough for Newton's method.

        Parameters
        ----------
        displacement, rate : ndarray, shape (B, e, 2 p)
            As in :meth:`response`, and its time derivative.

        Returns
        -------
        ndarray, shape (B, e, 2 p, 2 p)
        """
        per_node, count = self.elements.shapes.per_node, displacement.shape[-1]
        columns = np.zeros((*displacement.shape, count))

        def forces(place: FloatArray) -> FloatArray:
            return np.asarray((self.damping(place) @ rate[..., None])[..., 0])

        before, length = forces(displacement), self.elements.length[:, None]
        for column in self.relative_part:
            step = DIFFERENCE * (length if column % per_node < 2 else np.ones_like(length))
            moved = displacement.copy()
            moved[..., column] += step[:, 0]
            columns[..., column] = (forces(moved) - before) / step
        # What both nodes move by alike changes nothing.
        columns[..., :2] = -columns[..., per_node : per_node + 2]
        return columns

    def of_nodes(self, matrix: FloatArray) -> FloatArray:
        """Element matrices in nodal coordinates: (e, r, r, B) -> (e, 2 p, 2 p, B)."""
        places, signs = self.relative_places, self.node_signs
        return np.asarray(
            matrix[:, places[:, None], places] * np.outer(signs, signs)[..., None], dtype=float
        )

    @cached_property
    def relative_places(self) -> IntArray:
        """Relative coordinate of each nodal coordinate, (2 p,)."""
        own = self.elements.shapes.per_node - 2
        ends = np.arange(2)
        return np.concatenate([ends, 2 + np.arange(own), ends, 2 + own + np.arange(own)])

    @cached_property
    def node_signs(self) -> FloatArray:
        """Sign of each nodal coordinate in it, (2 p,): -1 for displacements of the first node."""
        return np.where(np.arange(2 * self.elements.shapes.per_node) < 2, -1.0, 1.0)

    @cached_property
    def relative_part(self) -> IntArray:
        """Nodal coordinates that are the relative ones with the first node fixed, (r,)."""
        per_node = self.elements.shapes.per_node
        return np.concatenate([[per_node, per_node + 1], self._own])

    def _relative(self, displacement: FloatArray) -> FloatArray:
        nodal = np.moveaxis(displacement, 0, -1)
        per_node = self.elements.shapes.per_node
        moved = nodal[:, per_node : per_node + 2] - nodal[:, :2]
        return np.concatenate([moved, nodal[:, self._own]], axis=1)

    @cached_property
    def _own(self) -> IntArray:
        """Coordinates of an element other than displacements, (k,)."""
        per_node = self.elements.shapes.per_node
        every = np.arange(2 * per_node)
        return every[every % per_node >= 2]

    @cached_property
    def _angles(self) -> IntArray | slice:
        """Which of them are angles: mostly all, of which a slice makes no copy."""
        shapes = self.elements.shapes
        angles = np.isin(self._own % shapes.per_node, shapes.angles)
        return slice(None) if angles.all() else np.flatnonzero(angles)

    @cached_property
    def _arms(self) -> RigidArms:
        return RigidArms.of(self.elements)

    @cached_property
    def _arc(self) -> FloatArray:
        """Rotations of the nodes of elements by free curvature, (e, k, 1); none of a stack."""
        if self.elements.length.ndim > 1:
            return np.zeros((1, 1, 1))
        return self.elements.shapes.arc(self.elements.section, self.elements.length)[..., None]

    def _own_part(self, matrix: FloatArray) -> FloatArray:
        """Block of the coordinates other than displacements; (..., e, 2 p, 2 p) -> (..., k, k)."""
        return matrix[..., self._own[:, None], self._own]

    def _by_design(self, values: FloatArray) -> FloatArray:
        """Numbers of elements with the designs behind them, where there are several."""
        return values if self.elements.length.ndim == 1 else np.moveaxis(values, 0, -1)

    @cached_property
    def _numbers(self) -> ElementNumbers:
        """Of one design, or (..., D) of several."""
        elements = self.elements
        axial = elements.neutral_stiffness[..., 0, 0, 0] * elements.length[..., 0]
        length = elements.length[..., None] if elements.length.ndim == 1 else elements.length.T
        own = (self._own_part(x) for x in (elements.neutral_stiffness, elements.arch))
        return ElementNumbers(length, np.asarray(axial), *map(self._by_design, own))

    def _numbers_at(self, design: IntArray | None) -> ElementNumbers:
        return self._numbers if design is None else self._numbers.at(design)

    def _pure(self, relative: FloatArray, numbers: ElementNumbers) -> _PureDeformation:
        length = numbers.length
        du, dv = relative[:, 0], relative[:, 1]
        along = length + du
        chord = np.hypot(along, dv)
        # (chord^2 - length^2) / (chord + length): no cancellation at small strain
        elongation = ((2 * length + du) * du + dv**2) / (chord + length)
        turns = relative[:, 2:].copy()
        turns[:, self._angles] -= np.arctan2(dv, along)[:, None]
        lift = by_elements(numbers.arch, turns)
        strain = elongation / length + (turns * lift).sum(axis=1) / 2
        return _PureDeformation(chord, along / chord, dv / chord, strain, turns, lift)

    def _stress(
        self,
        pure: _PureDeformation,
        bending: FloatArray,
        strain: FloatArray,
        swelling: float,
        numbers: ElementNumbers,
    ) -> _Stress:
        """Stress of bending moments (e, k, B) and of an axial strain (e, B)."""
        free = swelling * self.elements.section.free_strain
        tension = numbers.axial_stiffness * (strain - free)
        moments = bending + (tension * numbers.length)[:, None] * pure.lift
        return _Stress(tension, moments, moments[:, self._angles].sum(axis=1))

    def _fill(
        self,
        matrix: FloatArray,
        pure: _PureDeformation,
        numbers: ElementNumbers,
        stress: _Stress | None,
    ) -> None:
        """Write the derivative of the forces on the neutral axis's nodes, (e, r, r, B).

        Parameters
        ----------
        matrix : ndarray, shape (e, r, r, B)
        pure : _PureDeformation
        numbers : ElementNumbers
        stress : _Stress, optional
            None leaves the part that comes from it out.
        """
        length, cosine, sine = numbers.length, pure.cosine, pure.sine
        own = matrix[:, 2:, 2:]
        lift = numbers.axial_stiffness * pure.lift
        np.multiply((lift * length[:, None])[:, :, None], pure.lift[:, None], out=own)
        own += over_positions(numbers.bending)
        if stress is not None:
            own += (stress.tension * length)[:, None, None] * over_positions(numbers.arch)
        by_turn = own[:, self._angles].sum(axis=1)
        turning = by_turn[:, self._angles].sum(axis=1)
        both = -lift[:, self._angles].sum(axis=1)
        if stress is not None:
            turning += stress.tension * pure.chord
            both += stress.couple / pure.chord
        stretching = numbers.axial_stiffness / length
        # Gradient of the chord's angle, without its signs.
        across, along = sine / pure.chord, cosine / pure.chord
        matrix[:, 0, 0] = (stretching * cosine - 2 * both * across) * cosine + turning * across**2
        matrix[:, 1, 1] = (stretching * sine + 2 * both * along) * sine + turning * along**2
        matrix[:, 0, 1] = (
            (stretching * sine + both * along) * cosine - both * sine * across
        ) - turning * across * along
        matrix[:, 1, 0] = matrix[:, 0, 1]
        matrix[:, 0, 2:] = lift * cosine[:, None] + by_turn * across[:, None]
        matrix[:, 1, 2:] = lift * sine[:, None] - by_turn * along[:, None]
        matrix[:, 2:, :2] = np.swapaxes(matrix[:, :2, 2:], 1, 2)


@dataclass(frozen=True)
class _PureDeformation:
    """Deformation of elements (e, B) against their chords.

    ``cosine`` and ``sine`` are of the chord's angle, ``turns`` (e, k, B) the nodes' turns and
    bends, ``lift`` the derivative of the axial strain by them.
    """

    chord: FloatArray
    cosine: FloatArray
    sine: FloatArray
    strain: FloatArray
    turns: FloatArray
    lift: FloatArray

    def by_relative_coordinates(
        self, axial: FloatArray, turning: FloatArray, couple: FloatArray
    ) -> FloatArray:
        """Relative forces of those on chord length (e, B) and rotations (e, k, B); (e, r, B).

        ``couple`` is the sum over the turns that are angles, which the chord's own angle meets.
        """
        result = np.empty((len(turning), 2 + turning.shape[1], turning.shape[2]))
        result[:, 0] = axial * self.cosine + couple * self.sine / self.chord
        result[:, 1] = axial * self.sine - couple * self.cosine / self.chord
        result[:, 2:] = turning
        return result


class _Stress(NamedTuple):
    """Tension (e, B), moments of the nodes (e, k, B) and the sum of those that turn (e, B)."""

    tension: FloatArray
    moments: FloatArray
    couple: FloatArray
