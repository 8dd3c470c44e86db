"""Residuals of constraints between bodies, their Jacobian and their rates, over a batch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.linkages.planar.bodies import BodyMotion, Coincidence, OnLine
from flexmech.linkages.planar.drawing import Drawing
from flexmech.types import ComplexArray, FloatArray


def dot(first: ComplexArray | complex, second: ComplexArray | complex) -> FloatArray:
    """Scalar product of vectors that are complex numbers."""
    return np.real(np.conj(first) * second)


@dataclass(frozen=True)
class Constraints:
    """Constraints that hold some bodies to each other and to others that are known.

    The unknowns of a body are the displacements of its reference point and its angle.

    Parameters
    ----------
    drawing : Drawing
    constraints : tuple of Coincidence and OnLine
    unknown : tuple of int
        Bodies whose unknowns count, in order.
    """

    drawing: Drawing
    constraints: tuple[Coincidence | OnLine, ...]
    unknown: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of equations."""
        return sum(2 if isinstance(own, Coincidence) else 1 for own in self.constraints)

    def residual(self, bodies: Mapping[int, BodyMotion]) -> FloatArray:
        """What is left of each equation in m; shape (B, n)."""
        rows: list[FloatArray] = []
        for own in self.constraints:
            drawn = self.drawing.complex_point(own.point)
            if isinstance(own, Coincidence):
                rows += _parts(bodies[own.first].point(drawn) - bodies[own.second].point(drawn))
            else:
                along, gap = self._line(own, bodies)
                rows.append(dot(1j * along, gap))
        return np.stack(np.broadcast_arrays(*rows), axis=-1)

    def rates(self, bodies: Mapping[int, BodyMotion]) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of the residuals by the crank angle; shapes (B, n)."""
        first: list[FloatArray] = []
        second: list[FloatArray] = []
        for own in self.constraints:
            drawn = self.drawing.complex_point(own.point)
            if isinstance(own, Coincidence):
                one, other = bodies[own.first], bodies[own.second]
                first += _parts(one.point_1(drawn) - other.point_1(drawn))
                second += _parts(one.point_2(drawn) - other.point_2(drawn))
                continue
            along, gap = self._line(own, bodies)
            body, guide = bodies[own.body], bodies[own.guide]
            across, distance = 1j * along, dot(along, gap)
            gap_1 = body.point_1(drawn) - guide.point_1(drawn)
            gap_2 = body.point_2(drawn) - guide.point_2(drawn)
            first.append(dot(across, gap_1) - distance * guide.turn_1)
            sliding = dot(along, gap_1)
            second.append(dot(across, gap_2) - distance * guide.turn_2 - 2 * sliding * guide.turn_1)
        return (
            np.stack(np.broadcast_arrays(*first), axis=-1),
            np.stack(np.broadcast_arrays(*second), axis=-1),
        )

    def jacobian(self, bodies: Mapping[int, BodyMotion]) -> FloatArray:
        """Derivative of the residuals by the unknowns; shape (B, n, 3 bodies)."""
        size = bodies[self.unknown[0]].place.shape
        matrix = np.zeros((*size, self.count, 3 * len(self.unknown)))
        row = 0
        for own in self.constraints:
            drawn = self.drawing.complex_point(own.point)
            if isinstance(own, Coincidence):
                for number, sign in ((own.first, 1.0), (own.second, -1.0)):
                    if number in self.unknown:
                        column, body = 3 * self.unknown.index(number), bodies[number]
                        swing = 1j * body.turn * (drawn - body.drawn)
                        matrix[..., row, column] = matrix[..., row + 1, column + 1] = sign
                        matrix[..., row, column + 2] = sign * swing.real
                        matrix[..., row + 1, column + 2] = sign * swing.imag
                row += 2
                continue
            along, gap = self._line(own, bodies)
            across = 1j * along
            for number, sign in ((own.body, 1.0), (own.guide, -1.0)):
                if number in self.unknown:
                    column, body = 3 * self.unknown.index(number), bodies[number]
                    swing = 1j * body.turn * (drawn - body.drawn)
                    turning = sign * dot(across, swing)
                    if number == own.guide:
                        turning = turning - dot(along, gap)
                    matrix[..., row, column] = sign * across.real
                    matrix[..., row, column + 1] = sign * across.imag
                    matrix[..., row, column + 2] = turning
            row += 1
        return matrix

    def _line(
        self, own: OnLine, bodies: Mapping[int, BodyMotion]
    ) -> tuple[ComplexArray, ComplexArray]:
        """Unit vector of a line, and from where it passed in the drawing to the point now."""
        drawn, guide = self.drawing.complex_point(own.point), bodies[own.guide]
        return guide.turn * own.along, bodies[own.body].point(drawn) - guide.point(drawn)


def _parts(vector: ComplexArray) -> list[FloatArray]:
    return [np.asarray(vector.real), np.asarray(vector.imag)]
