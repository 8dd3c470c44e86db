"""One hammer test at one crank angle: what was recorded, estimated and identified."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.plan import RecordPlan
from flexmech.analyses.hammer.request import HammerRequest
from flexmech.analyses.hammer.transient import taken_record
from flexmech.modal_testing import (
    FrfEstimate,
    IdentifiedModes,
    estimate_frf,
    identify,
    with_noise,
)
from flexmech.types import ComplexArray, FloatArray, LabelledProgress

__all__ = ["Measurement", "measured"]

# Modes up to this multiple of the bandwidth are superposed; the rest adds its flexibility.
SUPERPOSED = 2.0
# Lines at which the direct solution is compared with the superposition of all modes.
CHECKED_LINES = 64


@dataclass(frozen=True, eq=False)
class Measurement:
    """A test of one impact point and one response point.

    Parameters
    ----------
    locked : LockedLinkage
    force, response : ndarray, shape (A, N)
        Records with their noise, in N and m.
    estimate : FrfEstimate
        At the lines kept, (F,).
    exact, superposed : ndarray of complex, shape (F,)
        Receptance of the eigen model by all modes, and by those up to twice the bandwidth with
        the residual term.
    residual : float
        That term: static flexibility of the modes left out in m/N.
    direct_difference : float
        Greatest difference of the direct solution from ``exact`` over the peak.
    poles : ndarray of complex, shape (k,)
        Of the eigen model in the band.
    modes : IdentifiedModes
        In the order of ``poles``.
    seen, hit : ndarray, shape (1, n)
        Rows of the response point and of the impact point.
    """

    locked: LockedLinkage
    force: FloatArray
    response: FloatArray
    estimate: FrfEstimate
    exact: ComplexArray
    superposed: ComplexArray
    residual: float
    direct_difference: float
    poles: ComplexArray
    modes: IdentifiedModes
    seen: FloatArray
    hit: FloatArray

    def exact_at(self, frequency: FloatArray) -> ComplexArray:
        """Exact receptance at frequencies (F,) in Hz, with what the window adds; (F,)."""
        shift = self.estimate.added_damping
        return self.locked.receptance(self.seen, self.hit, frequency, shift)[:, 0, 0]


def measured(
    locked: LockedLinkage,
    plan: RecordPlan,
    request: HammerRequest,
    number: int,
    report: LabelledProgress,
) -> Measurement:
    """Take the records of one crank angle, and identify the modes.

    Parameters
    ----------
    locked : LockedLinkage
    plan : RecordPlan
    request : HammerRequest
    number : int
        Of the crank angle, for its noise.
    report : callable
        Shows the progress.

    Returns
    -------
    Measurement

    Raises
    ------
    InputError
        As of :func:`flexmech.analyses.hammer.hammer_test`.
    ComputationError
        If a step of Exudyn does not converge.
    """
    label = f"hammer at {np.degrees(locked.angle):.6g} deg"
    hit = locked.rows([request.impact], request.direction)
    seen = locked.rows([request.response], request.direction)
    record = taken_record(
        locked,
        plan,
        request.impact,
        request.response,
        request.direction,
        lambda done, total: report(label, done, total),
    )
    generator = np.random.default_rng([request.seed, number])
    force, response = (
        with_noise(np.tile(signal, (request.averages, 1)), request.noise, generator)
        for signal in (record.force, record.response)
    )
    estimate = _in_band(
        estimate_frf(
            force,
            response,
            plan.sampling_rate,
            force_window=plan.force_window,
            exponential_window=plan.window,
        ),
        plan.bandwidth,
    )
    lines, shift = estimate.frequency, plan.decay_rate
    exact = locked.receptance(seen, hit, lines, shift)[:, 0, 0]
    kept = locked.modes.below(SUPERPOSED * plan.bandwidth)
    superposed = locked.modes.receptance(seen, hit, lines, kept, shift=shift)[:, 0, 0]
    some = lines[:: max(1, len(lines) // CHECKED_LINES)]
    gap = locked.direct(seen, hit, some) - locked.receptance(seen, hit, some)
    poles = locked.poles(plan.bandwidth)
    modes = identify(
        lines,
        estimate.h1[None],
        band=(0.0, plan.bandwidth),
        expected=np.abs(poles) / (2 * np.pi),
        method=request.method,
        added_damping=shift,
    )
    return Measurement(
        locked,
        force,
        response,
        estimate,
        exact,
        superposed,
        float(locked.modes.residual(seen, hit, kept)[0, 0]),
        float(np.abs(gap).max() / np.abs(exact).max()),
        poles,
        modes,
        seen,
        hit,
    )


def _in_band(whole: FrfEstimate, bandwidth: float) -> FrfEstimate:
    """The lines above zero and up to the bandwidth."""
    kept = (whole.frequency > 0) & (whole.frequency <= bandwidth * (1 + 1e-9))
    return FrfEstimate(
        frequency=whole.frequency[kept],
        h1=whole.h1[kept],
        h2=whole.h2[kept],
        coherence=whole.coherence[kept],
        added_damping=whole.added_damping,
    )
