"""Change points of a turn: crank angles at which a motion goes over from one branch to the other.

Two branches of a linkage meet where two links, or a link and its line, come into one line and can
leave it on either side. The motion is smooth there: it goes on to the other side of the line
(Hartenberg and Denavit, *Kinematic Synthesis of Linkages*, 1964).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import LockingError
from flexmech.linkages.motion import LOCKING_SINE

TURN = 2 * np.pi
# Samples of a turn: every degree. Clearances are smooth functions with a few extremes in a turn.
_SAMPLES = 360
# Part of a step by which samples lie beside round crank angles, where most change points are.
_ASIDE = 0.3819660113
# Least clearance at the samples beside a change point, half a degree away or less: some 1e-4.
_NEAR_ZERO = 1e-2
# Most iterations of Newton's method, which needs four: clearances are parabolas to a percent
# within a degree.
_ITERATIONS = 8
# In rad. Four places so far from the least clearance give it to some 1e-14, beside rounding.
_BESIDE, _PARABOLA = 2.5e-4, 1e-13


@dataclass(frozen=True)
class ChangePoints:
    """Change points of a motion over the crank angle, and the side on which it is between them.

    Parameters
    ----------
    reference : float
        Crank angle in rad at which the motion is on the side that is stated or drawn.
    angles : ndarray, shape (P,)
        Crank angles of the change points in rad, ascending, within half a turn of the reference.

    Examples
    --------
    >>> from flexmech.linkages import FourBar
    >>> points = FourBar(0.3, 0.1, 0.3, 0.1).change_points
    >>> np.degrees(points.angles), points.sides(np.radians([60.0, 300.0]))
    (array([  0., 180.]), array([ 1., -1.]))
    """

    reference: float = 0.0
    angles: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def returns(self) -> bool:
        """Whether a turn leads back to the side from which it started: it changes twice, or not."""
        return len(self.angles) % 2 == 0

    @property
    def limits(self) -> tuple[float, float]:
        """Crank angles in rad between which the posture follows from the crank angle alone."""
        if self.returns:
            return -np.inf, np.inf
        around = np.concatenate([self.angles - TURN, self.angles, self.angles + TURN])
        return (
            float(around[around < self.reference].max()),
            float(around[around > self.reference].min()),
        )

    def sides(self, crank_angle: FloatArray) -> FloatArray:
        """1 where the motion is on the side of the reference, -1 where it is on the other one.

        Parameters
        ----------
        crank_angle : ndarray, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (...)
        """
        if not len(self.angles) or not self.returns:
            return np.ones_like(crank_angle)
        start = self.reference - np.pi
        within = start + np.mod(crank_angle - start, TURN)
        passed = np.searchsorted(self.angles, within) - np.searchsorted(self.angles, self.reference)
        return np.asarray(1.0 - 2.0 * (passed % 2))

    def refuse(self, crank_angle: FloatArray, meeting: str, zero: float = 0.0) -> None:
        """Refuse crank angles at a change point, and those at which the posture is not known.

        Parameters
        ----------
        crank_angle : ndarray, shape (...)
            In rad.
        meeting : str
            What comes into one line at the change points, as a clause.
        zero : float
            Crank angle in rad from which the angles are counted.

        Raises
        ------
        LockingError
            Names the first of them, and which crank angles can be asked for.
        """
        if not len(self.angles):
            return
        away = crank_angle[..., None] - self.angles
        away = np.abs(away - TURN * np.round(away / TURN)).min(axis=-1)
        if np.any(met := away < LOCKING_SINE):
            at = in_degrees(zero + _first(crank_angle, met))
            raise LockingError(
                f"the linkage meets a change point at crank angle {at}: {meeting} and can leave it "
                f"on either side, so that forces are not determined there; leave out "
                f"{_listed(zero + self.angles)} or change the dimensions"
            )
        lowest, highest = self.limits
        if np.any(beyond := (crank_angle < lowest) | (crank_angle > highest)):
            angle = _first(crank_angle, beyond)
            limit = lowest if angle < lowest else highest
            raise LockingError(
                f"the linkage cannot be placed at crank angle {in_degrees(zero + angle)}: at the "
                f"change point at {in_degrees(zero + limit)} {meeting}, the motion goes on in the "
                "other branch, and a second turn alone leads back; choose crank angles between "
                f"{in_degrees(zero + lowest)} and {in_degrees(zero + highest)}"
            )


def _first(angles: FloatArray, which: NDArray[np.bool_]) -> float:
    return float(angles[which].flat[0])


def passing(angles: FloatArray) -> str:
    """Sentence without its end on the change points of a crank, at angles (P,) in rad."""
    points = "change points" if len(angles) > 1 else "a change point"
    return f"the crank meets {points} at {_listed(angles)}"


def _listed(angles: FloatArray) -> str:
    """Angles in rad as text in degrees from 0 to 360."""
    degrees = np.unique(np.round(np.degrees(angles), 9) % 360)
    return " and ".join(f"{angle:g}" for angle in degrees) + " deg"


def in_degrees(angle: float) -> str:
    """An angle in rad as text in degrees."""
    return f"{float(np.round(np.degrees(angle), 9)) + 0.0:g} deg"


@dataclass(frozen=True)
class Clearance:
    """How far loci are from touching, as the difference of the squares of two lengths.

    Parameters
    ----------
    difference : ndarray, shape (B,)
        In parts of the square of the linkage's size: positive where the loci meet in two points,
        negative where they do not meet, not a number where what drives them cannot be assembled.
    length : float
        Either length where the loci touch, in parts of the size.
    """

    difference: FloatArray
    length: float

    @classmethod
    def of(
        cls, longer: FloatArray | float, shorter: FloatArray | float, length: float, size: float
    ) -> Clearance:
        """Clearance by the lengths that are compared.

        Parameters
        ----------
        longer, shorter : ndarray, shape (A,), or float
            In m: they are equal where the loci touch.
        length : float
            Length of both where they touch, in m.
        size : float
            Size of the linkage, in m.
        """
        difference = (longer - shorter) * (longer + shorter) / size**2
        return cls(np.asarray(difference), length / size)

    def at(self, which: NDArray[np.bool_]) -> Clearance:
        """Clearance where it is known of more crank angles, of shape (A,), with B true values."""
        every = np.full(which.shape, np.nan)
        every[which] = self.difference
        return replace(self, difference=every)

    @property
    def tolerance(self) -> float:
        """Difference of lengths that are equal but for round-off."""
        return SAME_PLACE * (2 * self.length + SAME_PLACE) + _PARABOLA


def change_points_of(
    clearances: Callable[[FloatArray], Sequence[Clearance]], reference: float
) -> ChangePoints:
    """Change points over the turn around a crank angle.

    Parameters
    ----------
    clearances : callable
        Clearances of crank angles (B,) in rad.
    reference : float
        Crank angle in rad of the drawing.

    Returns
    -------
    ChangePoints
        Where a clearance has a least value that is zero within round-off of stated lengths.
    """
    start, step = reference - np.pi, TURN / _SAMPLES
    sampled = np.asarray(start + step * (np.arange(_SAMPLES) + _ASIDE), dtype=float)
    touching = []
    for number, clearance in enumerate(clearances(sampled)):
        value = clearance.difference
        least = (value <= np.roll(value, 1)) & (value <= np.roll(value, -1))
        for angle in sampled[least & (np.abs(value) < _NEAR_ZERO)].tolist():
            met = _touching(clearances, number, angle, step)
            touching += [] if met is None else [met]
    within = np.sort(start + np.mod(np.array(touching, dtype=float) - start, TURN))
    return ChangePoints(reference, within[np.diff(within, prepend=-np.inf) > step])


def _touching(
    clearances: Callable[[FloatArray], Sequence[Clearance]], number: int, start: float, step: float
) -> float | None:
    """Crank angle near a sample at which loci touch; None where they do not.

    Newton's method on the slope, by four places beside the angle, never at it: what drives the
    loci may stand there in a change point of its own.
    """
    angle, apart = start, step
    for _ in range(_ITERATIONS):
        apart = max(apart / 4, _BESIDE)
        nearby = clearances(angle + apart * np.array([-2.0, -1.0, 1.0, 2.0]))[number]
        far_back, back, ahead, far_ahead = nearby.difference.tolist()
        slope = (8 * (ahead - back) - (far_ahead - far_back)) / (12 * apart)
        curvature = (far_back + far_ahead - back - ahead) / (3 * apart**2)
        if not curvature > 0:
            return None
        angle -= slope / curvature
        if not abs(angle - start) <= 2 * step:
            return None
    least = (4 * (back + ahead) - far_back - far_ahead) / 6
    return angle if abs(least) <= nearby.tolerance else None
