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
from flexmech.mechanics import chain_matrix
from flexmech.mechanics.beams.elements import BeamElements

# Step of differences over a radian or an element's length: half the digits.
DIFFERENCE = 1e-7


@dataclass(frozen=True)
class ElementNumbers:
    """Constants of e elements, by which their forces are computed.

    Parameters
    ----------
    length : ndarray, shape (e, 1)
        In m.
    axial_stiffness : float
        EA in N.
    bending, arch : ndarray, shape (e, k, k)
        Stiffness against what turns and bends an element, and mean of the squared slope.
    """

    length: FloatArray
    axial_stiffness: float
    bending: FloatArray
    arch: FloatArray


@dataclass(frozen=True)
class RigidArms:
    """Rigid arms at the nodes of an element, in its relative coordinates.

    An arm of length ``a`` at angle ``phi`` moves the neutral axis's node by ``-a sin(phi)`` along
    and ``-a (1 - cos(phi))`` across.

    Parameters
    ----------
    places : tuple of int
        Relative coordinates that turn an arm; none where the neutral axis is the pins' axis.
    length : ndarray, shape (number of places, 1)
        In m; with its sign turned for arms of the first node, against which the second moves.
    """

    places: tuple[int, ...]
    length: FloatArray

    @classmethod
    def of(cls, elements: BeamElements) -> RigidArms:
        """Arms of elements."""
        shapes = elements.shapes
        arms = [
            (a, arm)
            for a, arm in zip(shapes.angles, shapes.arms(elements.section), strict=True)
            if arm
        ]
        ends = ((0, -1.0), (shapes.per_node - 2, 1.0))
        used = [(first + a, sign * arm) for first, sign in ends for a, arm in arms]
        places = tuple(place for place, _ in used)
        return cls(places, np.array([arm for _, arm in used]).reshape(-1, 1))

    def moved(self, relative: FloatArray) -> FloatArray:
        """Relative coordinates (e, r, B) of the nodes on the neutral axis."""
        if not self.places:
            return relative
        angle = relative[:, self.places]
        moved = relative.copy()
        moved[:, 0] -= (self.length * np.sin(angle)).sum(axis=1)
        moved[:, 1] -= (2 * self.length * np.sin(angle / 2) ** 2).sum(axis=1)
        return moved

    def turn(self, relative: FloatArray, force: FloatArray | None, tangent: FloatArray) -> None:
        """Transform forces and a tangent from the neutral axis to the pins' axis, in place.

        Parameters
        ----------
        relative : ndarray, shape (e, r, B)
            On the pins' axis.
        force : ndarray, shape (e, r, B), optional
            Without it the part of the tangent that turns it is left out.
        tangent : ndarray, shape (e, r, r, B)
        """
        if not self.places:
            return
        angle = relative[:, self.places]
        sine, cosine = self.length * np.sin(angle), self.length * np.cos(angle)
        for number, place in enumerate(self.places):
            s, c = sine[:, number], cosine[:, number]
            tangent[:, place] -= c[:, None] * tangent[:, 0] + s[:, None] * tangent[:, 1]
        for number, place in enumerate(self.places):
            s, c = sine[:, number], cosine[:, number]
            tangent[:, :, place] -= c[:, None] * tangent[:, :, 0] + s[:, None] * tangent[:, :, 1]
            if force is not None:
                tangent[:, place, place] += force[:, 0] * s - force[:, 1] * c
                force[:, place] -= force[:, 0] * c + force[:, 1] * s


def in_positions(values: FloatArray, which: IntArray) -> FloatArray:
    """Values (..., B) in some positions, which stay along memory: by an index they would not."""
    return np.take(values, which, axis=-1)


def by_elements(matrix: FloatArray, turns: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) of elements times columns (e, k, B)."""
    if matrix.ndim == 3:
        return np.asarray(matrix @ turns)
    return np.asarray(np.einsum("eijb,ejb->eib", matrix, turns))


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

    def relative(self, q: FloatArray) -> FloatArray:
        """Relative coordinates (e, r, B) by those of the link's nodes, (n, B)."""
        nodal = q.reshape(-1, self.elements.shapes.per_node, q.shape[1])
        first, second = nodal[:-1], nodal[1:]
        return np.concatenate([second[:, :2] - first[:, :2], first[:, 2:], second[:, 2:]], axis=1)

    def on_nodes(self, force: FloatArray) -> FloatArray:
        """Forces on the link's nodes (n, B) from those by the relative coordinates, (e, r, B)."""
        (count, _, batch), per_node = force.shape, self.elements.shapes.per_node
        total = np.zeros((count + 1, per_node, batch))
        total[:-1, :2] -= force[:, :2]
        total[1:, :2] += force[:, :2]
        total[:-1, 2:] += force[:, 2:per_node]
        total[1:, 2:] += force[:, per_node:]
        return total.reshape(-1, batch)

    def by_relative(self, matrix: FloatArray) -> FloatArray:
        """Matrices by relative coordinates; (B, e, 2 p, 2 p) -> (e, r, r, B).

        A displacement of both nodes alike must meet no force.
        """
        # With the first node fixed the nodal coordinates are the relative ones.
        per_node = self.elements.shapes.per_node
        columns = np.concatenate([[per_node, per_node + 1], self._own])
        return np.ascontiguousarray(np.moveaxis(matrix, 0, -1)[:, columns[:, None], columns])

    def of_nodes(self, matrix: FloatArray) -> FloatArray:
        """Element matrices in nodal coordinates: (e, r, r, B) -> (e, 2 p, 2 p, B)."""
        places, signs = self.relative_places, self.node_signs
        return np.asarray(
            matrix[:, places[:, None], places] * np.outer(signs, signs)[..., None], dtype=float
        )

    def of_link(self, matrix: FloatArray) -> FloatArray:
        """Matrix of the link from those by relative coordinates: (e, r, r, B) -> (B, n, n)."""
        return chain_matrix(np.moveaxis(self.of_nodes(matrix), -1, 0))

    def response(
        self,
        relative: FloatArray,
        swelling: float = 1.0,
        before: LinearStrain | None = None,
        out: FloatArray | None = None,
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

        Returns
        -------
        ElementResponse
        """
        moved, numbers = self._arms.moved(relative), self._numbers
        pure = self._pure(moved, numbers)
        bending = by_elements(numbers.bending, pure.turns - swelling * self._arc)
        stress = self._stress(pure, bending, pure.strain, swelling, numbers)
        force = pure.by_relative_coordinates(*stress)
        tangent = np.empty((*relative.shape[:2], *relative.shape[1:])) if out is None else out
        for_tangent = stress
        if before is not None:
            for_tangent = self._stress(pure, bending, before.at(moved), swelling, numbers)
        self._fill(tangent, pure, numbers, for_tangent)
        self._arms.turn(relative, force, tangent)
        gradient = pure.by_relative_coordinates(
            1 / numbers.length, pure.lift, pure.lift[:, self._angles].sum(axis=1)
        )
        return ElementResponse(force, tangent, LinearStrain(moved, pure.strain, gradient))

    def damping(self, relative: FloatArray) -> FloatArray:
        """Kelvin-Voigt damping matrix of deformed elements.

        A bowed element that bends further stretches no fibre on its axis, and nothing is to
        be damped there: only what strains the material counts, not the part of the tangent
        that comes from the stress.

        Parameters
        ----------
        relative : ndarray, shape (e, r, B)

        Returns
        -------
        ndarray, shape (e, r, r, B)
        """
        pure = self._pure(self._arms.moved(relative), self._numbers)
        matrix = np.empty((*relative.shape[:2], *relative.shape[1:]))
        axial = float(self.elements.section.damping_times[0]) * self._numbers.axial_stiffness
        bending = self._own_part(self.elements.neutral_damping)
        damped = replace(self._numbers, axial_stiffness=axial, bending=bending)
        self._fill(matrix, pure, damped, None)
        self._arms.turn(relative, None, matrix)
        return matrix

    def damping_stiffness(self, relative: FloatArray, rate: FloatArray) -> FloatArray:
        """Derivative of the damping forces of deformed elements by their displacement.

        By differences, which is near enough for Newton's method.

        Parameters
        ----------
        relative, rate : ndarray, shape (e, r, B)
            And its time derivative.

        Returns
        -------
        ndarray, shape (e, r, r, B)
        """
        before = by_elements(self.damping(relative), rate)
        columns = []
        for coordinate in range(relative.shape[1]):
            step = DIFFERENCE * (self._numbers.length if coordinate < 2 else np.ones((1, 1)))
            moved = relative.copy()
            moved[:, coordinate] += step
            change = by_elements(self.damping(moved), rate) - before
            columns.append(change / step[:, None])
        return np.stack(columns, axis=2)

    @cached_property
    def relative_places(self) -> IntArray:
        """Relative coordinate of each nodal coordinate, (2 p,)."""
        inner = self.elements.shapes.per_node - 2
        ends = np.arange(2)
        return np.concatenate([ends, 2 + np.arange(inner), ends, 2 + inner + np.arange(inner)])

    @cached_property
    def node_signs(self) -> FloatArray:
        """Sign of each nodal coordinate in it, (2 p,): -1 for displacements of the first node."""
        return np.where(np.arange(2 * self.elements.shapes.per_node) < 2, -1.0, 1.0)

    @cached_property
    def _own(self) -> IntArray:
        """Coordinates of an element other than displacements, (k,)."""
        per_node = self.elements.shapes.per_node
        every = np.arange(2 * per_node)
        return every[every % per_node >= 2]

    @cached_property
    def _angles(self) -> IntArray | slice:
        """Numbers of the angles among them: mostly all, of which a slice makes no copy."""
        shapes = self.elements.shapes
        angles = np.isin(self._own % shapes.per_node, shapes.angles)
        return slice(None) if angles.all() else np.flatnonzero(angles)

    @cached_property
    def _arms(self) -> RigidArms:
        return RigidArms.of(self.elements)

    @cached_property
    def _arc(self) -> FloatArray:
        """Rotations of the nodes of elements by free curvature, (e, k, 1)."""
        return self.elements.shapes.arc(self.elements.section, self.elements.length)[..., None]

    def _own_part(self, matrix: FloatArray) -> FloatArray:
        """Block of the coordinates other than displacements; (e, 2 p, 2 p) -> (e, k, k)."""
        return matrix[:, self._own[:, None], self._own]

    @cached_property
    def _numbers(self) -> ElementNumbers:
        elements = self.elements
        axial = float(elements.neutral_stiffness[0, 0, 0] * elements.length[0])
        inner = (self._own_part(x) for x in (elements.neutral_stiffness, elements.arch))
        return ElementNumbers(elements.length[:, None], axial, *inner)

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
        inner = matrix[:, 2:, 2:]
        lift = numbers.axial_stiffness * pure.lift
        np.multiply((lift * length[:, None])[:, :, None], pure.lift[:, None], out=inner)
        inner += numbers.bending[..., None]
        if stress is not None:
            inner += (stress.tension * length)[:, None, None] * numbers.arch[..., None]
        by_turn = inner[:, self._angles].sum(axis=1)
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
