"""Motion of bodies without a closed form: numerical continuation from the drawn posture.

The posture is continued once around the turn in adaptive steps (predictor and Newton corrector)
and stored. Positions at given crank angles start from the neighbouring stored postures, all at
once. The sign of the Jacobian's determinant distinguishes the branches: it is constant along the
path.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import AssemblyError, ComputationError, InputError
from flexmech.linkages.body_motion import BodyMotion
from flexmech.linkages.change_points import in_degrees
from flexmech.linkages.constraints import Constraints
from flexmech.linkages.motion import LOCKING_SINE
from flexmech.linkages.planar.bodies import (
    GROUND_BODY,
    Bodies,
    GuidedPoint,
    Refusal,
    SharedPoint,
)
from flexmech.linkages.planar.drawing import Drawing

Known = Callable[[FloatArray], Mapping[int, BodyMotion]]
"""Motion of the bodies that are known before, at crank angles of shape (B,)."""

# Of the crank angle along the way, in rad. Cubic polynomials over the largest one guess a posture
# to about 1e-5 where no dead point is near; a step that is too long is halved. Where steps become
# as small as the smallest one the group locks, at an angle that is told to six digits.
LARGEST_STEP, SMALLEST_STEP = 0.15, 1e-7
# What a prediction may miss along the way, in rad and in parts of the size: about a degree, where
# two postures that are nearer to each other than ten of them are next to a dead point.
MOST_MISSED = 0.02
# A bound of work. Newton's method doubles the digits each time: four or five from a guess of two;
# more than 20 are a sign that it does not converge.
ITERATIONS = 20
# Between the first and the last posture of a turn in rad and parts of the size: the way around
# leaves round-off alone, and another posture is far away.
SAME_POSTURE = 1e-8


@dataclass(frozen=True)
class ContinuationPath:
    """Continuation path of a group: postures over the turn from the drawn one.

    Parameters
    ----------
    angle : ndarray, shape (N,)
        Crank angle less that of the drawing in rad, ascending; less than half a turn both
        ways where the linkage locks.
    unknowns, slope : ndarray, shape (N, n)
        Unknowns and their derivatives by the crank angle; lengths in parts of the size.
    sign : float
        Of the determinant.
    locks : tuple of str
        Joint that locks at each end of the range; empty where it is half a turn away.
    """

    angle: FloatArray
    unknowns: FloatArray
    slope: FloatArray
    sign: float
    locks: tuple[str, str]

    def guess(self, angle: FloatArray) -> FloatArray:
        """Unknowns between the postures, by cubic polynomials; shape (B, n)."""
        return np.asarray(
            scipy.interpolate.CubicHermiteSpline(self.angle, self.unknowns, self.slope)(angle)
        )


class NewtonGroup:
    """Bodies whose positions are solved together.

    Parameters
    ----------
    drawing : Drawing
    bodies : Bodies
    joints : tuple of SharedPoint and GuidedPoint
        As many equations as unknowns.
    unknown : tuple of int
        The bodies, in order.
    drawn_at : float
        Crank angle of the drawing in rad.
    """

    def __init__(
        self,
        drawing: Drawing,
        bodies: Bodies,
        joints: tuple[SharedPoint | GuidedPoint, ...],
        unknown: tuple[int, ...],
        drawn_at: float,
    ) -> None:
        self.bodies = bodies
        self.drawn_at = drawn_at
        self.size = drawing.size
        self.constraints = Constraints([own.condition(drawing) for own in joints], unknown)
        self._joints = joints
        self.unknown = list(unknown)
        starts = (drawing.link(bodies.links[body][0]).points[0] for body in unknown)
        self._drawn = np.array([drawing.complex_point(start) for start in starts])
        self._scale = np.tile([self.size, self.size, 1.0], len(unknown))

    @property
    def names(self) -> str:
        """Names of the links that are solved together, for messages."""
        return ", ".join(self.bodies.name(body) for body in self.unknown)

    def motion(
        self, known: Mapping[int, BodyMotion], angle: FloatArray, path: ContinuationPath
    ) -> dict[int, BodyMotion]:
        """Motion of the group's bodies.

        Parameters
        ----------
        known : mapping of int to BodyMotion
            At the crank angles.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        path : ContinuationPath

        Returns
        -------
        dict of int to BodyMotion

        Raises
        ------
        InputError
            Beyond the crank angles at which the linkage locks.
        ComputationError
            If Newton's method does not end on the path.
        """
        self._refuse_beyond(angle, path)
        guess = path.guess(angle)
        found, ended = self._solved(known, guess)
        matrix = self._scaled_jacobian(known, found)
        sign = np.linalg.slogdet(matrix)[0]
        missed = np.abs(found - guess).max(axis=-1)
        lost = np.logical_not(ended) | (sign != path.sign) | (missed > MOST_MISSED)
        if np.any(lost):
            raise ComputationError(
                f"no position of {self.names} is found at {in_degrees(angle[lost][0])} past the "
                "drawing by Newton's method; draw the linkage at a crank angle nearer to it"
            )
        return self._with_rates(known, found, matrix)

    def trace_path(self, known: Known) -> ContinuationPath:
        """Continue the drawn posture half a turn in both directions.

        Parameters
        ----------
        known : callable
            Crank angles less that of the drawing, shape (B,), to motions of the bodies that
            are known before.

        Returns
        -------
        ContinuationPath

        Raises
        ------
        InputError
            If the linkage does not come back to the drawn posture after a turn.
        """
        start = np.zeros((1, len(self._scale)))
        matrix = self._scaled_jacobian(known(np.zeros(1)), start)
        sign = float(np.linalg.slogdet(matrix)[0][0])
        back, ahead = (self._half(known, way, sign) for way in (-1.0, 1.0))
        columns = zip(*back[0][:0:-1], *ahead[0], strict=True)
        angle, unknowns, slope = (np.array(column) for column in columns)
        locks = (back[1], ahead[1])
        if not any(locks):
            self._check_period(unknowns)
        return ContinuationPath(angle, unknowns, slope, sign, locks)

    def refuse_locking(self, known: Mapping[int, BodyMotion]) -> None:
        """Refuse a drawing in a dead point.

        Parameters
        ----------
        known : mapping of int to BodyMotion
            In the drawing; shape (1,).

        Raises
        ------
        InputError
            Names the joint.
        """
        start = np.zeros(len(self._scale))
        matrix = self._scaled_jacobian(known, start[None])[0]
        if np.linalg.svd(matrix, compute_uv=False)[-1] < LOCKING_SINE:
            self.refusal(self._loosest_joint(known, start)).refuse(
                "locked", np.array([True]), np.zeros(1)
            )

    def as_drawn(self, known: Mapping[int, BodyMotion]) -> dict[int, BodyMotion]:
        """Motion of the group's bodies in the drawn posture."""
        start = np.zeros((1, len(self._scale)))
        return self._with_rates(known, start, self._scaled_jacobian(known, start))

    def _refuse_beyond(self, angle: FloatArray, path: ContinuationPath) -> None:
        ends = ((angle < path.angle[0], 0), (angle > path.angle[-1], -1))
        for beyond, end in ends:
            if np.any(beyond):
                refusal = self.refusal(path.locks[end])
                limit = in_degrees(refusal.drawn_at + path.angle[end])
                raise AssemblyError(
                    f"the linkage cannot be assembled at crank angle "
                    f"{refusal.first(beyond, angle)}: from the drawing on it locks at crank angle "
                    f"{limit}, where {refusal.links} are in "
                    f"a dead point at joint {refusal.joint}; choose crank angles inside its range "
                    "of motion or other dimensions"
                )

    def refusal(self, joint: str) -> Refusal:
        """Message for a joint of the group."""
        return Refusal(joint, self.names, self.drawn_at)

    def _check_period(self, unknowns: FloatArray) -> None:
        apart = unknowns[-1] - unknowns[0]
        apart[2::3] -= 2 * np.pi * np.round(apart[2::3] / (2 * np.pi))
        if np.abs(apart).max() > SAME_POSTURE:
            raise InputError(
                f"after a turn of the crank {self.names} do not come back to where they are "
                "drawn; a posture by the crank angle alone does not exist for this linkage"
            )

    def _half(
        self, known: Known, way: float, sign: float
    ) -> tuple[list[tuple[float, FloatArray, FloatArray]], str]:
        """Crank angle, unknowns and slopes of postures over half a turn; joint that ends it."""
        angle, step = 0.0, LARGEST_STEP
        now = np.zeros(len(self._scale))
        slope, bend = self._slopes(known(np.zeros(1)), now)
        kept = [(angle, now, slope)]
        while angle < np.pi:
            step = min(step, np.pi - angle)
            ahead = way * step
            there = angle + step if angle + step < np.pi - SMALLEST_STEP else np.pi
            guess = now + ahead * slope + ahead**2 / 2 * bend
            taken = self._step(known, way * there, guess, sign)
            if taken is None:
                step /= 2
                if step < SMALLEST_STEP:
                    joint = self._loosest_joint(known(np.array([way * angle])), now)
                    return kept, joint
                continue
            angle, (now, slope, bend, missed) = there, taken
            kept.append((way * angle, now, slope))
            # The prediction misses in proportion to the third power of the step.
            wish = (MOST_MISSED / 4 / max(missed, ROUND_OFF)) ** (1 / 3)
            step = min(LARGEST_STEP, step * float(np.clip(wish, 0.5, 2.0)))
        return kept, ""

    def _step(
        self, known: Known, angle: float, guess: FloatArray, sign: float
    ) -> tuple[FloatArray, FloatArray, FloatArray, float] | None:
        """Unknowns, slope and bend at the next angle; None where the step was too long."""
        try:
            there = known(np.array([angle]))
        except InputError:
            # What drives the group locks first; the step ends before it.
            return None
        found, ended = self._solved(there, guess[None])
        missed = float(np.abs(found[0] - guess).max())
        if not ended[0] or not missed <= MOST_MISSED:
            return None
        matrix = self._scaled_jacobian(there, found)
        if np.linalg.slogdet(matrix)[0][0] != sign:
            return None
        slope, bend = self._slopes(there, found[0])
        return found[0], slope, bend, missed

    def _solved(
        self, known: Mapping[int, BodyMotion], guess: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Unknowns at the root near a guess, and whether they have converged; (B, n), (B,)."""
        found, given = guess.copy(), self._stacked_bodies(known)
        for _ in range(ITERATIONS):
            bodies = self._at(given, found)
            residual = self.constraints.gap(bodies) / self.size
            try:
                change = np.linalg.solve(self._scaled(bodies), -residual[..., None])[..., 0]
            except np.linalg.LinAlgError:
                break
            found = found + change
            if not np.all(np.isfinite(found)) or np.abs(change).max() < ROUND_OFF:
                break
        residual = self.constraints.gap(self._at(given, found)) / self.size
        return found, np.abs(residual).max(axis=-1) < ROUND_OFF

    def _stacked_bodies(self, known: Mapping[int, BodyMotion]) -> BodyMotion:
        """All bodies by their numbers; unknown ones at rest."""
        numbers = range(len(self.bodies.links))
        return BodyMotion.stacked([known.get(n, known[GROUND_BODY]) for n in numbers])

    def _at(self, bodies: BodyMotion, unknowns: FloatArray) -> BodyMotion:
        """Bodies with those of the group at rest in a posture."""
        own, x, y, phi = self.unknown, *np.moveaxis(unknowns.reshape(len(unknowns), -1, 3), -1, 0)
        drawn, place, turn = map(np.copy, (bodies.drawn, bodies.place, bodies.turn))
        drawn[own] = self._drawn
        place[:, own] = self._drawn + self.size * (x + 1j * y)
        turn[:, own] = np.exp(1j * phi)
        return replace(bodies, drawn=drawn, place=place, turn=turn)

    def _scaled(self, bodies: BodyMotion) -> FloatArray:
        """Jacobian by the unknowns in parts of the size."""
        return np.asarray(self.constraints.jacobian(bodies) * self._scale / self.size)

    def _scaled_jacobian(self, known: Mapping[int, BodyMotion], unknowns: FloatArray) -> FloatArray:
        return self._scaled(self._at(self._stacked_bodies(known), unknowns))

    def _slopes(
        self, known: Mapping[int, BodyMotion], unknowns: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of one posture's unknowns by the crank angle."""
        matrix = self._scaled_jacobian(known, unknowns[None])
        moved = self._rates(known, unknowns[None], matrix)
        first, second = (rate.ravel() / self._scale for rate in moved[1])
        return first, second

    def _with_rates(
        self, known: Mapping[int, BodyMotion], unknowns: FloatArray, matrix: FloatArray
    ) -> dict[int, BodyMotion]:
        """The group's bodies with their rates; only they are returned."""
        bodies, _ = self._rates(known, unknowns, matrix)
        return {body: bodies.of(body) for body in self.unknown}

    def _rates(
        self, known: Mapping[int, BodyMotion], unknowns: FloatArray, matrix: FloatArray
    ) -> tuple[BodyMotion, list[FloatArray]]:
        """All bodies with their rates, and the derivatives (B, n) of the unknowns."""
        bodies, own = self._at(self._stacked_bodies(known), unknowns), self.unknown
        rates = []
        for derivative in (0, 1):
            left = self.constraints.gap_rates(bodies)[derivative] / self.size
            rate = np.linalg.solve(matrix, -left[..., None])[..., 0] * self._scale
            rates.append(rate)
            x, y, phi = np.moveaxis(rate.reshape(len(rate), -1, 3), -1, 0)
            place, turn = (
                getattr(bodies, f"{name}_{derivative + 1}").copy() for name in ("place", "turn")
            )
            place[:, own], turn[:, own] = x + 1j * y, phi
            moved = {f"place_{derivative + 1}": place, f"turn_{derivative + 1}": turn}
            bodies = replace(bodies, **moved)
        return bodies, rates

    def _loosest_joint(self, known: Mapping[int, BodyMotion], unknowns: FloatArray) -> str:
        """Joint with the greatest rotation in the free motion of a singular posture."""
        matrix = self._scaled_jacobian(known, unknowns[None])[0]
        free = np.linalg.svd(matrix)[2][-1]
        turning = dict(zip(self.unknown, free[2::3], strict=True))
        joints = {
            own.point: abs(turning.get(own.first, 0.0) - turning.get(own.second, 0.0))
            for own in self._joints
            if isinstance(own, SharedPoint)
        }
        return max(joints, key=lambda point: joints[point]) if joints else self.names
