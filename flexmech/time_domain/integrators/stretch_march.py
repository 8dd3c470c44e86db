"""Lobatto's fourth-order method for links that stretch by the square of their slopes.

The linear part of a double step is solved as in
:mod:`flexmech.time_domain.integrators.stage_operators`. The nonlinear forces are
iterated by a modified Newton's method with the tangent of the straight links. Within a pass the
links first relax the stretch by their slopes, which is most of the solution; the remaining tension
then acts on the slopes (block Gauss-Seidel). Slopes are small, so that a pass gains about two
digits; where it does not, Newton's method takes the tangent of the bowed links.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import partial

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import VibrationState
from flexmech.dynamical_systems.lobatto import MARCH_ON, PREDICTION, RATE_BY_POSITION, STAGES
from flexmech.errors import ComputationError
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations_of_motion.equations import StaticExpansion
from flexmech.time_domain.equations_of_motion.linkage_stretch import (
    LinkageStretch,
    PinRotations,
    StretchForces,
)
from flexmech.time_domain.integrators.position_table import PositionTable
from flexmech.time_domain.integrators.stage_operators import StageOperators, stage_operators

logger = logging.getLogger(__name__)


# Passes of the modified Newton's method in every double step of a block; more where the last of
# them changes the positions by more than this part of the greatest H^2 z''. Over a turn of the
# aluminium linkage at 20 rad/s two passes change them by 3e-4 and leave an error of 2e-5. Where a
# pass gains less, what it leaves builds up from step to step: of links that bow deeply, changes of
# 1e-2 cost the energy balance.
PASSES = (2, 3, 4, 6)
LAST_CHANGE = 1e-3
# A pass gains about two digits: after a change that is smaller by this, the next block begins
# with the fewest passes again.
AMPLE = 30
# Newton's method with the tangent of the bowed links. Five or six passes lead to a change whose
# square is less than round-off; a step that takes twice as many is too long.
NEWTON_PASSES = 12
NEWTON_CHANGE = 1e-9
# Links at rest in their frames have no H^2 z'' to measure changes by: then this part of z is taken
# in its place, in a pass and in Newton's method. Both leave 1e-9 to 1e-12 of z, above round-off.
STILL, NEWTON_STILL = 1e-6, 1e-3
# Double steps whose operators are interpolated at once. Speed alone: they stay in the cache.
CACHED_STEPS = 32
# Taylor's polynomial at the stages, from z, H z' and H^2 z'' at the start.
TAYLOR = np.array([[1.0, 1 / 2, 1 / 8], [1.0, 1.0, 1 / 2]])
# The line through the last two stages at the next two.
EXTRAPOLATE = np.array([[-1.0, 2.0], [-2.0, 3.0]])


class UnbalancedStepError(ComputationError):
    """Newton's method fails in a step of this length; a shorter step may converge."""


class StretchMarch:
    """Time stepping of a linkage with second-order stretch.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        h in s, half a double step.
    load : sequence of ndarray, shape (n_link,), optional
        Forces on the reduced links in their frames, of which a run can take any part at any
        time. The loads of the mechanism over tables act besides.

    Attributes
    ----------
    stride : int
        A run takes a multiple of so many steps.
    """

    stride = STAGES

    def __init__(
        self, linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None = None
    ) -> None:
        assert linkage.stretch is not None
        self._linkage, self._stretch = linkage, linkage.stretch
        self._step = step
        # Not by a method of its own: what refers to itself is kept until memory is searched for it.
        solve = partial(_double_steps, linkage, step, load)
        self._table = PositionTable(linkage, solve, reach=step)
        self._forces = StretchForces(linkage.stretch, STAGES, 2 * step)
        self.restart()

    def restart(self) -> None:
        """Prepare for another run: discard the state of the last one."""
        self._passes = 0
        self._last: FloatArray | None = None

    def advance(
        self, time: FloatArray, state: VibrationState, force: FloatArray | None = None
    ) -> tuple[VibrationState, StaticExpansion]:
        """Advance from the first of some times to the others.

        Parameters
        ----------
        time : ndarray, shape (2 m + 1,)
            In s, one step apart.
        state : VibrationState
            At the first of them, arrays of shape (n,).
        force : ndarray, shape (2 m + 1,), optional
            Amplitude of the load at these times; needed where there is one.

        Returns
        -------
        VibrationState
            Arrays of shape (2 m + 1, n).
        StaticExpansion
            At the same times.

        Raises
        ------
        UnbalancedStepError
            If Newton's method does not converge in a step.
        """
        double = 2 * self._step
        parts = (state.position, double * state.velocity, double**2 * state.acceleration)
        history = np.empty((3, len(time), len(state.position)))
        history[:, 0] = parts
        for first in range(0, len(time) - 1, STAGES * CACHED_STEPS):
            some = slice(first + 1, min(first + 1 + STAGES * CACHED_STEPS, len(time)))
            acting = None if force is None else force[some]
            rows = self._rows(time[some], acting)
            history[:, some] = self._block(rows, history[:, first])
        whole = VibrationState(history[0], history[1] / double, history[2] / double**2)
        return whole, StaticExpansion.of_all(self._linkage.size)

    def _rows(self, time: FloatArray, force: FloatArray | None) -> StageOperators:
        """Operators at middles and ends, (2 m,); valid until the next call."""
        resistance, own, compliance, relaxation, turn, rate, units = self._table.at(time[1::STAGES])
        if units.shape[2]:
            acting = self._linkage.histories(time, force).reshape(len(own), STAGES, 1, -1)
            own = own + (acting @ units)[:, :, 0]
        return StageOperators(resistance, own, compliance, relaxation, PinRotations(turn, rate))

    def _block(self, rows: StageOperators, start: FloatArray) -> FloatArray:
        """Positions, rates and their rates, times H, of all stages from those at the start.

        Parameters
        ----------
        rows : StageOperators
            Of m double steps.
        start : ndarray, shape (3, n)

        Returns
        -------
        ndarray, shape (3, 2 m, n)
        """
        for passes in PASSES:
            if passes < self._passes:
                continue
            self._passes = passes
            history, change = self._fixed_passes(rows, start, passes)
            bent = max(_greatest(history[2]), STILL * _greatest(history[0]))
            if change <= LAST_CHANGE * bent < np.inf:
                if AMPLE * change <= LAST_CHANGE * bent:
                    self._passes = 0
                return history
            logger.info("modified Newton's method: %d passes do not do", passes)
        self._last = None
        return _newton(rows, self._forces, self._stretch, start, 2 * self._step)

    def _fixed_passes(
        self, rows: StageOperators, start: FloatArray, passes: int
    ) -> tuple[FloatArray, float]:
        """History of :meth:`_block`, and greatest change of positions by the last pass."""
        forces, size, width = self._forces, start.shape[1], self._stretch.size
        steps, ends = len(rows.force), slice(self._stretch.end_count)
        turns = np.swapaxes(rows.turns.turn, 2, 3)
        rates_by_ends = _rates_by_ends(rows.turns, 2 * self._step)
        # z, H z' and H^2 z'' at the start of each double step, and z at both its stages.
        known = np.empty((steps + 1, 3 + STAGES, size))
        known[0, :3] = start
        before = np.empty((steps, STAGES, size))
        # Forces and second-order tensions at all stages, those of the step before first.
        taken = np.empty((steps + 1, STAGES, width + len(self._stretch.gradient)))
        taken[0] = self._at_start(rows, start) if self._last is None else self._last
        place, rate = forces.place, forces.rate
        position, own_rate, dependent_rate = place[:, :size], rate[:, :size], rate[:, size:]
        # z and H z' at the stages as the start alone makes them, and the dependent ends with these.
        predicted, dependent = np.empty((STAGES, 2, size)), np.empty((STAGES, 2, width - size))
        flat_predicted, stages = predicted.reshape(-1, size), predicted.reshape(STAGES, -1)
        ahead, ahead_rate, ends_ahead = predicted[:, 0], predicted[:, 1], predicted[:, :, ends]
        resisted, by_position = np.empty((2, STAGES, size))
        balance, placed = np.zeros((2, STAGES, width))
        load, moved = np.empty((2, STAGES, width))
        flat_load, flat_moved = load.reshape(-1), moved.reshape(-1)
        by_ends = np.empty((STAGES, width - size))
        is_damped, march_on, flat_by_ends = self._stretch.is_damped, MARCH_ON[-1], by_ends.ravel()
        add, subtract, evaluate = np.add, np.subtract, forces.evaluate
        for number, (resistance, own, compliance, relaxation, turn, rate_by_ends) in enumerate(
            zip(
                rows.resistance,
                rows.force,
                rows.compliance,
                rows.relaxation,
                turns,
                rates_by_ends,
                strict=True,
            )
        ):
            now = known[number]
            PREDICTION.dot(now[:3], flat_predicted)
            resistance[0].dot(stages[0], resisted[0])
            resistance[1].dot(stages[1], resisted[1])
            subtract(own, resisted, balance[:, :size])
            if is_damped:
                RATE_BY_POSITION.dot(ahead, by_position)
                subtract(ahead_rate, by_position, ahead_rate)
            np.matmul(ends_ahead, turn, dependent)
            placed[:, :size], placed[:, size:] = ahead, dependent[:, 0]
            guess = taken[number + 1]
            EXTRAPOLATE.dot(taken[number], guess)
            force, second = guess[:, :width], guess[:, width:]
            for left in range(passes, -1, -1):
                subtract(balance, force, load)
                compliance.dot(flat_load, flat_moved)
                add(moved, placed, place)
                if not left:
                    break
                if left == 1:
                    before[number] = position
                if is_damped:
                    RATE_BY_POSITION.dot(position, by_position)
                    add(ahead_rate, by_position, own_rate)
                    rate_by_ends.dot(place[:, ends].ravel(), flat_by_ends)
                    add(by_ends, dependent[:, 1], dependent_rate)
                force = evaluate(relaxation, second)
                second[:] = forces.second
            guess[:, :width] = force
            now[3:] = position
            march_on.dot(now, known[number + 1, :3])
        self._last = taken[-1]
        return _at_stages(known[:-1]), _greatest(known[:-1, 3:] - before)

    def _at_start(self, rows: StageOperators, start: FloatArray) -> FloatArray:
        """Forces and second-order tensions at the start, (p + s,)."""
        forces, turn = self._forces, rows.turns.turn[0, 0]
        forces.place[:] = self._stretch.augmented(turn, start[0][:, None])[:, 0]
        forces.rate[:] = self._stretch.augmented(turn, start[1][:, None])[:, 0]
        force = forces.evaluate()[0]
        return np.concatenate([force, forces.second[0]])


def _double_steps(
    linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None, end: FloatArray
) -> list[FloatArray]:
    """Arrays of the double steps of :class:`StretchMarch` that end at times of shape (m,)."""
    assert linkage.stretch is not None
    count = len(end)
    time = np.column_stack([end - step, end]).reshape(-1)
    equations = linkage.equations(time, tables=False)
    rows = stage_operators(equations, linkage.stretch, 2 * step)
    loaded = linkage.unit_equations(time, load)
    units = np.zeros((count, STAGES, len(loaded), linkage.size))
    for number, one in enumerate(loaded):
        units[:, :, number] = one.force.reshape(count, STAGES, -1)
    turns = (rows.turns.turn, rows.turns.rate)
    return [rows.resistance, rows.force, rows.compliance, rows.relaxation, *turns, units]


def _rates_by_ends(turns: PinRotations, double: float) -> FloatArray:
    """Rates times H of dependent ends at both stages by positions of link ends there.

    Parameters
    ----------
    turns : PinRotations
        Of m double steps.
    double : float
        H in s.

    Returns
    -------
    ndarray, shape (m, 2 f, 2 k)
        But for what the start alone makes of the link ends' own rates.
    """
    steps, _, dependent, ends = turns.turn.shape
    by_ends = RATE_BY_POSITION[:, None, :, None] * turns.turn[:, :, :, None]
    for stage in range(STAGES):
        by_ends[:, stage, :, stage] += double * turns.rate[:, stage]
    return by_ends.reshape(steps, STAGES * dependent, STAGES * ends)


def _greatest(vectors: FloatArray) -> float:
    """Greatest length of vectors of shape (..., n); not finite where passes diverge."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.einsum("...n,...n->...", vectors, vectors).max()))


def _at_stages(known: FloatArray) -> FloatArray:
    """Positions, rates and their rates at both stages, (3, 2 m, n).

    Parameters
    ----------
    known : ndarray, shape (m, 5, n)
        These at the starts of m double steps, and positions at their stages.
    """
    found = MARCH_ON.reshape(-1, known.shape[1]) @ known
    return np.asarray(np.moveaxis(found.reshape(-1, 3, known.shape[2]), 1, 0))


def _newton(
    rows: StageOperators,
    forces: StretchForces,
    stretch: LinkageStretch,
    start: FloatArray,
    double: float,
) -> FloatArray:
    """Newton's method in every double step; shapes as of :meth:`StretchMarch._block`."""
    steps, size, width = len(rows.force), start.shape[1], stretch.size
    known = np.empty((steps + 1, 3 + STAGES, size))
    known[0, :3] = start
    for number, turn in enumerate(rows.turns.turn):
        now, augmentation = known[number], stretch.augmentation(turn)
        # Rates of augmented coordinates by the positions of both stages, but for their prediction.
        turned = np.zeros((STAGES, width, size))
        turned[:, size:, : stretch.end_count] = double * rows.turns.rate[number]
        rate = np.einsum("ij,iqn->iqjn", RATE_BY_POSITION, augmentation)
        for stage in range(STAGES):
            rate[stage, :, stage] += turned[stage]
        predicted = (PREDICTION @ now[:3]).reshape(STAGES, 2, size)
        ahead, ahead_rate = predicted[:, 0], predicted[:, 1]
        ahead_rate = ahead_rate - RATE_BY_POSITION @ ahead
        resisted = rows.resistance[number] @ predicted.reshape(STAGES, -1, 1)
        balance = np.zeros((STAGES, width))
        balance[:, :size] = rows.force[number] - resisted[..., 0]
        # Displacement z of both stages by forces on the augmented coordinates of both.
        compliance = (
            rows.compliance[number].reshape(STAGES, width, -1)[:, :size].reshape(STAGES * size, -1)
        )
        now[3:] = TAYLOR @ now[:3]
        for _ in range(NEWTON_PASSES):
            forces.place[:] = (augmentation @ now[3:, :, None])[..., 0]
            forces.rate[:] = np.einsum("iqjn,jn->iq", rate, now[3:])
            forces.rate += (augmentation @ ahead_rate[..., None])[..., 0]
            pulled = (balance - forces.evaluate()).reshape(-1)
            gap = now[3:] - ahead - (compliance @ pulled).reshape(STAGES, size)
            elastic, damped = forces.tangents()
            tangent = np.einsum("iqp,ipjn->iqjn", damped, rate)
            for stage in range(STAGES):
                tangent[stage, :, stage] += elastic[stage] @ augmentation[stage]
            whole = np.eye(STAGES * size) + compliance @ tangent.reshape(STAGES * width, -1)
            change = np.linalg.solve(whole, gap.reshape(-1)).reshape(STAGES, size)
            now[3:] -= change
            bent = np.abs(now[4] - 2 * now[3] + now[0]).max()
            if np.abs(change).max() <= NEWTON_CHANGE * max(bent, NEWTON_STILL * np.abs(now).max()):
                break
        else:
            raise UnbalancedStepError(
                "links that bow deeply have no balance in a time step of "
                f"{double / STAGES:.4g} s; choose a smaller --step (of a hammer test: a wider "
                "--bandwidth)"
            )
        known[number + 1, :3] = MARCH_ON[-1] @ now
    return _at_stages(known[:-1])
