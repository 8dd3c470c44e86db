"""Motion of bodies without a closed form: numerical continuation from the drawn posture.

The posture is continued once around the turn in adaptive steps (predictor and Newton corrector)
and stored. Positions at given crank angles start from the neighbouring stored postures, all at
once. The sign of the Jacobian's determinant distinguishes the branches: it is constant along the
path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from flexmech.arrays import ROUND_OFF, ComplexArray, FloatArray
from flexmech.errors import AssemblyError, ComputationError, InputError
from flexmech.linkages.body_motion import BodyMotion
from flexmech.linkages.change_points import in_degrees
from flexmech.linkages.motion import LOCKING_SINE
from flexmech.linkages.planar.bodies import Bodies, JointConstraints, Refusal, SharedPoint
from flexmech.linkages.planar.drawing import Drawing

Known = Callable[[FloatArray], BodyMotion]
"""All bodies at crank angles (B,), those in motion that are known before."""

# Steps of the crank angle along the way, in rad. Cubic polynomials over the largest one guess a
# posture to about 1e-5 where no dead point is near; a step that is too long is halved. Where steps
# become as small as the smallest one the group locks, at an angle that is printed with six digits.
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
        Sign of the determinant.
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
    joints : tuple of SharedPoint
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
        joints: tuple[SharedPoint, ...],
        unknown: tuple[int, ...],
        drawn_at: float,
    ) -> None:
        self.size, self.unknown, self.drawn_at = drawing.size, list(unknown), drawn_at
        # The axes of all bodies are those of the drawing.
        places = {point: drawing.complex_point(point) for point in drawing.points}
        self.constraints = JointConstraints(joints, unknown, lambda _, point: places[point])
        self._joints = joints
        slides = sum(joint.along is not None for joint in joints)
        self._scale = np.array([self.size, self.size, 1.0] * len(unknown) + [self.size] * slides)
        # For messages.
        self.names = ", ".join(bodies.name(body) for body in unknown)

    def move(self, bodies: BodyMotion, angle: FloatArray, path: ContinuationPath) -> None:
        """Give the bodies the motion that Newton's method finds.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing at the crank angles, (B, n); those of the group are changed.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        path : ContinuationPath

        Raises
        ------
        InputError
            Beyond the crank angles at which the linkage locks.
        ComputationError
            If Newton's method does not end on the path.
        """
        self._refuse_beyond(angle, path)
        guess = path.guess(angle)
        solved, ended = self._solved(bodies, guess)
        sign = np.linalg.slogdet(self._jacobian(bodies, solved))[0]
        missed = np.abs(solved - guess).max(axis=-1)
        lost = np.logical_not(ended) | (sign != path.sign) | (missed > MOST_MISSED)
        if np.any(lost):
            raise ComputationError(
                f"no position of {self.names} is found at {in_degrees(angle[lost][0])} past the "
                "drawing by Newton's method; draw the linkage at a crank angle nearer to it"
            )
        self._rates(bodies, solved)

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
        matrix = self._jacobian(known(np.zeros(1)), np.zeros((1, len(self._scale))))
        sign = float(np.linalg.slogdet(matrix)[0][0])
        back, ahead = (self._half(known, way, sign) for way in (-1.0, 1.0))
        columns = zip(*back[0][:0:-1], *ahead[0], strict=True)
        angle, unknowns, slope = (np.array(column) for column in columns)
        locks = (back[1], ahead[1])
        if not any(locks):
            self._check_period(unknowns)
        return ContinuationPath(angle, unknowns, slope, sign, locks)

    def fill_as_drawn(self, bodies: BodyMotion) -> None:
        """Put the bodies where they are drawn.

        Parameters
        ----------
        bodies : BodyMotion
            As drawn, (1, n); those of the group are changed.

        Raises
        ------
        InputError
            If the drawing is in a dead point; names the joint.
        """
        start = np.zeros((1, len(self._scale)))
        matrix = self._jacobian(bodies, start)[0]
        if np.linalg.svd(matrix, compute_uv=False)[-1] < LOCKING_SINE:
            refusal = self._refusal(self._loosest_joint(bodies, start[0]))
            refusal.refuse("locked", np.array([True]), np.zeros(1))

    def _refuse_beyond(self, angle: FloatArray, path: ContinuationPath) -> None:
        ends = ((angle < path.angle[0], 0), (angle > path.angle[-1], -1))
        for beyond, end in ends:
            if np.any(beyond):
                refusal = self._refusal(path.locks[end])
                limit = in_degrees(refusal.drawn_at + path.angle[end])
                raise AssemblyError(
                    f"the linkage cannot be assembled at crank angle "
                    f"{refusal.first(beyond, angle)}: from the drawing on it locks at crank angle "
                    f"{limit}, where {refusal.links} are in "
                    f"a dead point at joint {refusal.joint}; choose crank angles inside its range "
                    "of motion or other dimensions"
                )

    def _refusal(self, joint: str) -> Refusal:
        """Message for a joint of the group."""
        return Refusal(joint, self.names, self.drawn_at)

    def _check_period(self, unknowns: FloatArray) -> None:
        apart = unknowns[-1] - unknowns[0]
        angles = apart[2 : 3 * len(self.unknown) : 3]
        angles -= 2 * np.pi * np.round(angles / (2 * np.pi))
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
            after = angle + step if angle + step < np.pi - SMALLEST_STEP else np.pi
            guess = now + ahead * slope + ahead**2 / 2 * bend
            taken = self._step(known, way * after, guess, sign)
            if taken is None:
                step /= 2
                if step < SMALLEST_STEP:
                    joint = self._loosest_joint(known(np.array([way * angle])), now)
                    return kept, joint
                continue
            angle, (now, slope, bend, missed) = after, taken
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
            bodies = known(np.array([angle]))
        except InputError:
            # What drives the group locks first; the step ends before it.
            return None
        solved, ended = self._solved(bodies, guess[None])
        missed = float(np.abs(solved[0] - guess).max())
        if not ended[0] or not missed <= MOST_MISSED:
            return None
        if np.linalg.slogdet(self._jacobian(bodies, solved))[0][0] != sign:
            return None
        slope, bend = self._slopes(bodies, solved[0])
        return solved[0], slope, bend, missed

    def _solved(
        self, bodies: BodyMotion, guess: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Unknowns at the root near a guess, and whether they have converged; (B, n), (B,)."""
        unknowns = guess.copy()
        for _ in range(ITERATIONS):
            residual = self._residual(bodies, unknowns)
            try:
                jacobian = self._jacobian(bodies, unknowns)
                change = np.linalg.solve(jacobian, -residual[..., None])[..., 0]
            except np.linalg.LinAlgError:
                break
            unknowns = unknowns + change
            if not np.all(np.isfinite(unknowns)) or np.abs(change).max() < ROUND_OFF:
                break
        residual = self._residual(bodies, unknowns)
        return unknowns, np.abs(residual).max(axis=-1) < ROUND_OFF

    def _put(self, bodies: BodyMotion, unknowns: FloatArray) -> ComplexArray:
        """Put the bodies into a posture by the unknowns (B, n); where points on lines are then."""
        of_bodies, slides = np.split(unknowns, [3 * len(self.unknown)], axis=1)
        x, y, phi = np.moveaxis(of_bodies.reshape(len(unknowns), -1, 3), -1, 0)
        bodies.place[:, self.unknown] = bodies.drawn[self.unknown] + self.size * (x + 1j * y)
        bodies.turn[:, self.unknown] = np.exp(1j * phi)
        still = np.zeros_like(slides)
        return self.constraints.slid(bodies.drawn, np.stack([self.size * slides, still, still]))

    def _residual(self, bodies: BodyMotion, unknowns: FloatArray) -> FloatArray:
        """Gaps of the joints in parts of the size, (B, n)."""
        slid = self._put(bodies, unknowns)
        return self.constraints.equations.gap(bodies, slid[0]) / self.size

    def _jacobian(self, bodies: BodyMotion, unknowns: FloatArray) -> FloatArray:
        """Jacobian of the joints' conditions, lengths in parts of the size; (B, n, n)."""
        slid = self._put(bodies, unknowns)
        jacobian = self.constraints.equations.jacobian(bodies, None, slid[0])
        return np.asarray(jacobian * self._scale / self.size)

    def _rates(self, bodies: BodyMotion, unknowns: FloatArray) -> list[FloatArray]:
        """First and second derivatives of the unknowns by the crank angle, (B, n) each.

        The bodies are given theirs.
        """
        jacobian, slid = self._jacobian(bodies, unknowns), self._put(bodies, unknowns)
        rates: list[FloatArray] = []
        for order, (place, turn) in enumerate(
            ((bodies.place_1, bodies.turn_1), (bodies.place_2, bodies.turn_2)), start=1
        ):
            left = self.constraints.equations.gap_rate(bodies, slid, order) / self.size
            rates.append(np.asarray(np.linalg.solve(jacobian, -left[..., None])[..., 0]))
            of_bodies, slides = np.split(rates[-1] * self._scale, [3 * len(self.unknown)], axis=1)
            place[:, self.unknown] = of_bodies[:, 0::3] + 1j * of_bodies[:, 1::3]
            turn[:, self.unknown] = of_bodies[:, 2::3]
            slid[order] = self.constraints.along * slides
        return rates

    def _slopes(self, bodies: BodyMotion, unknowns: FloatArray) -> list[FloatArray]:
        """First and second derivative of one posture's unknowns by the crank angle."""
        return [rate[0] for rate in self._rates(bodies, unknowns[None])]

    def _loosest_joint(self, bodies: BodyMotion, unknowns: FloatArray) -> str:
        """Joint with the greatest rotation in the free motion of a singular posture."""
        free = np.linalg.svd(self._jacobian(bodies, unknowns[None])[0])[2][-1]
        turning = dict(zip(self.unknown, free[2 : 3 * len(self.unknown) : 3], strict=True))
        joints = {
            joint.point: abs(turning.get(joint.first, 0.0) - turning.get(joint.second, 0.0))
            for joint in self._joints
            if joint.along is None
        }
        return max(joints, key=lambda point: joints[point]) if joints else self.names
