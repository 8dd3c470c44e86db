"""The cubic whose roots are the finite double points of a coupler curve.

See :mod:`flexmech.linkages.coupler_curves.double_points` for its derivation. Written with
homogeneous w = t / s, it is a binary form of degree three: a root at infinity is as good as
another.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flexmech.linkages.coupler_curves.curve import CouplerTriangle

Coefficients = tuple[float, ...]

# Directions of (s, t) of which at least one is well away from all three roots.
CHARTS = tuple(math.pi * n / 4 for n in range(-1, 3))
# What the three roots of Viete's formula differ by in its angle.
THIRDS = (0.0, 2 * math.pi / 3, -2 * math.pi / 3)
# A bound of work: steps end where they no longer improve a root. A root of the formulas has half of
# its digits or more where two nearly merge; each step doubles them, and one more meets what
# rounding allows.
NEWTON_STEPS = 3


@dataclass(frozen=True)
class FocalCubic:
    """Closure of both circles at a point of the circle of singular foci.

    Parameters
    ----------
    ground, crank, rocker : float
        Link lengths d, a and c in m.
    triangle : CouplerTriangle
        With both arms positive.
    """

    ground: float
    crank: float
    rocker: float
    triangle: CouplerTriangle

    def value(self, s: float, t: float) -> float:
        """Residual of the cubic in m^3, homogeneous of degree three in its arguments."""
        e, f, cosine, sine = self.triangle
        square = s * s + (sine * t) ** 2
        to_o2, to_o4 = self.ground * (s + cosine * t), self.ground * t
        near = (self.crank - e) * (self.crank + e) * square - to_o2**2
        far = (self.rocker - f) * (self.rocker + f) * square - to_o4**2
        return (near * f * to_o4 - far * e * to_o2) / self.ground

    def discriminant(self) -> float:
        """Positive with three real roots, negative with one, zero where two merge; in m^12."""
        d, c, b, a = self._chart(self._away())
        return (b * c) ** 2 - 4 * a * c**3 - 4 * b**3 * d - 27 * (a * d) ** 2 + 18 * a * b * c * d

    def roots(self) -> tuple[float, ...]:
        """Real roots as angles arctan(t / s) from -pi/2 to pi/2, growing; one or three.

        A double root counts twice or not at all as round-off has it.
        """
        away = self._away()
        chart = self._chart(away)
        found = (self._polished(away, chart, x) for x in _real_roots(chart))
        return tuple(sorted(_half_turn(away + math.pi / 2 + math.atan(x)) for x in found))

    def _away(self) -> float:
        """Direction away from the roots."""
        return max(CHARTS, key=lambda angle: abs(self.value(math.cos(angle), math.sin(angle))))

    def _chart(self, away: float) -> Coefficients:
        """Coefficients, constant first, in x = tan(angle - away - pi/2)."""
        cos, sin = math.cos(away), math.sin(away)
        # (s, t) = (-sin, cos) - x (cos, sin): the direction ``away`` is at infinity.
        values = [self.value(-sin - x * cos, cos - x * sin) for x in (-1.0, 0.0, 1.0)]
        leading = -self.value(cos, sin)
        even = (values[2] + values[0]) / 2 - values[1]
        odd = (values[2] - values[0]) / 2 - leading
        return (values[1], odd, even, leading)

    def _polished(self, away: float, chart: Coefficients, x: float) -> float:
        """Newton's steps on the cubic as it is written, as long as they improve it."""
        cos, sin = math.cos(away), math.sin(away)

        def residual(x: float) -> float:
            return self.value(-sin - x * cos, cos - x * sin)

        here = residual(x)
        for _ in range(NEWTON_STEPS):
            slope = _slope(chart, x)
            if here == 0 or slope == 0:
                break
            ahead = x - here / slope
            there = residual(ahead)
            if abs(there) >= abs(here):
                break
            x, here = ahead, there
        return x


def _real_roots(coefficients: Coefficients) -> list[float]:
    """Real roots of a cubic by Viete's cosines, or Cardano's formula for a single one."""
    constant, linear, square = (c / coefficients[3] for c in coefficients[:3])
    centre = -square / 3
    # y^3 - 3 p y - 2 q = 0 with x = y + centre.
    p = centre**2 - linear / 3
    q = -(((centre + square) * centre + linear) * centre + constant) / 2
    cube = p**3
    if cube > 0 and q * q <= cube:
        third = math.acos(max(-1.0, min(1.0, q / math.sqrt(cube)))) / 3
        return [centre + 2 * math.sqrt(p) * math.cos(third + turn) for turn in THIRDS]
    larger = math.copysign(math.cbrt(abs(q) + math.sqrt(max(q * q - cube, 0.0))), q)
    return [centre + larger + p / larger] if larger else [centre]


def _slope(coefficients: Coefficients, x: float) -> float:
    _, linear, square, leading = coefficients
    return (3 * leading * x + 2 * square) * x + linear


def _half_turn(angle: float) -> float:
    """The angle from -pi/2 to pi/2."""
    return math.remainder(angle, math.pi)
